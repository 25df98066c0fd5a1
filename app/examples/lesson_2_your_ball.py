"""Lesson 2, your ball: teach its colour with one picture, find it in others, and place it in space.

A ball of known diameter gives its distance by its outline alone: twice as far is half as large. The exact outline is
an ellipse, and its fit says how sure it is.  Run it: PYTHONPATH=build/release/python python3 app/examples/lesson_2_your_ball.py
"""
import sys
import warnings
from pathlib import Path

import numpy as np

import ballservo

DATA = Path(__file__).resolve().parents[2] / "data"
scenario = ballservo.Scenario(DATA / "scenarios/static_ball.yaml", ["balls.0.position.x_m=2.0", "balls.0.position.y_m=0"])
DIAMETER_M = 0.12

# Teach. One picture from near, and where the ball is in it (x, y, radius, px): as a user points at it.
near = scenario.look((1.2, 0, 0))
warnings.simplefilter("always")  # what is doubtful about a lesson is said
ball = ballservo.Detector(DATA / "colors/red.colors").detect(near)[0]
colors = ballservo.Colors.learn({"red": [near]}, at={"red": ball.outline_px})
print("learnt:", colors.classes, "in", np.mean(colors.classify(near) == 1) * 100, "% of the picture")

# Find and place. The truth is known here: p_WB through the robot's pose and the camera's mount.
detector = ballservo.Detector(colors, scenario.camera, DIAMETER_M)
print("\nrange m   seen at (camera frame) m       wrong by mm            sigma mm             Mahalanobis")
distances = []
for x_m in 1.4, 1.0, 0.6, 0.2, -0.2, -0.6, -1.0:
    balls = detector.detect(scenario.look((x_m, 0, 0.05)))
    if not balls:
        print(f"{2 - x_m:7.2f}   not seen")
        continue
    p_m, covariance_m2 = balls[0].p_m, balls[0].covariance_m2
    c, s = np.cos(0.05), np.sin(0.05)
    p_RB = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ (scenario.p_WB(0) - [x_m, 0, 0])
    p_CB = scenario.X_RC[:3, :3].T @ (p_RB - scenario.X_RC[:3, 3])
    wrong = p_m - p_CB
    distances.append(wrong @ np.linalg.solve(covariance_m2, wrong))
    print(f"{2 - x_m:7.2f}   {np.round(p_m, 4)}   {np.round(wrong * 1e3, 2)}   "
          f"{np.round(np.sqrt(np.diag(covariance_m2)) * 1e3, 2)}   {np.sqrt(distances[-1]):.2f}")

# The error grows with the square of the range, nearly all of it along the ray: r = R f / d, so dd = d^2 / (R f) dr.
# A covariance that is honest gives a squared Mahalanobis distance of 3 on the average.
print(f"\nmean squared Mahalanobis distance: {np.mean(distances):.2f} (3 would be perfect)")
if len(distances) < 6 or np.mean(distances) > 12:
    sys.exit("the ball should be found, and about as well as its covariance says")

# Try: DIAMETER_M = 0.126 (5 % too large). How does the error grow with range now, and does the covariance know?
# Try: "0.12+-0.006" for the diameter. What changes in the sigmas?
# Try: noise on the pictures, np.clip(bgr + chance.normal(0, 20, bgr.shape), 0, 255).astype(np.uint8).
