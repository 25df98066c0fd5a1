"""The page of a grid: sweeps over the same seeds, of one scenario with different values of its keys, or of several."""
import json

import matplotlib
import numpy as np

from .page import COLORS, MAP_COLORS, Drawing, axes, counted, curve, number, numbers, read_json, read_rows

MOST_LETTERS = 5  # what a cell of a map must have room for
HEADING = ["reached", "collisions", "within the assumptions", "out of view, median, 95 % (s)", "settled, median, 95 % (s)",
           "over time-optimal", "clearance, 5 % (m)"]
PAIRED_HEADING = ["success less the first cell's", "settled less the first cell's (s)"]


def page(folder):
    facts, summary = read_json(folder / "report.json"), read_json(folder / "summary.json")
    keys, cells = facts["grid"], read_rows(folder / "grid.csv")
    figures = [figure for draw in FIGURES.get(len(keys), ()) for figure in draw(keys, cells)]
    names = [key["key"] for key in keys]
    paired = names != ["scenario"]
    heading = [*names, *HEADING, *PAIRED_HEADING[:2 * paired]]
    return dict(
        title=facts["title"], subtitle=f"{counted(len(cells), 'cell')}, {counted(summary['trials'], 'trial')}", summary=summary, names=names,
        heading=heading, rows=[table_row(names, paired, cell) for cell in summary["cells"]], figures=figures,
        failures=[[*(cell["values"][name] for name in names), group["outcome"], group["cause"], group["count"]]
                  for cell in summary["cells"] for group in cell["failures"]],
        scenario=json.dumps(facts["scenario"], indent=2))


def table_row(names, paired, cell):
    feasible = int(cell["trials"]) - int(cell["infeasible"])
    rate = f"{cell['reached']} of {feasible}: " + share(cell["success_rate"], cell["success_ci95"])
    interval = " to ".join(shown(value, "+.2f") for value in cell["settled_less_first_s_ci95"])
    less = [share(cell["success_less_first"], cell["success_less_first_ci95"]),
            f"{shown(cell['settled_less_first_s'], '+.2f')} ({interval})"]
    both = [", ".join(shown(cell[figure][part], ".1f") for part in ("p50", "p95"))
            for figure in ("out_of_view_s", "settled_s")]
    return [*(cell["values"][name] for name in names), rate, cell["collisions"], cell["collisions_inside_assumptions"],
            *both, shown(cell["settled_over_time_optimal"]["p50"], ".2f"), shown(cell["min_clearance_m"]["p5"], ".2f"),
            *less[:2 * paired]]


def shown(value, how):
    return format(value, how) if value is not None else "-"


def share(value, interval):
    """"97.3 % (94.8 to 98.8)" """
    middle, low, high = (100 * number(part) for part in (value, *interval))
    return f"{middle:.1f} % ({low:.1f} to {high:.1f})" if np.isfinite(middle) else "-"


def places(values):
    """Where values stand on an axis: numbers where they belong, words side by side."""
    try:
        return np.array([float(value) for value in values]), None
    except ValueError:
        return np.arange(len(values)), values


def curves(keys, cells):
    rates = [100 * numbers(cells, f"success_{name}") for name in ("rate", "ci95_low", "ci95_high")]
    settled = [numbers(cells, f"settled_s_{name}") for name in ("p50", "p50", "p95")]
    return [band(keys[0], "Reached", "reached (%)", *rates, "The band is the 95 % interval."),
            band(keys[0], "Settling time", "settled (s)", *settled, "Median, and up to 95 % of those that reached.")]


def band(key, title, label, middle, low, high, caption):
    at, words = places(key["values"])
    if words:
        plot = axes(title, label, key["key"], 480, 80 + 26 * len(words))
        plot.errorbar(middle, at, xerr=[middle - low, high - middle], fmt="o", markersize=4, capsize=3, color=COLORS[0])
        plot.set_yticks(at, words)
        plot.set_ylim(len(words) - 0.5, -0.5)
        plot.set_xlim(left=0)
        return Drawing(plot, caption.replace("band", "bar"))
    order = np.argsort(at)
    plot = axes(title, key["key"], label, 480, 300)
    plot.fill_between(at[order], low[order], high[order], color=COLORS[0], alpha=0.2, linewidth=0)
    curve(plot, at[order], middle[order], marker="o", markersize=4, color=COLORS[0])
    plot.set_ylim(bottom=0)
    return Drawing(plot, caption)


def maps(keys, cells):
    rates, low, high = (100 * numbers(cells, f"success_{name}") for name in ("rate", "ci95_low", "ci95_high"))
    settled = numbers(cells, "settled_s_p50")
    return [basin(keys, "Reached (%)", rates, [f"{r:.0f}\n{a:.0f} to {b:.0f}" if np.isfinite(r) else "-"
                                               for r, a, b in zip(rates, low, high)], 100,
                  "Under each rate its 95 % interval, where there is room for it."),
            basin(keys, "Settling time (s)", settled, [f"{s:.1f}" if np.isfinite(s) else "-" for s in settled],
                  np.nanmax(settled, initial=0) or 1, "Median of those that reached.")]


def basin(keys, title, values, shown, high, caption):
    rows, columns = (key["values"] for key in keys)
    plot = axes(title, keys[1]["key"], keys[0]["key"], np.clip(90 * len(columns) + 120, 300, 1040),
                np.clip(50 * len(rows) + 110, 220, 900))
    grid = np.reshape(values, (len(rows), len(columns)))
    image = plot.pcolormesh(np.ma.masked_invalid(grid), cmap=MAP_COLORS, vmin=0, vmax=high, edgecolors="face")
    letters = 60 * plot.figure.get_figwidth() / matplotlib.rcParams["font.size"]  # that have room along the map
    every = int(np.ceil(MOST_LETTERS / 2 * len(columns) / letters))
    plot.set_xticks(np.arange(len(columns))[::every] + 0.5, columns[::every])
    plot.set_yticks(np.arange(len(rows)) + 0.5, rows)
    if places(rows)[1]:  # words are read from above
        plot.invert_yaxis()
    if letters < MOST_LETTERS * len(columns):
        plot.figure.colorbar(image, ax=plot, label=title)
        shown = []
    for place, text in enumerate(shown):
        row, column = divmod(place, len(columns))
        plot.text(column + 0.5, row + 0.5, text, ha="center", va="center", fontsize="small",
                  bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 1.5}, color="black")
    return Drawing(plot, caption)


FIGURES = {1: [curves], 2: [maps]}
