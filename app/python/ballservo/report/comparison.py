"""The page of a comparison: is one step enough? Every estimator on the same pixels."""
import numpy as np

from .page import (COLORS, INK, axes, curve, drawable, drawing, figure_text, goal_line, legend, number, numbers, photo,
                   read_json, read_rows, render, text_of)

# What a plot has room for; a converged fit has its one step's colour, dashed, a whole detector its fit's, dash-dotted.
HEADLINES = {"sphere_one_step": (COLORS[0], "-"), "sphere_converged": (COLORS[0], "--"),
             "paper_one_step": (COLORS[1], "-"), "paper_converged": (COLORS[1], "--"), "vote": (COLORS[2], "-"),
             "hough_gradient": (COLORS[3], "-"), "hough_gradient_alt": (COLORS[4], "-"),
             "hsv_contour": (COLORS[5], "-"), "vpdot2": (COLORS[6], "-"), "detect_sphere": (COLORS[0], "-."),
             "detect_paper": (COLORS[1], "-."), "detect_hough_gradient": (COLORS[3], "-."),
             "detect_hsv_contour": (COLORS[5], "-.")}
SWEPT_PAIRS = ("paper_one_step", "sphere_one_step", "paper_steps_10_reselect")
MOST_BARS, MOST_TABLES = 12, 40
LEAST_PX = 1e-4  # below it two fits are the same for any purpose


def page(folder):
    data = Comparison(folder)
    facts = data.facts
    gallery = {kind: {**shown, "photos": [photo(folder, item["file"], item["caption"]) for item in shown["frames"]]}
               for kind, shown in facts["photos"].items()}
    return render(
        "comparison.html", title="Is one step enough?", facts=facts, answers=facts["answers"], photos=gallery,
        subtitle=f"Every estimator of the ball on the same pixels: {facts['subject']}", places=data.places,
        methods=[(method["name"], method["minimises"]) for method in facts["methods"]],
        verdicts=[(claim["says"], claim["verdict"]) for claim in facts["claims"]],
        measurements=[(claim["says"], claim["measured"], claim["shown_by"]) for claim in facts["claims"]],
        steps=step_figures(data), bars=error_bars(data) if data.places and data.named else None,
        errors=error_figures(data), roc=roc_figure(data), certificate_rows=certificate_rows(facts), costs=costs(data),
        error_tables=[(c, error_rows(data, c["name"])) for c in data.conditions[:MOST_TABLES]],
        pair_rows=pair_rows(data), enough_rows=[(c["name"], c["words"], *c["enough"]) for c in data.conditions])


class Comparison:
    """The tables of a comparison's folder."""

    def __init__(self, folder):
        self.facts = read_json(folder / "report.json")
        self.conditions = self.facts["conditions"]
        self.methods = [method["name"] for method in self.facts["methods"]]
        self.named = [condition["name"] for condition in self.conditions if condition["swept_value"] is None]
        self.rows = {(row["condition"], row["method"]): row for row in read_rows(folder / "compare.csv")}
        self.times_us = {(row["condition"], row["method"]): number(row["time_us_median"])
                         for row in read_rows(folder / "timing.csv")}
        self.pairs = read_rows(folder / "pairs.csv")
        self.places = any(np.isfinite(numbers(self.rows.values(), "position_median_mm")))

    def column(self, method, name, conditions=None):
        names = [condition["name"] for condition in self.conditions] if conditions is None else conditions
        return numbers([self.rows[condition, method] for condition in names], name)

    def pair_column(self, method, name, conditions):
        rows = {row["condition"]: row for row in self.pairs if row["method_a"] == method}
        return numbers([rows[condition] for condition in conditions], name)

    def headlines(self):
        return [(method, *HEADLINES[method]) for method in HEADLINES if method in self.methods]

    def sweeps(self):
        """Each with its conditions' names and the values that they vary."""
        values = {condition["name"]: condition["swept_value"] for condition in self.conditions}
        return [(sweep, sweep["conditions"], drawable([values[name] for name in sweep["conditions"]]))
                for sweep in self.facts["sweeps"]]


def median(values):
    values = values[np.isfinite(values)]
    return np.median(values) if len(values) else np.nan


