"""Lesson 3, which estimator: the same pictures to every one, exact truth, and figures with their intervals.

A voted circle, the circle with the paper's formula, the sphere's exact outline; one step or to convergence: which
should place the ball?  Run it: PYTHONPATH=build/release/python python3 app/examples/lesson_3_which_estimator.py
"""
import sys
import tempfile
from pathlib import Path

import numpy as np

import ballservo

# A plan says what is rendered. Two questions: noise, and a ball off the axis, where a sphere is no circle.
PLAN = """
seed: 1
frames: 16
methods: [vote, paper_one_step, paper_converged, sphere_one_step, sphere_converged]
defaults: {camera: {focal_px: 500, width_px: 640, height_px: 480}, ball: {color: red, diameter_m: 0.07}, depth_m: 0.7}
conditions:
  - {name: on_axis, noise: {read: 2}}
  - {name: on_axis_noisy, noise: {read: 10}}
  - {name: off_axis, noise: {read: 2}, off_axis_rad: 0.48}
"""
with tempfile.TemporaryDirectory() as folder:
    plan = Path(folder) / "plan.yaml"
    plan.write_text(PLAN)
    tables = ballservo.compare(plan)
print("tables:", {name: len(next(iter(columns.values()))) for name, columns in tables.items()})

# fits: a row a method and frame; frames: the truth, a row a frame. Both in the camera's frame: z is the distance.
fits, frames = tables["fits"], tables["frames"]
true_z_m = dict(zip(zip(frames["condition"], frames["frame"]), frames["z_m"]))
fit_error_mm = 1e3 * (fits["z_m"] - [true_z_m[key] for key in zip(fits["condition"], fits["frame"])])
print("\ncolumns of fits:", list(fits))
error_mm = {}
for condition in dict.fromkeys(fits["condition"]):
    print(f"\n{condition}: error of the distance, mm    median      bias   95 % of them below")
    for method in dict.fromkeys(fits["method"]):
        of = (fits["condition"] == condition) & (fits["method"] == method)
        z_mm = fit_error_mm[of & np.isfinite(fit_error_mm)]
        error_mm[condition, method] = np.median(abs(z_mm))
        print(f"  {method:20} {len(z_mm):3} frames        {np.median(abs(z_mm)):10.2f} {np.mean(z_mm):+9.2f} "
              f"{np.quantile(abs(z_mm), 0.95):10.2f}")

# On the axis all fits agree. Off the axis the circle is the wrong model: more pictures do not help against a bias.
if error_mm["off_axis", "sphere_converged"] > error_mm["off_axis", "paper_converged"]:
    sys.exit("off the axis the sphere's outline should be nearer than the circle")

# Try: one step against converged: tables["pairs"] has both on the same frame. Is the difference worth its time?
# Try: frames: 100. Which of the differences above stay?
# Try: a condition {name: hidden, occlusion: 0.3}. Which estimator breaks first, and why?
