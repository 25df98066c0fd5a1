"""The page of a comparison: is one step enough? Every estimator on the same pixels."""
import csv
import io
import re
from pathlib import Path

import numpy as np

from .comparison_answers import answers, certificate_worth
from .comparison_results import Comparison, median
from .page import COLORS, INK, Drawing, axes, curve, drawable, figure_text, goal_line, legend, number, numbers, percent, photo, text_of
from .paper_claims import OF_TIMES, claims

# What a plot has room for; a converged fit has its one step's colour, dashed, a whole detector its fit's, dash-dotted.
HEADLINES = {"sphere_one_step": (COLORS[0], "-"), "sphere_converged": (COLORS[0], "--"),
             "paper_one_step": (COLORS[1], "-"), "paper_converged": (COLORS[1], "--"), "vote": (COLORS[2], "-"),
             "hough_gradient": (COLORS[3], "-"), "hough_gradient_alt": (COLORS[4], "-"),
             "hsv_contour": (COLORS[5], "-"), "vpdot2": (COLORS[6], "-"), "detect_sphere": (COLORS[0], "-."),
             "detect_paper": (COLORS[1], "-."), "detect_hough_gradient": (COLORS[3], "-."),
             "detect_hsv_contour": (COLORS[5], "-.")}
SWEPT_PAIRS = ("paper_one_step", "sphere_one_step", "paper_steps_10_reselect")
MOST_BARS, MOST_TABLES = 12, 40
FEWEST_BREAKS = 5  # of a rule's curve
LEAST_PX = 1e-4  # below it two fits are the same for any purpose


def page(folder):
    data = Comparison(folder)
    facts, claimed = data.facts, claims(data)
    gallery = {kind: [photo(folder, item["file"], caption(data, kind, item)) for item in shown]
               for kind, shown in facts["photos"].items()}
    return dict(
        title=title(data), facts=facts, text=data.text, answers=answers(data), photos=gallery,
        subtitle=f"Every estimator of the ball on the same pixels: {data.text['subject']}", places=data.places,
        methods=[(method["name"], method["minimises"]) for method in facts["methods"]],
        verdicts=[(it.says, it.verdict) for it in claimed],
        measurements=[(it.says, it.measured, it.shown_by) for it in claimed],
        steps=step_figures(data), bars=error_bars(data) if data.places and data.named else None,
        errors=error_figures(data), roc=roc_figure(data), certificate_rows=certificate_rows(data), costs=costs(data),
        worth=[certificate_worth(row) for row in first_rules(data) if int(row["tested_frames"]) > 0],
        error_tables=[(c, error_rows(data, c["name"])) for c in data.conditions[:MOST_TABLES]],
        others=len(data.conditions) > MOST_TABLES, pair_rows=pair_rows(data),
        enough_heading=[f"{pair[0]}: is it enough?" for pair in data.step_pairs],
        enough_rows=[(c["name"], c["words"], *(data.verdict(c["name"], pair).words for pair in data.step_pairs))
                     for c in data.conditions])


def tables(folder):
    """Files that say in words, or in LaTeX, what the tables hold."""
    data = Comparison(folder)
    files = {"tables.tex": latex_tables(data), "answer.txt": "".join(f"{text}\n" for text in answers(data)["overall"])}
    claimed = [it for it in claims(data) if it.shown_by != OF_TIMES]
    if claimed:
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(("claim", "measured", "verdict", "shown_by"))
        writer.writerows((it.says, it.measured, it.verdict, it.shown_by) for it in claimed)
        files["claims.csv"] = text.getvalue()
    return files


def title(data):
    subject = data.text["subject"]
    return (f"{Path(subject).stem}: is one step enough?" if data.text["rendered"] else
            f"{subject}: which method is nearest to the annotations?")


def caption(data, kind, item):
    if kind == "examples":
        return f"{item['condition']}: {data.by_name[item['condition']]['words']}"
    unit = "px apart (centres or radii)" if kind == "apart" else "mm off" if item["in_space"] else "px off"
    value = "not found" if item["value"] is None else f"{figure_text(item['value'])} {unit}"
    return f"{item['condition']}, frame {item['frame']} ({item['source']}): {value}"


def headlines(data):
    return [(method, *HEADLINES[method]) for method in HEADLINES if method in data.methods]


def method_color(method):
    return HEADLINES.get(method, ("#8c564b", "-"))[0]


def interval(plot, x, low, high, color):
    known = np.isfinite(low) & np.isfinite(high)
    plot.vlines(x[known], low[known], high[known], color=color, linewidth=1.2, alpha=0.6)