def method_color(method):
    return HEADLINES.get(method, ("#8c564b", "-"))[0]


def interval(plot, x, low, high, color):
    known = np.isfinite(low) & np.isfinite(high)
    plot.vlines(x[known], low[known], high[known], color=color, linewidth=1.2, alpha=0.6)


def error_figures(data):
    if not data.places:
        return []
    figures = [sweep_errors(data, *sweep) for sweep in data.sweeps()]
    figures += [sweep_found(data, *sweep) for sweep in data.sweeps() if misses(data, sweep[1])]
    return figures + [error_ellipses(data)]


def misses(data, names):
    return any(np.any(data.column(method, "failed", names) > 0) for method, _, _ in data.headlines())


def sweep_found(data, sweep, names, values):
    plot = axes(f"Balls found against {sweep['label']}", sweep["label"], "found (% of the frames)", 480, 400,
                "x" if sweep["log"] else "")
    for method, color, line in data.headlines():
        share = data.column(method, "found", names) / data.column(method, "frames", names)
        curve(plot, values, 100 * share, method, color=color, linestyle=line, marker="o", markersize=3)
    plot.set_ylim(0, 102)
    legend(plot)
    return drawing(plot, "Frames in which the method's answer is at the ball.")


def error_bars(data):
    names = data.named[:MOST_BARS]
    methods = [(method, color) for method, color, line in data.headlines() if line != "--"]
    width = min(max(110 * len(names), 480), 1040)
    plot = axes("Error of the ball's centre in 3-D, median", "", "error (mm), log", width, 360, log="y")
    for k, (method, color) in enumerate(methods):
        x = np.arange(len(names)) + (k - (len(methods) - 1) / 2) * 0.8 / len(methods)
        plot.bar(x, drawable(data.column(method, "position_median_mm", names)), 0.8 / len(methods), color=color,
                 label=method)
        interval(plot, x, data.column(method, "position_median_low_mm", names),
                 data.column(method, "position_median_high_mm", names), INK)
    plot.set_xticks(np.arange(len(names)), [name.replace("_", " ") for name in names], rotation=20, ha="right")
    legend(plot, len(methods), 0.24)
    return drawing(plot, "Shorter is better; one grid line to the next is a factor.")


def sweep_errors(data, sweep, names, values):
    plot = axes(f"3-D error against {sweep['label']}", sweep["label"], "median error (mm), log", 480, 400,
                "xy" if sweep["log"] else "y")
    for method, color, line in data.headlines():
        curve(plot, values, data.column(method, "position_median_mm", names), method, color=color, linestyle=line,
              marker="o", markersize=3)
        if line != "--":
            interval(plot, values, data.column(method, "position_median_low_mm", names),
                     data.column(method, "position_median_high_mm", names), color)
    bound = {condition["name"]: condition["bound_rms_mm"] for condition in data.conditions}
    curve(plot, values, [number(bound[name]) for name in names], "bound (RMS)", color=INK, linestyle="--")
    legend(plot)
    start = " The fits start from the true circle, displaced: vote is that start."
    return drawing(plot, "Solid: one step. Dashed: converged on the same points. Dash-dotted: whole detectors."
                   + (start if sweep["key"].startswith("start.") else ""))


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
    return drawing(plot, "Bias (where an ellipse's middle lies) and two sigmas of the spread. Depth is the hard direction: it "
                   "follows from the radius alone.")


