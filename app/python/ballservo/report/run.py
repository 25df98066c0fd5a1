"""The page of one closed-loop run."""
import json
import math

import numpy as np
from matplotlib.patches import Circle

from .page import (COLORS, Drawing, axes, curve, goal_line, legend, map_axes, numbers, photo, read_json, read_rows,
                  text_of)
from .floor import draw_obstacles, draw_robot, draw_room

ROBOT, BALL, GOAL = COLORS[:3]
MOMENTS = 7  # footprints along the path
# What a law's two errors are of; each less its value at the goal.
FEATURES = {"cone": ("log of the range", "azimuth (rad)"), "visp": ("X / Z", "log of Z"),
            "sphere": ("ahead (ball radii)", "to the left (ball radii)"), "pose": ("range (m)", "bearing (rad)")}


def page(folder):
    facts, summary = read_json(folder / "report.json"), read_json(folder / "summary.json")
    log = read_rows(folder / "log.csv")
    return dict(
        title=facts["title"], subtitle=subtitle(facts, folder), command=facts.get("command"),
        summary=summary, keys=key_figures(summary, log), video=(folder / "video.mp4").exists(),
        ways=[top_view(facts, log), image_trace(facts)], errors=error_plots(facts, summary, log),
        commands=[command_plot(log, "v", "mps", "Forward speed", "v (m/s)", "The square-root shape of the braking envelope."),
                  command_plot(log, "w", "radps", "Turning rate", "w (deg/s)", "Positive: to the left.", np.degrees)],
        key_frames=[photo(folder, frame["file"], frame["caption"]) for frame in facts["key_frames"]],
        states=state_changes(log), scenario=json.dumps(read_json(folder / "manifest.json")["scenario"], indent=2))


def subtitle(facts, folder):
    seed = read_json(folder / "manifest.json")["seed"]
    return (f"One closed-loop run: law {facts['law']}, perception {facts['perception']}, seed {seed}"
            + ("" if facts.get("truth_known", True) else "; the peer told no truth, and what needs it is empty"))


def key_figures(s, log):
    known = s["settled_s"] is not None and s["time_optimal_s"]
    return [
        ("distance error, last second", text_of(s["range_error_m"], 2, "mm", 1e3)),
        ("bearing error, last second", text_of(s["bearing_error_rad"], 3, "deg", math.degrees(1))),
        ("settled after", text_of(s["settled_s"], 2, "s")),
        ("time-optimal run that turns first, then drives", text_of(s["time_optimal_s"], 2, "s")),
        ("settling / time-optimal", text_of(s["settled_s"] / s["time_optimal_s"] if known else None)),
        ("rms after settling", text_of(s["range_rms_m"], 2, "mm", 1e3) + ", "
         + text_of(s["bearing_rms_rad"], 3, "deg", math.degrees(1))),
        ("least clearance", text_of(s["min_clearance_m"], 2, "m")),
        ("ball in free sight, outside the picture", text_of(s["out_of_view_s"], 2, "s")),
        ("ball not seen, for whatever reason", text_of(unseen_s(log), 2, "s") + " of " + text_of(s["duration_s"], 2, "s")),
        ("times the ball was lost", s["lost_events"]),
        ("contacts with the ball", s["ball_contacts"]),
        ("control steps", s["steps"])]


def unseen_s(log):
    """The time in which the newest frame showed no ball to the tracker."""
    unseen = np.array([step["track_state"] not in ("tentative", "confirmed") for step in log[:-1]], dtype=bool)
    return np.diff(numbers(log, "time_s"))[unseen].sum()


def top_view(facts, log):
    room, ball = facts["room_m"], np.reshape(facts["ball"]["path_m"], (-1, 2))
    log = [step for step in log if step["x_m"]]  # what a peer told of the truth
    path = np.column_stack([numbers(log, "x_m"), numbers(log, "y_m")])
    low, high = shown_floor(room, np.vstack([path, ball]))
    plot = map_axes("From above", (low[0], high[0]), (low[1], high[1]), "x (m)", "y (m)", 520)
    draw_room(plot, room)
    draw_obstacles(plot, facts["obstacles"])
    if log:
        yaw = numbers(log, "yaw_rad")
        curve(plot, *ball.T, color=BALL)
        curve(plot, *path.T, color=ROBOT, linewidth=2)
        for moment in range(MOMENTS):
            k = (len(log) - 1) * moment // (MOMENTS - 1)
            draw_robot(plot, facts["footprint_m"], path[k], yaw[k], ROBOT, dashed=0 < moment < MOMENTS - 1,
                       arrow=moment == MOMENTS - 1)
        plot.add_patch(Circle(ball[-1], facts["ball"]["radius_m"], color=BALL, alpha=0.8))
        plot.add_patch(Circle(ball[-1], facts["distance_m"], fill=False, color=GOAL, linewidth=1.2, linestyle="--", zorder=2))
        plot.annotate("start", path[0], (0, 22), textcoords="offset points", ha="center")
    return Drawing(plot, "Robot path (with its footprint at seven moments), ball, and the circle of the desired distance "
                   "around it (dashed).")


