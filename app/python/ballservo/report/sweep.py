"""The page of a sweep: many runs of one scenario, one a seed."""
import itertools
import json

import numpy as np
from matplotlib.patches import Circle

from .floor import draw_obstacles, draw_robot, draw_room
from .page import COLORS, Drawing, axes, curve, legend, map_axes, number, numbers, percent, read_json, read_rows, read_text

REACHED, FAILED, BALL = COLORS[:3]
MOST_WAYS, MOST_DRAWN_KEYS, BINS = 300, 3, 30
DEGREES = np.degrees(1)
UNITS = {"settled_s": (1, "s"), "range_rms_m": (1e3, "mm"), "bearing_rms_rad": (1e3, "mrad"),
         "min_clearance_m": (1, "m"), "out_of_view_s": (1, "s")}


def page(folder):
    facts, summary = read_json(folder / "report.json"), read_json(folder / "summary.json")
    trials = [row for row in read_rows(folder / "trials.csv") if row["outcome"] != "infeasible"]
    traces = read_traces(folder / "traces.jsonl", seeds_to_draw(trials) | {trial["seed"] for trial in facts["worst"]})
    by_seed = {int(trial["seed"]): trial for trial in trials}
    return dict(
        title=facts["title"], summary=summary, facts=facts, feasible=len(trials),
        subtitle=f"{summary['trials']} runs: law {summary['law']}, perception {summary['perception']}",
        reached=rate(summary["reached"], len(trials), summary["success_ci95"]), keys=key_figures(summary, trials),
        failures=[failure_row(group, len(trials)) for group in summary["failures"]],
        against=against(summary, facts) if "against" in summary else None, ways=all_ways(trials, traces),
        worst=[worst_trial(by_seed[trial["seed"]], traces[trial["seed"]], facts)
               for trial in facts["worst"] if trial["seed"] in traces],
        commands="\n".join(trial["command"] for trial in facts["worst"]),
        drawn=[success_plot(key) for key in facts["success_by"]] + scatter_plots(trials),
        distributions=distributions(trials), scenario=json.dumps(facts["scenario"], indent=2))


def rate(part, whole, interval):
    if whole == 0:
        return "-"
    middle, low, high = (percent(share, 2) for share in (part / whole, *interval))
    return f"{part} of {whole}: {middle} (95 % interval {low} to {high})"


def spread(values, scale, unit):
    """"15.2 s (5 % 8.36, 95 % 41.6)" """
    values = values[np.isfinite(values)]
    if len(values) == 0:
        return "-"
    low, middle, high = scale * np.quantile(values, [0.05, 0.5, 0.95])
    return f"{middle:.3g} {unit} (5 % {low:.3g}, 95 % {high:.3g})"


def those_that_reached(trials):
    return [trial for trial in trials if trial["outcome"] == "reached"]


def key_figures(s, trials):
    reached = those_that_reached(trials)
    return [
        ("reached", rate(s["reached"], len(trials), s["success_ci95"])),
        ("collisions", rate(s["collisions"], len(trials), s["collision_ci95"])),
        ("collisions inside the assumptions", s["collisions_inside_assumptions"]),
        ("infeasible worlds, not counted", s["infeasible"]),
        ("settled after, median", spread(numbers(reached, "settled_s"), 1, "s")),
        ("rms distance error", spread(numbers(reached, "range_rms_m"), 1e3, "mm")),
        ("rms bearing error", spread(numbers(reached, "bearing_rms_rad"), DEGREES, "deg")),
        ("least clearance", spread(numbers(trials, "min_clearance_m"), 1, "m")),
        ("ball in free sight, outside the picture", spread(numbers(trials, "out_of_view_s"), 1, "s"))]


def failure_row(group, feasible):
    seeds = ", ".join(map(str, group["seeds"])) + (", ..." if group["count"] > len(group["seeds"]) else "")
    share = "not counted" if group["outcome"] == "infeasible" else percent(group["count"] / feasible, 2)
    return group["outcome"], group["cause"], group["count"], share, seeds


def against(summary, facts):
    """Two tables: outcomes and figures, paired by seed with those of another sweep."""
    other = summary["against"]
    outcomes = [(name, c["both"], c["only_this"], c["only_other"], c["neither"], percent(c["difference"], 2),
                 " to ".join(percent(end, 2) for end in c["difference_ci95"]))
                for name, c in (("reached", other["success"]), ("no collision", other["no_collision"]))]
    medians = []
    for name, d in other["median_differences"].items():
        scale, unit = UNITS[name]
        low, high = (number(end) * scale for end in d["ci95"])
        if d["pairs"] > 0:
            medians.append((name, d["pairs"], f"{number(d['median']) * scale:.4g} {unit}",
                            f"{low:.4g} to {high:.4g} {unit}" if np.isfinite(low) else "-"))
    return {**other, **facts["against"], "outcomes": outcomes, "medians": medians}


def seeds_to_draw(trials):
    """Of those that failed first."""
    order = sorted(trials, key=lambda trial: trial["outcome"] == "reached")
    return {int(trial["seed"]) for trial in order[:MOST_WAYS]}


def read_traces(path, seeds):
    """Where robot and ball went, by seed; in metres."""
    traces = {}
    for line in read_text(path).splitlines():
        # {"seed":N,...: read whole only where it is wanted
        if int(line[len('{"seed":'):line.index(",")]) not in seeds:
            continue
        trace = json.loads(line)
        traces[trace["seed"]] = {
            "path": metres(trace["path_mm"]), "ball": metres(trace["ball_path_mm"]),
            "yaw_rad": trace["end_yaw_mrad"] / 1e3, "room": metres(trace["room_mm"]).ravel(),
            "obstacles": [{"points_m": metres(item["points"]), "radius_m": item.get("radius", 0) / 1e3}
                          for item in trace["obstacles_mm"]]}
    return traces


