"""Lesson 5, your own robot: a model of it in Python, driven by the same controller.

The controller asks for a forward speed and a turning rate. Whatever can be told so and knows where it is can be
driven; how well shows here before anything is broken.
Run it: PYTHONPATH=build/release/python python3 app/examples/lesson_5_your_own_robot.py
"""
import sys
from pathlib import Path

import numpy as np

import ballservo

SCENARIOS = Path(__file__).resolve().parents[2] / "data/scenarios"


class Bicycle:
    """Driven behind, where its pose is, and steered in front: it cannot turn on the spot, and takes its time."""

    def __init__(self, pose, wheelbase_m=0.3, steer_max_rad=0.7, steer_rate_radps=3.0, a_max_mps2=0.5):
        self.x_m, self.y_m, self.yaw_rad = pose
        self.wheelbase_m, self.steer_max_rad = wheelbase_m, steer_max_rad
        self.steer_rate_radps, self.a_max_mps2 = steer_rate_radps, a_max_mps2
        self.time_s = self.v_mps = self.steer_rad = 0.0
        self.told = 0.0, 0.0

    def command(self, v_mps, w_radps):
        self.told = v_mps, w_radps

    def advance(self, time_s):
        steps = int(np.ceil((time_s - self.time_s) / 0.002))
        for _ in range(steps):
            dt = (time_s - self.time_s) / steps
            v, w = self.told
            steer = np.arctan(self.wheelbase_m * w / v) if abs(v) > 1e-3 else 0.0
            steer = np.clip(steer, -self.steer_max_rad, self.steer_max_rad)
            self.v_mps += np.clip(v - self.v_mps, -self.a_max_mps2 * dt, self.a_max_mps2 * dt)
            self.steer_rad += np.clip(steer - self.steer_rad, -self.steer_rate_radps * dt, self.steer_rate_radps * dt)
            self.x_m += self.v_mps * np.cos(self.yaw_rad) * dt
            self.y_m += self.v_mps * np.sin(self.yaw_rad) * dt
            self.yaw_rad += self.turning_radps() * dt
        self.time_s = max(self.time_s, time_s)
        return self.x_m, self.y_m, self.yaw_rad, self.v_mps, self.turning_radps()

    def turning_radps(self):
        return self.v_mps * np.tan(self.steer_rad) / self.wheelbase_m


# A ball that rolls and is thrown back by a wall: how far off the goal (95 % of the time from 5 s on) is the
# scenario's own robot, with two driven wheels, and how far is ours, the tighter it steers?
scenario = ballservo.Scenario(SCENARIOS / "moving_ball.yaml", seed=2)
print("robot                      range mm   bearing deg   outcome")
for name, steer_max_rad in ("two driven wheels", None), ("bicycle", 0.7), ("bicycle", 0.3), ("bicycle", 0.15):
    robot = steer_max_rad and Bicycle(scenario.pose, steer_max_rad=steer_max_rad)
    run = ballservo.simulate(scenario, robot=robot)
    late = run.log["time_s"] > 5
    range_mm, bearing_deg = (np.quantile(abs(error[late]), 0.95) for error in (
        (run.log["range_m"] - scenario.goal_p_RB[0]) * 1e3, np.degrees(run.log["bearing_rad"])))
    print(f"{name:18} {steer_max_rad or '':6} {range_mm:10.1f} {bearing_deg:13.2f}   {run.summary['outcome']}")
    if (steer_max_rad or 0) >= 0.3 and (range_mm > 20 or bearing_deg > 3):
        sys.exit("the bicycle should follow the ball")

# Try: the resting ball of static_ball.yaml. Why is it hard to end straight before it, and what would a law need?
# Try: a robot whose wheels slip: v_mps times 0.9 on the way, told by advance as if they did not.
# Try: a law of your own for the bicycle (lesson 4), which steers by the curvature to the ball, 2 y / (x^2 + y^2).
