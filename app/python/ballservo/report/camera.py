"""The page of a camera calibration: how far it can be trusted."""
import numpy as np

from .page import (Drawing, axes, drawable, enlargement, goal_line, heat_map, legend, map_axes, number, photo,
                  read_json, text_of)

MODES = ("along the radius", "across it")
LONGEST = 0.08  # of the picture's width: the longest residual as drawn


def page(folder):
    facts = read_json(folder / "report.json")
    width, height = facts["picture_px"]
    maps = [ball_map(facts, ball) for ball in facts["ball_maps"]]
    return dict(
        title="Camera calibration", facts=facts, keys=key_figures(facts), maps=maps,
        subtitle=f"{len(facts['boards'])} of {facts['looked_at']} pictures of {width} x {height} pixels",
        parameters=[(p["name"], f"{p['value']:.6g}", f"{number(p['sigma']):.2g}") for p in facts["parameters"]],
        trials=[(t["model"], pixels(t["rms_px"]), pixels(t["held_out_rms_px"]), t["remark"]) for t in facts["trials"]],
        residuals=[residual_map(facts), residuals_by_radius(facts)],
        boards=[photo(folder, board["file"], f"{board['name']}: RMS {board['rms_px']:.3f} px")
                for board in facts["boards"]])


def pixels(value):
    return "unknown" if value is None else f"{value:.3f} px"


def key_figures(f):
    sigma = "mm (1 sigma)"
    return [
        ("RMS over the corners", pixels(f["rms_px"])),
        ("RMS on boards held out", pixels(f["held_out_rms_px"])),
        ("noise of a corner's coordinate", pixels(f["noise_px"])),
        ("part of the RMS that depends on the place in the picture",
         "too few boards to tell" if f["structure_px"] is None else pixels(f["structure_px"])),
        ("part of the picture in which corners lie", f"{100 * f['coverage']:.0f} %"),
        ("correlation of the focal length with the boards' distance", text_of(f["focal_distance_correlation"], 3)),
        ("error at a 70 mm ball at 1 m from the calibration alone, worst place", text_of(f["ball_sigma_mm"], 2, sigma)),
        ("the same where boards were, typically", text_of(f["covered_ball_sigma_mm"], 2, sigma))]


def corners(board):
    """Where the corners were found, what is left of each (px), and which were set aside."""
    return (drawable(board["corners_px"]).reshape(-1, 2), drawable(board["residuals_px"]).reshape(-1, 2),
            np.array(board["set_aside"], dtype=bool))


def residual_map(facts):
    """Residuals as lines from each corner found, all boards in one picture."""
    width, height = facts["picture_px"]
    boards = [corners(board) for board in facts["boards"]]
    kept = [np.hypot(*residuals[~aside].T) for _, residuals, aside in boards]
    scale = enlargement(np.concatenate([*kept, [0]]), LONGEST * width)
    plot = map_axes(f"All corners, residuals {scale:g} times enlarged", (-0.5, width - 0.5), (height - 0.5, -0.5),
                    "u (px)", "v (px)", 520)
    for k, (found, residuals, aside) in enumerate(boards):
        ends = found + scale * residuals
        gap = np.full(len(found), np.nan)
        lines = np.stack([np.column_stack([found[:, i], ends[:, i], gap])[~aside].ravel() for i in (0, 1)])
        plot.plot(*lines, color=f"C{k % 7}", linewidth=1)
        plot.plot(*found[~aside].T, ".", color=f"C{k % 7}", markersize=3)
        plot.plot(*found[aside].T, "o", color=f"C{k % 7}", markersize=7)
    return Drawing(plot, "Every board has its colour. Each line leads from a corner found towards where the camera expects it.")


def residuals_by_radius(facts):
    plot = axes("Residuals by distance from the principal point", "distance (px)", "residual (px)", 520, 340)
    radius, along, across = [], [], []
    for board in facts["boards"]:
        found, residuals, aside = corners(board)
        out = found - facts["principal_point_px"]
        distance = np.hypot(*out.T)
        used = ~aside & (distance > 0)
        out = out[used] / distance[used, None]
        radius.extend(distance[used])
        along.extend(np.sum(out * residuals[used], axis=1))
        across.extend(out[:, 0] * residuals[used, 1] - out[:, 1] * residuals[used, 0])
    for values, name in ((along, MODES[0]), (across, MODES[1])):
        plot.plot(radius, values, ".", markersize=3, alpha=0.55, label=name)
    goal_line(plot, 0)
    legend(plot)
    return Drawing(plot, "A cloud around zero at every distance: the lens model suffices. A bend along the radius: it does not.")


def ball_map(facts, ball):
    """The rim would drown what the rest of the picture has to say: the scale ends at five medians."""
    values = np.array([number(value) for value in ball["sigma_mm"]])
    worst = np.nanmax(values)
    plot = heat_map(f"A ball at {ball['range_m']:g} m: at worst {worst:.2f} mm", "mm", facts["picture_px"], ball["columns"],
                    values, min(worst, 5 * np.nanmedian(values)))
    return Drawing(plot, f"1-sigma error of a 70 mm ball's centre at {ball['range_m']:g} m that the uncertainty of this camera's "
                   "parameters causes, by the ball's place in the picture; yellow is the scale's end and all above it.")
