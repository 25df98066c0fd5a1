"""The page of a colours file: what its classes are, what they share, which light they bear, how they were learnt."""
import numpy as np

from .page import MAP_COLORS, Drawing, axes, counted, goal_line, number, percent, photo, read_json, text_of

OF_ALL_PICTURES = ("c_chroma", "d_groups", "f_table")  # panels that are the same whichever picture they stand beside
WIDEST_PX = 900
LEAST_SHARE = 0.005
LINE_PX = 26


def page(folder):
    facts = read_json(folder / "report.json")
    classes, pictures = facts["classes"], facts["pictures"]
    learnt = [(name, c["source"], c["frame"], *(f"{number(c[key]):.1f}" for key in ("cx_px", "cy_px", "r_px")),
               text_of(c["fit_ratio"])) for name, color in classes.items() for c in color["circles"]]
    return dict(
        title=f"Colours: {facts['file']}", facts=facts, rows=[class_row(*item) for item in classes.items()],
        subtitle=f"{counted(len(classes), 'class', 'classes')}, "
        + (f"learnt from {listed(facts['sources'])}" if facts["sources"] else "as the file holds them"),
        settings=list(facts["camera_settings"].items()), learnt=learnt,
        bears=bears(classes),
        panels=[shown(folder, panel, None) for panel in (pictures or [[]])[0] if panel["name"] in OF_ALL_PICTURES],
        pictures=[shown(folder, panel, WIDEST_PX) for panels in pictures for panel in panels
                  if panel["name"] not in OF_ALL_PICTURES])


def bears(classes):
    light = [color["light"] for color in classes.values()]
    figures = [
        ranges(classes, "Strength of the light", "times the strength when taught", (1 / 17, 17),
               [(of["level_low"], of["level_high"]) for of in light], "As long as the light is within the bar, more than "
               "half of the pixels stay of the class. Tried: 1/16 to 16. Dashed: as taught.", 1),
        ranges(classes, "Colour of the light", "temperature of a light that was 6500 K (K)", (1600, 26000),
               [(of["warmest_k"], of["coolest_k"]) for of in light],
               "The same for lamps (left) and shade (right). Tried: 1667 to 25000 K. Dashed: as taught.", 6500),
        ranges(classes, "Fading towards grey", "chroma (Lab)", (0, None),
               [(color["dissolves_at_chroma"], color["chroma"]) for color in classes.values()],
               "From the median of the pixels (right) down to where less than half are still of the class, as haze, glare and "
               "blur make them.")]
    return figures + [given_to(classes)] if len(classes) > 1 else figures


def listed(names, most=4):
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def kelvin(temperature):
    """Only as many digits as mean something."""
    return text_of(round(number(temperature) / 100, 0) * 100 if temperature else None, 0)


def class_row(name, color):
    light, others = color["light"], sorted(color["shared"].items(), key=lambda item: -item[1])
    return [name, len(color["circles"]) or "-", color["samples"], color["table_cells"], percent(color["kept_fraction"]),
            ", ".join(f"{other} {percent(share)}" for other, share in others if share >= LEAST_SHARE) or "-",
            percent(color["background_fraction"], 2), text_of(color["chroma"], 0), text_of(color["dissolves_at_chroma"], 0),
            f"{number(light['level_low']):.2g} to {number(light['level_high']):.2g}",
            f"{kelvin(light['warmest_k'])} to {kelvin(light['coolest_k'])}"]


def painted(color):
    """What a class is drawn in: its mean colour, bright enough for any paper."""
    rgb = np.clip(np.nan_to_num([number(part) for part in color["rgb"]]), 0, 255)
    return rgb / max(255, *rgb) if max(rgb) == 0 else 0.9 * rgb / max(rgb)


def ranges(classes, title, label, limits, ends, caption, taught=None):
    """A bar a class from its low to its high end."""
    plot = axes(title, label, "", 480, LINE_PX * len(classes) + 100, "x" if taught else "")
    for place, (color, (low, high)) in enumerate(zip(classes.values(), ends)):
        plot.barh(place, number(high) - number(low), 0.6, number(low), color=painted(color))
    plot.set_yticks(range(len(classes)), classes)
    plot.set(xlim=limits, ylim=(len(classes) - 0.5, -0.5))
    if taught:
        goal_line(plot, taught, vertical=True)
    return Drawing(plot, caption)


def given_to(classes):
    """Each class's pixels by the class that the table gives them."""
    names = list(classes)
    shares = np.zeros((len(names), len(names) + 1))
    for row, (name, color) in enumerate(classes.items()):
        shares[row, :-1] = [color["overlap"].get(other, 0) if other != name else color["kept_fraction"] for other in names]
        shares[row, -1] = max(0, 1 - shares[row].sum())
    plot = axes("What the table makes of each class's pixels", "", "", 480, LINE_PX * len(names) + 130)
    plot.pcolormesh(shares, cmap=MAP_COLORS, vmin=0, vmax=1, edgecolors="face")
    for (row, column), share in np.ndenumerate(shares):
        if share >= LEAST_SHARE:
            plot.text(column + 0.5, row + 0.5, f"{100 * share:.0f}", ha="center", va="center", fontsize="small",
                      color="black" if share > 0.6 else "white")
    plot.set_xticks(np.arange(len(names) + 1) + 0.5, [*names, "none"], rotation=0 if len(names) < 5 else 90)
    plot.set_yticks(np.arange(len(names)) + 0.5, names)
    plot.invert_yaxis()
    plot.grid(False)
    return Drawing(plot, "A row a class, in percent: the class that the table gives its pixels to.")


def shown(folder, panel, widest_px):
    return photo(folder, panel["file"], panel["caption"], widest_px)
