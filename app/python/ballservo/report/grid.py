"""The page of a grid: sweeps of one scenario over the same seeds, with different values of its keys."""
import json

import numpy as np

from .page import COLORS, MAP_COLORS, axes, curve, drawing, number, numbers, read_json, read_rows, render
from .sweep import percent, rate


def page(folder):
    facts, summary = read_json(folder / "report.json"), read_json(folder / "summary.json")
    keys, cells = facts["grid"], read_rows(folder / "grid.csv")
    figures = [figure for draw in FIGURES.get(len(keys), ()) for figure in draw(keys, cells)]
    names = [key["key"] for key in keys]
    heading = [*names, "reached", "collisions", "settled, median (s)", "success less the first cell's",
               "settled less the first cell's (s)"]
    return render("grid.html", title=facts["title"], subtitle=f"{len(cells)} cells, {summary['trials']} trials", summary=summary, names=names, heading=heading,
                  rows=[table_row(names, cell) for cell in summary["cells"]], figures=figures,
                  scenario=json.dumps(facts["scenario"], indent=2))


def feasible(cell):
    return int(cell["trials"]) - int(cell["infeasible"])


def table_row(names, cell):
    low, high = map(percent, cell["success_less_first_ci95"])
    early, late = map(number, cell["settled_less_first_s_ci95"])
    return [*(cell["values"][name] for name in names), rate(cell["reached"], feasible(cell), cell["success_ci95"]),
            cell["collisions"], f"{number(cell['settled_s']['p50']):.2f}",
            f"{percent(cell['success_less_first'])} ({low} to {high})",
            f"{number(cell['settled_less_first_s']):+.2f} ({early:+.2f} to {late:+.2f})"]


def places(values):
    """Where values stand on an axis: numbers where they belong, words side by side."""
    try:
        return np.array([float(value) for value in values]), None
    except ValueError:
        return np.arange(len(values)), values


def curves(keys, cells):
    key = keys[0]
    at, words = places(key["values"])
    order = np.argsort(at)

    def plot_of(title, label, middle, low, high, caption):
        plot = axes(title, key["key"], label, 480, 300)
        plot.fill_between(at[order], low[order], high[order], color=COLORS[0], alpha=0.2, linewidth=0)
        curve(plot, at[order], middle[order], marker="o", markersize=4, color=COLORS[0])
        if words:
            plot.set_xticks(at, words)
        plot.set_ylim(bottom=0)
        return drawing(plot, caption)

    rates = [100 * numbers(cells, f"success_{name}") for name in ("rate", "ci95_low", "ci95_high")]
    settled = [numbers(cells, f"settled_s_{name}") for name in ("p50", "p50", "p95")]
    return [plot_of("Reached", "reached (%)", *rates, "The band is the 95 % interval."),
            plot_of("Settling time", "settled (s)", *settled, "Median, and up to 95 % of those that reached.")]


def maps(keys, cells):
    rows, columns = (key["values"] for key in keys)

    def plot_of(title, values, shown, high):
        plot = axes(title, keys[1]["key"], keys[0]["key"], max(300, 90 * len(columns) + 120),
                    max(220, 50 * len(rows) + 110))
        grid = np.reshape(values, (len(rows), len(columns)))
        plot.pcolormesh(np.ma.masked_invalid(grid), cmap=MAP_COLORS, vmin=0, vmax=high, edgecolors="face")
        plot.set_xticks(np.arange(len(columns)) + 0.5, columns)
        plot.set_yticks(np.arange(len(rows)) + 0.5, rows)
        for place, text in enumerate(shown):
            row, column = divmod(place, len(columns))
            plot.text(column + 0.5, row + 0.5, text, ha="center", va="center", fontsize=9,
                      bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 1.5}, color="black")
        return drawing(plot, CAPTIONS[title])

    rates, low, high = (100 * numbers(cells, f"success_{name}") for name in ("rate", "ci95_low", "ci95_high"))
    settled = numbers(cells, "settled_s_p50")
    return [plot_of("Reached (%)", rates, [f"{r:.0f}\n{a:.0f} to {b:.0f}" if np.isfinite(r) else "-"
                                           for r, a, b in zip(rates, low, high)], 100),
            plot_of("Settling time (s)", settled, [f"{s:.1f}" if np.isfinite(s) else "-" for s in settled],
                    np.nanmax(settled, initial=0) or 1)]


CAPTIONS = {"Reached (%)": "Under each rate its 95 % interval.", "Settling time (s)": "Median of those that reached."}
FIGURES = {1: [curves], 2: [maps]}
