"""Lesson 4, which law: four control laws, several gains, the same worlds for all.

All laws let their errors decay at a rate lambda; they differ in what they call an error (a cone's angle, a pixel, a
pose). Delay bounds the gain.  Run it: PYTHONPATH=build/release/python python3 app/examples/lesson_4_which_law.py
"""
import sys
from pathlib import Path

import numpy as np

import ballservo

SCENARIO = Path(__file__).resolve().parents[2] / "data/scenarios/static_ball.yaml"

# A grid: a sweep a cell, all over the same seeds, so that differences are between laws and not between worlds.
laws, gains_per_s = ["cone", "visp", "sphere", "pose"], [0.5, 1, 2, 4]
sweep = ballservo.sweep(SCENARIO, trials=8, vary={"law.name": laws, "law.gain_per_s": gains_per_s})
grid, shape = sweep.grid, (len(laws), len(gains_per_s))
print("columns of grid:", list(grid))
settled_s = grid["settled_s_p50"].reshape(shape)
reached = grid["reached"].reshape(shape)
print("\nmedian time to settle, s (and how many of 8 reached the ball)\ngain 1/s " + "".join(f"{g:14}" for g in gains_per_s))
for law, times, counts in zip(laws, settled_s, reached):
    print(f"{law:8} " + "".join(f"{t:9.2f} ({n:.0f})" for t, n in zip(times, counts)))

# Paired by seed: the same world under two laws. The spread of the difference is far below that of the times.
trials = sweep.trials
times_s = trials["settled_s"].reshape(*shape, 8)
difference = times_s[1] - times_s[0]
print(f"\nvisp less cone, gain 2: {np.nanmean(difference[2]):+.3f} s, standard deviation {np.nanstd(difference[2]):.3f} s; "
      f"that of the times themselves: {np.nanstd(times_s[0, 2]):.3f} s")
if (reached < 8).any() and settled_s[0, 0] < settled_s[0, 2]:
    sys.exit("every law should reach the ball, and a higher gain sooner")

# One run step by step: how fast does the error truly decay?
steps = []
run = ballservo.simulate(ballservo.Scenario(SCENARIO, ["law.gain_per_s=1"]), on_step=steps.append)
approach = [step for step in steps if step.state == "approach" and 0.02 < step.range_error_m < 0.3]
rate = np.polyfit([step.time_s for step in approach], np.log([step.range_error_m for step in approach]), 1)[0]
print(f"\ncone, gain 1: the range error decays at {-rate:.2f} 1/s; {run.summary['outcome_text']}")

# A law of your own is a function: from the ball's place and velocity (camera frame, m) to v (m/s) and w (rad/s).
scenario = ballservo.Scenario(SCENARIO)


def my_law(p_CB, v_CB):
    p_RB = scenario.X_RC[:3, :3] @ p_CB + scenario.X_RC[:3, 3]
    return 1.0 * (np.hypot(p_RB[0], p_RB[1]) - scenario.goal_p_RB[0]), 2.0 * np.arctan2(p_RB[1], p_RB[0])


run = ballservo.simulate(scenario, law=my_law)
off_m = run.log["range_m"][-1] - scenario.goal_p_RB[0]
print(f"my law: {run.summary['outcome_text']}; at the end {off_m * 1e3:+.2f} mm off")
if abs(off_m) > 0.01:
    sys.exit("a law in Python should drive to 1 cm")

# Try: vary={"law.gain_per_s": [1, 2, 4, 8], "camera.latency_s": [0.033, 0.1, 0.2]}: where does it begin to swing?
# Try: my_law without the turn (w = 0). What does the controller do when the ball leaves the picture?
# Try: scenario obstacles.yaml. Which part of the way is the law's now?
