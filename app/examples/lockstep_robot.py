#!/usr/bin/python3
"""A robot that ballservo drives in lockstep: two wheels, and eyes that tell where the ball is.

    python3 app/examples/lockstep_robot.py 5577 &
    ballservo servo data/scenarios/static_ball.yaml -o run --perception geometric --peer tcp://127.0.0.1:5577

The messages are those of app/peer/README.md. A real robot keeps its wheels and its camera where this one computes.
"""
import sys
from math import atan2, cos, hypot, sin

import zmq

TICK_S = 0.001


class Robot:
    def __init__(self, scenario):
        pose, ball, camera = scenario["robot"]["pose"], scenario["balls"][0]["position"], scenario["camera"]
        self.x, self.y, self.yaw = pose["x_m"], pose["y_m"], pose["yaw_rad"]
        self.ball, self.mount = (ball["x_m"], ball["y_m"], ball["z_m"]), camera["mount"]
        self.rate_hz, self.latency_s = camera["rate_hz"], camera["latency_s"]
        self.delay_s = scenario["robot"]["actuation_delay_s"]
        self.v = self.w = 0.0
        self.ticks = self.frames_taken = 0
        self.wanted, self.told, self.seen = (0.0, 0.0), [], []

    def advance(self, until_s):
        while self.ticks * TICK_S < until_s - 1e-9:
            while self.told and self.told[0][0] <= self.ticks * TICK_S + 1e-9:
                self.wanted = self.told.pop(0)[1]
            self.v += max(-0.3 * TICK_S, min(0.3 * TICK_S, self.wanted[0] - self.v))  # m/s^2
            self.w += max(-1.7 * TICK_S, min(1.7 * TICK_S, self.wanted[1] - self.w))  # rad/s^2
            self.yaw += self.w * TICK_S
            self.x += self.v * cos(self.yaw) * TICK_S
            self.y += self.v * sin(self.yaw) * TICK_S
            self.ticks += 1
            if self.ticks * TICK_S >= self.frames_taken / self.rate_hz:
                time_s = self.ticks * TICK_S
                self.seen.append({"frame": self.frames_taken, "time_s": time_s, "arrived_s": time_s + self.latency_s,
                                  "ball": self.look()})
                self.frames_taken += 1

    def look(self):
        """The ball in the camera's frame: x right, y down, z forward."""
        dx, dy = self.ball[0] - self.x, self.ball[1] - self.y
        ahead = cos(self.yaw) * dx + sin(self.yaw) * dy - self.mount["forward_m"]
        left, up = cos(self.yaw) * dy - sin(self.yaw) * dx, self.ball[2] - self.mount["up_m"]
        c, s = cos(self.mount["pitch_down_rad"]), sin(self.mount["pitch_down_rad"])
        p = [-left, -s * ahead - c * up, c * ahead - s * up]
        if p[2] < 0.1 or abs(p[0]) > 0.66 * p[2] or abs(p[1]) > 0.5 * p[2]:
            return None  # not in the picture
        return {"state": "confirmed", "p_m": p, "covariance_m2": [[1e-6, 0, 0], [0, 1e-6, 0], [0, 0, 1e-6]]}

    def answer(self, until_s):
        self.advance(until_s)
        arrived = [frame for frame in self.seen if frame["arrived_s"] <= until_s]
        self.seen = self.seen[len(arrived):]
        pose, twist = [self.x, self.y, self.yaw], [self.v, self.w]
        return {"ballservo_lockstep": 1, "time_s": until_s, "odometry": pose, "twist": twist, "frames": arrived,
                "truth": {"pose": pose, "twist": twist}}


line = zmq.Context().socket(zmq.REP)
line.bind(f"tcp://127.0.0.1:{sys.argv[1] if len(sys.argv) > 1 else 5577}")
robot = None
while True:
    if robot and not line.poll(200):  # ms
        print("nothing heard for 0.2 s: a real robot stops its wheels here", file=sys.stderr)
        line.poll()
    request = line.recv_json()
    if robot is None or "scenario" in request:
        robot = Robot(request["scenario"])
    if "end" in request:
        away_m = hypot(robot.ball[0] - robot.x, robot.ball[1] - robot.y)
        turn_rad = atan2(robot.ball[1] - robot.y, robot.ball[0] - robot.x) - robot.yaw
        print(f"{request['end']}: {away_m:.3f} m from the ball, {turn_rad:.4f} rad aside")
        break
    robot.told.append((robot.ticks * TICK_S + robot.delay_s, request["command"]))
    line.send_json(robot.answer(request["until_s"]))
