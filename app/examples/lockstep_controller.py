#!/usr/bin/python3
"""A controller that drives ballservo's simulated robot to its ball, in lockstep.

    ballservo servo data/scenarios/static_ball.yaml -o run --perception geometric --serve tcp://127.0.0.1:5577 &
    python3 app/examples/lockstep_controller.py 5577

The messages are those of app/peer/README.md; with --perception image the parts after the first are the pictures.
"""
import sys
from math import atan2, hypot, sqrt

import zmq

line = zmq.Context().socket(zmq.REQ)
line.connect(f"tcp://127.0.0.1:{sys.argv[1] if len(sys.argv) > 1 else 5577}")
step, command, facts, ball = 0, [0.0, 0.0], None, None
while True:
    until_s = step / facts["rate_hz"] if facts else 0.0
    line.send_json({"ballservo_lockstep": 1, "until_s": until_s, "command": command})
    if not line.poll(30000):  # ms
        sys.exit("the robot is silent")
    answer = line.recv_json()
    if "over" in answer:
        print(answer["over"]["text"])
        sys.exit(answer["over"]["outcome"] != "reached")
    facts = facts or answer["robot"]
    for frame in answer["frames"]:
        if frame["ball"]:
            p_C = frame["ball"]["p_m"] + [1]
            ball = [sum(a * b for a, b in zip(row, p_C)) for row in facts["X_RC"][:3]]  # in the robot frame
        else:
            ball = None
    if ball:
        left_m = hypot(ball[0], ball[1]) - facts["distance_m"]
        braking_mps = sqrt(facts["a_max_mps2"] * abs(left_m))  # half of what the brakes can do
        speed_mps = min(abs(left_m), braking_mps, facts["v_max_mps"])
        command = [speed_mps if left_m > 0 else -speed_mps, 1.5 * atan2(ball[1], ball[0])]
    elif answer["frames"]:
        command = [0.0, 0.5]  # looks around
    step += 1