def step_figures(data):
    figures = []
    for pair in data.facts["one_step_pairs"]:
        figures.append(distance_shares(data, pair))
        if data.places:
            figures.append(errors_of_both(data, pair))
    return figures + [sweep_distances(data, *sweep) for sweep in data.sweeps()] if figures else []


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
    return drawing(plot, "A curve that rises early means that the two agree in nearly every frame. Differences below 0.0001 px "
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
    return drawing(plot, "On the dashed line both err alike; below it one step is the better.")


def sweep_distances(data, sweep, names, values):
    limit = data.facts["break_px"]
    plot = axes(f"Way to the converged fit against {sweep['label']}", sweep["label"], "between centres (px), log", 480, 360,
                "xy" if sweep["log"] else "y")
    for method in SWEPT_PAIRS:
        if not any(row["method_a"] == method for row in data.pairs):
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
    return drawing(plot, f"Solid: the median with its 95 % interval. Dashed: the worst frame. Beyond {limit:g} px a frame "
                   "counts as broken; a gap is where no frame was found.")


def roc_figure(data):
    """How well rules tell breaks, of the fits that break often enough."""
    certificates = data.facts["certificates"]
    drawn = [fit for fit in certificates["fits"] if fit["rules"][0]["breaks"] >= certificates["fewest"]]
    if not drawn:
        return None
    plot = axes("How well the rules tell breaks", "false alarms (% of the frames that do not break)",
                "breaks caught (%)", 480, 380)
    for fit in drawn:
        for k, rule in enumerate(fit["rules"]):
            curve(plot, 100 * drawable(rule["roc_false_alarms"]), 100 * drawable(rule["roc_caught"]),
                  f"{fit['one_step']}, {rule['name']}", color=method_color(fit["one_step"]),
                  linestyle="--" if k else "-", alpha=0.5 if k == len(fit["rules"]) - 1 else 1)
    goal_line(plot, 5, "5 %", vertical=True)
    goal_line(plot, 95, "95 %")
    plot.set(xlim=(0, 100), ylim=(0, 101))
    legend(plot, 2)
    return drawing(plot, "Up and to the left is better. next_step: by the length of the step that would follow; bend: by this "
                   "step's squared; logistic: by four things together. Fits with fewer than "
                   f"{certificates['fewest']} breaks are left out.")


def certificate_rows(facts):
    def share(value):
        return "-" if value is None else f"{100 * value:.1f} %"
    return [(fit["one_step"], rule["words"], rule["frames"], rule["breaks"], share(rule["caught_rate"]),
             share(rule["false_alarm_rate"]), figure_text(rule["area"]))
            for fit in facts["certificates"]["fits"] for k, rule in enumerate(fit["rules"]) if rule["asks"] or k == 0]


def costs(data):
    """Times of each method, and what a frame takes in all: our methods', the peers'."""
    time_ms, error_mm = {}, {}
    for method in data.methods:
        time_ms[method] = median(np.array([data.times_us[c["name"], method] for c in data.conditions])) / 1000
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
    for method, color, line in data.headlines():
        converged = line == "--"
        plot.plot(drawable([time_ms[method]]), drawable([error_mm[method]]), "o", color=color, label=method,
                  markersize=6 if converged else 9, alpha=0.5 if converged else 1)
    legend(plot)
    return drawing(plot, "Down and to the left is better. Small and pale: converged.")


def with_interval(row, value, low, high):
    text = figure_text(row[value])
    return f"{text} ({figure_text(row[low])} to {figure_text(row[high])})" if row[low] else text


def error_rows(data, condition):
    rows = []
    for method in data.methods:
        row = data.rows[condition, method]
        charged = figure_text(row["charged_median_mm"])
        rows.append((method, f"{row['found']} of {row['frames']}",
                     with_interval(row, "position_median_mm", "position_median_low_mm", "position_median_high_mm"),
                     *(figure_text(row[name]) for name in ("position_p90_mm", "depth_bias_mm", "depth_spread_mm",
                       "lateral_spread_mm", "center_rms_px", "radius_bias_px", "rms_over_bound", "nees_mean")),
                     text_of(row["inside_95"], 1, scale=100), figure_text(row["false_per_1000"]),
                     "most fail" if charged == "-" and row["position_median_mm"] else charged))
    return rows


def pair_rows(data):
    rows, before = [], None
    for row in data.pairs:
        if int(row["frames"]) == 0:
            continue
        rows.append((row["condition"] if row["condition"] != before else "", row["method_a"], row["method_b"],
                     row["frames"], row["breaks"],
                     with_interval(row, "center_median_px", "center_median_low_px", "center_median_high_px"),
                     *(figure_text(row[name]) for name in ("center_max_px", "radius_median_px", "radius_max_px")),
                     with_interval(row, "position_median_mm", "position_median_low_mm", "position_median_high_mm"),
                     figure_text(row["position_max_mm"])))
        before = row["condition"]
    return rows