def shown_floor(room, points, margin_m=0.8):
    """The floor around these points, within the walls: its low and high corner."""
    walls = np.reshape(room, (2, 2)) + [[-0.1], [0.1]]
    if len(points) == 0:
        return walls
    return np.maximum(points.min(axis=0) - margin_m, walls[0]), np.minimum(points.max(axis=0) + margin_m, walls[1])


def image_trace(facts):
    width, height = facts["picture_px"]
    plot = map_axes("The ball's way through the picture", (-0.5, width - 0.5), (height - 0.5, -0.5), "u (px)", "v (px)",
                    520)
    truth, measured = facts["image"]["truth_px"], facts["image"]["measured_px"]
    curve(plot, *columns(truth), color=COLORS[0], linewidth=1.5)
    plot.plot(*columns(measured), ".", color=COLORS[1], markersize=3)
    for name, color, style in (("desired", COLORS[2], "--"), ("first", COLORS[0], "-"), ("last", COLORS[0], "-")):
        outline = facts["image"]["outlines_px"].get(name) or []
        curve(plot, *columns(outline + outline[:1]), color=color, linestyle=style, linewidth=1.2)
    return Drawing(plot, "Line: true centre of the outline. Dots: as measured. Circles: the outline in the first and the "
                   "last frame, and where it should end (dashed).")


def columns(points):
    """Points as x and y; None is a gap."""
    return np.reshape([p or (np.nan, np.nan) for p in points], (-1, 2)).T


def error_plots(facts, summary, log):
    time, range_mm = numbers(log, "time_s"), 1e3 * (numbers(log, "range_m") - facts["distance_m"])
    bearing_deg = np.degrees(numbers(log, "bearing_rad"))
    limit_mm, limit_deg = 1e3 * facts["reached"]["range_m"], math.degrees(facts["reached"]["bearing_rad"])
    plots = [whole(time, range_mm, "Distance error", "range error (mm)"),
             whole(time, bearing_deg, "Bearing error", "bearing (deg)")]
    settled_s = summary["settled_s"]
    if settled_s is not None:
        plots += [ending(time, range_mm, limit_mm, settled_s, "Distance error at the end", "range error (mm)"),
                  ending(time, bearing_deg, limit_deg, settled_s, "Bearing error at the end", "bearing (deg)")]
    return plots + [own_errors(facts, log), clearance(log)]


def whole(time, error, title, label):
    plot = axes(title, "time (s)", label)
    goal_line(plot, 0)
    curve(plot, time, error)
    return Drawing(plot, "The whole run.")


def ending(time, error, limit, settled_s, title, label):
    plot = axes(title, "time (s)", label)
    curve(plot, time, error)
    goal_line(plot, limit, "limit")
    goal_line(plot, -limit)
    goal_line(plot, settled_s, "settled", vertical=True)
    begin = max(0.0, settled_s - 0.5)
    plot.set(xlim=(begin, max(time[-1], begin + 0.1)), ylim=(-1.2 * limit, 1.2 * limit))
    return Drawing(plot, 'Within the limits of "reached".')


def own_errors(facts, log):
    plot = axes("The law's own errors", "time (s)", "error")
    for k, name in enumerate(FEATURES.get(facts["law"], ("error 1", "error 2")), 1):
        curve(plot, numbers(log, "time_s"), numbers(log, f"error_{k}"), name)
    legend(plot)
    return Drawing(plot, f"Features less desired features of law {facts['law']}, predicted for the moment when the command "
                   "acts.")


def clearance(log):
    plot = axes("Clearance", "time (s)", "clearance (m)")
    curve(plot, numbers(log, "time_s"), numbers(log, "clearance_m"))
    return Drawing(plot, "From the footprint to the nearest wall or obstacle.")


def command_plot(log, name, suffix, title, label, caption, unit=lambda value: value):
    plot = axes(title, "time (s)", label)
    time = numbers(log, "time_s")
    curve(plot, time, unit(numbers(log, f"{name}_{suffix}")), "driven")
    curve(plot, time, unit(numbers(log, f"{name}_command_{suffix}")), "commanded", linestyle="--")
    legend(plot)
    return Drawing(plot, caption)


def state_changes(log):
    """From when the controller was in which state, and why."""
    changes, before = [], None
    for step in log:
        if (step["state"], step["reason"]) != before:
            changes.append((text_of(step["time_s"]), step["state"], step["reason"]))
        before = (step["state"], step["reason"])
    return changes
