"""The page of two cameras compared: how they disagree, and whether that means anything."""
import math

import numpy as np

from .page import INK, Drawing, enlargement, heat_map, number, read_json, text_of

COLOR_MEDIANS = 5  # the brightest colour stands for so many medians and more
MOST_PLACES = 8


def page(folder):
    facts = read_json(folder / "report.json")
    places = {name: np.array([number(place[name]) for place in facts["places"]]) for name in facts["places"][0]}
    places["ball_mm"] = np.linalg.norm([places[f"ball_d{axis}_mm"] for axis in "xyz"], axis=0)
    figures = [difference_map(facts, places)]
    if facts["ball_sigma_rms_mm"] is not None:
        figures.append(sigma_map(facts, places))
    return dict(
        title="Two cameras compared", subtitle=f"{facts['a']} and {facts['b']}", facts=facts,
        keys=key_figures(facts), figures=figures, worst=worst_places(places))


def key_figures(f):
    def degrees(value):
        return f"{math.degrees(value):.4f}"
    x, y, z = map(degrees, f["rotation_rad"])
    return [
        ("displacement in the picture", f"median {f['difference_median_px']:.4f} px, RMS {f['difference_rms_px']:.4f} px, "
         f"largest {f['difference_max_px']:.4f} px"),
        ("rotation taken out", f"{degrees(f['rotation_angle_rad'])} deg (about x {x}, y {y}, z {z})"),
        ("picture", f"{f['image_width_px']} x {f['image_height_px']} px")]


def ball_map(facts, title, values):
    high = min(facts["ball_difference_max_mm"], COLOR_MEDIANS * facts["ball_difference_median_mm"])
    return heat_map(title, "mm", (facts["image_width_px"], facts["image_height_px"]), facts["columns"], values, high, 760)


def difference_map(facts, places):
    plot = ball_map(facts, "Difference at the ball, and displacement in the picture", places["ball_mm"])
    spacing = 2 * facts["image_width_px"] / max(1, facts["columns"] - 1)
    length = np.hypot(places["dx_px"], places["dy_px"])
    scale = enlargement([facts["difference_median_px"]], 0.7 * spacing)
    row, column = np.divmod(np.arange(len(length)), facts["columns"])
    drawn = (row % 2 == 0) & (column % 2 == 0) & (scale * length < 3 * spacing)
    plot.quiver(*(places[name][drawn] for name in ("x_px", "y_px")),
                *(scale * places[name][drawn] for name in ("dx_px", "dy_px")), angles="xy", scale_units="xy", scale=1,
                color="#ffffff", edgecolor=INK, linewidth=0.4, width=0.003)
    return Drawing(plot, "Colour: how far apart the two read the ball's centre. Arrows, "
                   f"{scale:g} times as long as they are: from where the first camera sees a ray to where the second does; "
                   "overlong ones are left out. Without colour: the ball would not be wholly in the picture there.")


def sigma_map(facts, places):
    plot = ball_map(facts, "What the uncertainties let expect at the ball (1 sigma)", places["ball_sigma_mm"])
    return Drawing(plot, "Where this is large, the boards did not reach: photograph the board there.")


def worst_places(places):
    order = np.argsort(-np.nan_to_num(places["ball_mm"], nan=-1), kind="stable")
    rows = []
    for k in order[:MOST_PLACES]:
        if np.isnan(places["ball_mm"][k]):
            break
        cells = [np.hypot(places["dx_px"][k], places["dy_px"][k]),
                 *(places[name][k] for name in ("ball_dx_mm", "ball_dy_mm", "ball_dz_mm", "ball_mm", "ball_sigma_mm"))]
        rows.append((f"{places['x_px'][k]:.0f}, {places['y_px'][k]:.0f}", *(text_of(cell, 3) for cell in cells)))
    return rows