def metres(flat_mm):
    return np.reshape(flat_mm, (-1, 2)) / 1e3


def all_ways(trials, traces):
    shown = [(trial, traces[int(trial["seed"])]) for trial in trials if int(trial["seed"]) in traces]
    rooms = np.array([trace["room"] for _, trace in shown] or [(-1, -1, 1, 1)])
    room = np.concatenate([rooms[:, :2].min(axis=0), rooms[:, 2:].max(axis=0)])
    plot = map_axes("All ways from above", (room[0] - 0.1, room[2] + 0.1), (room[1] - 0.1, room[3] + 0.1), "x (m)",
                    "y (m)", 760)
    draw_room(plot, room)
    obstacles = [str(trace["obstacles"]) for _, trace in shown]
    if shown and len(set(obstacles)) == 1:
        draw_obstacles(plot, shown[0][1]["obstacles"])
    for trial, trace in sorted(shown, key=lambda pair: pair[0]["outcome"] != "reached"):
        if trial["outcome"] == "reached":
            plot.plot(*trace["path"].T, color=REACHED, linewidth=1, alpha=np.clip(30 / len(shown), 0.15, 0.8))
        elif len(trace["path"]):
            plot.plot(*trace["path"].T, color=FAILED, linewidth=1.5, alpha=0.8)
            plot.plot(*trace["path"][-1], "o", color=FAILED, markersize=5)
        plot.plot(*trace["ball"][:1].T, "o", color=BALL, markersize=3)
    return Drawing(plot, f"{len(shown)} of the trials, failures first. Thin: reached. Thick, ending in a dot: not reached. "
                   "Small dots: where the balls were at the start. Obstacles are shown where all trials share them.")


def worst_trial(trial, trace, facts):
    room = trace["room"]
    plot = map_axes(f"seed {trial['seed']}", (room[0] - 0.1, room[2] + 0.1), (room[1] - 0.1, room[3] + 0.1), width=300)
    plot.set_axis_off()
    draw_room(plot, room)
    draw_obstacles(plot, trace["obstacles"])
    path, ball = trace["path"], trace["ball"]
    if len(path):
        plot.plot(*ball.T, color=BALL, linewidth=1, alpha=0.6)
        plot.plot(*path.T, color=REACHED, linewidth=1.5)
        plot.plot(*path[0], "o", color=REACHED, markersize=5)
        draw_robot(plot, facts["footprint_m"], path[-1], trace["yaw_rad"], REACHED, arrow=True)
        plot.add_patch(Circle(ball[-1], facts["distance_m"], fill=False, color=BALL, linewidth=1, linestyle="--", zorder=2))
        plot.plot(*ball[-1], "o", color=BALL, markersize=6)
    return Drawing(plot, f"Seed {trial['seed']}: {trial['outcome']}: {trial['why']}.")


def success_plot(key):
    """Success in equal cells of the values that seeds drew."""
    plot = axes(f"Success by {key['key']}", key["key"], "reached (%)", 480, 280)
    value, low, high = (numbers(key["cells"], name) for name in ("value", "low", "high"))
    share = numbers(key["cells"], "reached") / numbers(key["cells"], "trials")
    curve(plot, value, 100 * share, marker="o", markersize=4, color=REACHED)
    for end in (low, high):
        curve(plot, value, 100 * end, color=REACHED, linewidth=1, linestyle="--")
    plot.set_ylim(0, 102)
    return Drawing(plot, "Dashed: 95 % intervals.")


def scatter_plots(trials):
    keys = [name for name in (trials[0] if trials else ()) if name.startswith("drawn.")]
    return [scatter_plot(trials, *pair) for pair in itertools.combinations(keys[:MOST_DRAWN_KEYS], 2)]


def scatter_plot(trials, a, b):
    plot = axes("Where it succeeds", a[len("drawn."):], b[len("drawn."):], 480, 360)
    good = np.array([trial["outcome"] == "reached" for trial in trials])
    x, y = numbers(trials, a), numbers(trials, b)
    plot.plot(x[good], y[good], "o", color=REACHED, markersize=3, alpha=0.5, label="reached")
    plot.plot(x[~good], y[~good], "o", color=FAILED, markersize=4, label="not reached")
    legend(plot)
    return Drawing(plot, "One dot a trial.")


def histogram(values, title, label, caption):
    plot = axes(title, label, "trials", 480, 280)
    values = values[np.isfinite(values)]
    if len(values):
        plot.hist(values, BINS, color=COLORS[0], alpha=0.85)
    return Drawing(plot, caption)


def distributions(trials):
    reached = those_that_reached(trials)
    settled, optimal = numbers(reached, "settled_s"), numbers(reached, "time_optimal_s")
    of_those = "Of those that reached."
    mean = "mean of the last second"
    return [
        histogram(settled, "Settling time", "settled (s)", of_those),
        histogram(settled / optimal, "Over the time-optimal run", "ratio", "Settling time over that of a turn on the spot "
                  "and a straight way, both at the drive's limits."),
        histogram(1e3 * numbers(reached, "range_error_m"), "Distance error", f"{mean} (mm)", of_those),
        histogram(DEGREES * numbers(reached, "bearing_error_rad"), "Bearing error", f"{mean} (deg)", of_those),
        histogram(1e3 * numbers(reached, "range_rms_m"), "Distance, rms", "rms from settling on (mm)", of_those),
        histogram(numbers(trials, "min_clearance_m"), "Least clearance", "clearance (m)",
                  "From the footprint to the nearest wall or obstacle; all feasible trials."),
        histogram(numbers(trials, "out_of_view_s"), "Ball out of view", "time (s)",
                  "In free sight, but outside the picture; all feasible trials.")]