def error_figures(data):
    if not data.places:
        return []
    figures = []
    for sweep in data.sweeps():
        figures.append(sweep_errors(data, sweep))
        if any(np.any(data.column(method, "failed", sweep.names) > 0) for method, _, _ in headlines(data)):
            figures.append(sweep_found(data, sweep))
    return figures + [error_ellipses(data)]


def sweep_found(data, sweep):
    names, values = sweep.names, np.array(sweep.values)
    plot = axes(f"Balls found against {sweep.label}", sweep.label, "found (% of the frames)", 480, 400,
                "x" if sweep.log else "")
    for method, color, line in headlines(data):
        share = data.column(method, "found", names) / data.column(method, "frames", names)
        curve(plot, values, 100 * share, method, color=color, linestyle=line, marker="o", markersize=3)
    plot.set_ylim(0, 102)
    legend(plot)
    return Drawing(plot, "Frames in which the method's answer is at the ball.")


def error_bars(data):
    names = data.named[:MOST_BARS]
    methods = [(method, color) for method, color, line in headlines(data) if line != "--"]
    width = min(max(110 * len(names), 480), 1040)
    plot = axes("Error of the ball's centre in 3-D, median", "", "error (mm), log", width, 360, log="y")
    for k, (method, color) in enumerate(methods):
        x = np.arange(len(names)) + (k - (len(methods) - 1) / 2) * 0.8 / len(methods)
        plot.bar(x, drawable(data.column(method, "position_median_mm", names)), 0.8 / len(methods), color=color,
                 label=method)
        interval(plot, x, data.column(method, "position_median_low_mm", names),
                 data.column(method, "position_median_high_mm", names), INK)
        share = data.column(method, "found", names) / data.column(method, "frames", names)
        for place in np.flatnonzero(share < 1):
            plot.text(x[place], 0.99, f"{100 * share[place]:.0f} %", transform=plot.get_xaxis_transform(), rotation=90,
                      fontsize="x-small", ha="center", va="top", color=color)
    plot.set_xticks(np.arange(len(names)), [name.replace("_", " ") for name in names], rotation=40, ha="right")
    legend(plot, len(methods), 6.5)
    return Drawing(plot, "Shorter is better; one grid line to the next is a factor. At the top, where it is not 100 %: "
                   "in how many frames the method found the ball.")


def sweep_errors(data, sweep):
    names, values = sweep.names, np.array(sweep.values)
    plot = axes(f"3-D error against {sweep.label}", sweep.label, "median error (mm), log", 480, 400,
                "xy" if sweep.log else "y")
    for method, color, line in headlines(data):
        curve(plot, values, data.column(method, "position_median_mm", names), method, color=color, linestyle=line,
              marker="o", markersize=3)
        if line != "--":
            interval(plot, values, data.column(method, "position_median_low_mm", names),
                     data.column(method, "position_median_high_mm", names), color)
    bounds = [data.frame_values(name, "bound_mm") for name in names]
    curve(plot, values, [np.sqrt(np.mean(mm ** 2)) if len(mm) else np.nan for mm in bounds], "bound (RMS)", color=INK,
          linestyle="--")
    legend(plot)
    start = " The fits start from the true circle, displaced: vote is that start."
    return Drawing(plot, "Solid: one step. Dashed: converged on the same points. Dash-dotted: whole detectors."
                   + (start if sweep.key.startswith("start.") else ""))


def error_ellipses(data):
    name = data.conditions[0]["name"]
    plot = axes(f"Where the errors lie: {name}", "sideways, outward (mm)", "depth (mm)")
    angle = np.linspace(0, 2 * np.pi, 73)
    for method in ("sphere_one_step", "paper_one_step", "vote"):
        if method not in data.methods:
            continue
        row = data.rows[name, method]
        across = number(row["lateral_spread_mm"]) / np.sqrt(2)  # one of the two sideways directions
        curve(plot, number(row["lateral_bias_mm"]) + 2 * across * np.cos(angle),
              number(row["depth_bias_mm"]) + 2 * number(row["depth_spread_mm"]) * np.sin(angle), method,
              color=method_color(method))
    legend(plot)
    return Drawing(plot, "Bias (where an ellipse's middle lies) and two sigmas of the spread. Depth is the hard direction: it "
                   "follows from the radius alone.")


def step_figures(data):
    figures = []
    for pair in data.facts["one_step_pairs"]:
        figures.append(distance_shares(data, pair))
        if data.places:
            figures.append(errors_of_both(data, pair))
    return figures + [sweep_distances(data, sweep) for sweep in data.sweeps()] if figures else []


def distance_shares(data, pair):
    plot = axes(f"{pair['one_step']} against {pair['converged']}", "distance between the two centres (px), log",
                "frames at most so far apart (%)", log="x")
    for name, values, line in (("all conditions", pair["apart_px"], "-"),
                               (f"worst: {pair['worst_condition']}", pair["worst_apart_px"], "--")):
        values = np.maximum(np.sort(drawable(values)), LEAST_PX)
        plot.step(values, 100 * np.arange(1, len(values) + 1) / max(len(values), 1), where="post", label=name,
                  color=method_color(pair["one_step"]), linestyle=line)
    goal_line(plot, data.facts["break_px"], f"{data.facts['break_px']:g} px", vertical=True)
    plot.set(ylim=(0, 100), xlim=(LEAST_PX, None))
    legend(plot)
    return Drawing(plot, "A curve that rises early means that the two agree in nearly every frame. Differences below 0.0001 px "
                   "are drawn there.")


def errors_of_both(data, pair):
    plot = axes("Error of one step and of the converged fit, by condition",
                f"{pair['converged']}: median error (mm), log", f"{pair['one_step']}: median error (mm), log", log="xy")
    one, converged = (drawable(data.column(pair[name], "position_median_mm")) for name in ("one_step", "converged"))
    plot.plot(converged, one, "o", color=method_color(pair["one_step"]), markersize=5)
    both = np.concatenate([one, converged])
    both = both[both > 0]
    if len(both):
        plot.plot([both.min(), both.max()], [both.min(), both.max()], "--", color=INK, linewidth=1)
    return Drawing(plot, "On the dashed line both err alike; below it one step is the better.")


def sweep_distances(data, sweep):
    names, values = sweep.names, np.array(sweep.values)
    limit = data.facts["break_px"]
    plot = axes(f"Way to the converged fit against {sweep.label}", sweep.label, "between centres (px), log", 480, 360,
                "xy" if sweep.log else "y")
    for method in SWEPT_PAIRS:
        if not any(one == method for _, one, _ in data.pairs):
            continue
        middle, most, low, high = (np.fmax(data.pair_column(method, f"center_{name}_px", names), 1e-5) for name in
                                   ("median", "max", "median_low", "median_high"))
        unknown = np.isnan(data.pair_column(method, "center_median_px", names))
        for series, line, name in ((middle, "-", "median"), (most, "--", "largest")):
            curve(plot, values, np.where(unknown, np.nan, series), f"{method}, {name}", color=method_color(method),
                  linestyle=line, marker="o", markersize=3)
        interval(plot, values, np.where(unknown, np.nan, low), high, method_color(method))
    goal_line(plot, limit, f"{limit:g} px")
    legend(plot, 2)
    return Drawing(plot, f"Solid: the median with its 95 % interval. Dashed: the worst frame. Beyond {limit:g} px a frame "
                   "counts as broken; a gap is where no frame was found.")


def first_rules(data):
    """Of each fit: it stands for all those that never ask for a step, and one more step was tried by it."""
    return [row for row in data.certificates if row["rule"] == "next_step"]


def roc_figure(data):
    """How well rules tell breaks, of the fits that break often enough."""
    drawn = [row["one_step"] for row in first_rules(data) if int(row["tested_breaks"]) >= FEWEST_BREAKS]
    if not drawn:
        return None
    plot = axes("How well the rules tell breaks", "false alarms (% of the frames that do not break)",
                "breaks caught (%)", 480, 380)
    for curves in data.facts["roc"]:
        if curves["one_step"] in drawn:
            curve(plot, 100 * drawable(curves["false_alarms"]), 100 * drawable(curves["caught"]),
                  f"{curves['one_step']}, {curves['rule']}", color=method_color(curves["one_step"]),
                  linestyle="-" if curves["rule"] == "next_step" else "--",
                  alpha=0.5 if curves["rule"] == "logistic" else 1)
    goal_line(plot, 5, "5 %", vertical=True)
    goal_line(plot, 95, "95 %")
    plot.set(xlim=(0, 100), ylim=(0, 101))
    legend(plot, 2)
    return Drawing(plot, "Up and to the left is better. next_step: by the length of the step that would follow; bend: by this "
                   "step's squared; logistic: by four things together. Fits with fewer than "
                   f"{FEWEST_BREAKS} breaks are left out.")


def certificate_rows(data):
    return [(row["one_step"], rule["words"], row["tested_frames"], row["tested_breaks"],
             percent(number(rule["caught_rate"])), percent(number(rule["false_alarm_rate"])), figure_text(rule["roc_area"]))
            for row, rule in zip(data.certificates, data.rules) if row["threshold"] or row["rule"] == "next_step"]


def costs(data):
    """Times of each method, and what a frame takes in all: our methods', the peers'."""
    time_ms, error_mm = {}, {}
    for method in data.methods:
        time_ms[method] = median(numbers([data.times[name, method] for name in data.names], "time_us_median")) / 1000
        error_mm[method] = median(data.column(method, "position_median_mm"))
    def total(peers):
        return np.nansum([time_ms[m["name"]] for m in data.facts["methods"] if m["is_peer"] == peers])
    rows = [(method, figure_text(time_ms[method]), figure_text(error_mm[method]),
             f"{data.column(method, 'found').sum():.0f} of {data.column(method, 'frames').sum():.0f}")
            for method in data.methods]
    own = total(False)
    return {"rows": rows, "own_ms": figure_text(own), "frames_per_s": f"{1000 / own:.0f}" if own > 0 else "0",
            "peers_ms": figure_text(total(True)) if total(True) > 0 else "",
            "figure": cost_plot(data, time_ms, error_mm) if data.places else None}


def cost_plot(data, time_ms, error_mm):
    plot = axes("What each costs, and how well it does", "time a frame (ms), log", "median error (mm), log", 480, 380, "xy")
    for method, color, line in headlines(data):
        converged = line == "--"
        plot.plot(drawable([time_ms[method]]), drawable([error_mm[method]]), "o", color=color, label=method,
                  markersize=6 if converged else 9, alpha=0.5 if converged else 1)
    legend(plot)
    return Drawing(plot, "Down and to the left is better. Small and pale: converged.")


def with_interval(row, quantity, unit, form="{} ({} to {})"):
    middle, low, high = (figure_text(row[f"{quantity}_median{end}_{unit}"]) for end in ("", "_low", "_high"))
    return form.format(middle, low, high) if low != "-" else middle


def error_rows(data, condition):
    rows = []
    for method in data.methods:
        row = data.rows[condition, method]
        charged = figure_text(row["charged_median_mm"])
        rows.append((method, f"{row['found']} of {row['frames']}", with_interval(row, "position", "mm"),
                     *(figure_text(row[name]) for name in ("position_p90_mm", "depth_bias_mm", "depth_spread_mm",
                       "lateral_spread_mm", "center_rms_px", "radius_bias_px", "rms_over_bound", "nees_mean")),
                     text_of(row["inside_95"], 1, scale=100), figure_text(row["false_per_1000"]),
                     "most fail" if charged == "-" and row["position_median_mm"] else charged))
    return rows


def pair_rows(data):
    rows, before = [], None
    for (condition, one, other), row in data.pairs.items():
        if int(row["frames"]) == 0:
            continue
        rows.append((condition if condition != before else "", one, other, row["frames"], row["breaks"],
                     with_interval(row, "center", "px"),
                     *(figure_text(row[name]) for name in ("center_max_px", "radius_median_px", "radius_max_px")),
                     with_interval(row, "position", "mm"), figure_text(row["position_max_mm"])))
        before = condition
    return rows


def latex_tables(data):
    """The error table and the table of pairs (booktabs)."""
    def name(text):
        return re.sub("[_%&#$]", r"\\\g<0>", text)

    def median_of(row, quantity, unit):
        return with_interval(row, quantity, unit, "{} [{}, {}]")

    errors, distances = [], []
    for condition in data.names:
        first = name(condition)
        for method in data.methods:
            row = data.rows[condition, method]
            errors.append((first, name(method), f"{row['found']}/{row['frames']}", median_of(row, "position", "mm"),
                           *(figure_text(row[column]) for column in ("position_p90_mm", "depth_bias_mm", "rms_over_bound"))))
            first = ""
    for (condition, one, other), row in data.pairs.items():
        first = name(condition) if not distances or condition != before else ""
        distances.append((first, name(one), name(other), median_of(row, "center", "px"), figure_text(row["center_max_px"]),
                          f"{row['breaks']}/{row['frames']}", median_of(row, "position", "mm")))
        before = condition
    return "% Needs \\usepackage{booktabs,longtable}.\n" + "\n".join((
        latex_table("llrrrrr", ("condition", "method", "found", r"median mm [95\,\%]", r"90\,\% mm", "depth bias mm",
                                "RMS/bound"), errors, len(data.methods)),
        latex_table("lllrrrr", ("condition", "fit", "against", r"median px [95\,\%]", "largest px", "breaks",
                                r"median mm [95\,\%]"), distances, len(distances))))


def latex_table(columns, heading, rows, group):
    """With a line below every so many rows."""
    lines = [f"\\begin{{longtable}}{{{columns}}}", r"\toprule", " & ".join(heading) + r" \\", r"\midrule", r"\endhead"]
    for k, row in enumerate(rows):
        lines += [r"\midrule"] * (0 < k and k % group == 0) + [" & ".join(row) + r" \\"]
    return "\n".join((*lines, r"\bottomrule", r"\end{longtable}", ""))
