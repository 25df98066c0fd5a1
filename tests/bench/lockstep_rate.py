#!/usr/bin/python3
"""Control steps a second of wall time, our program on both sides of a lockstep and alone: lockstep_rate.py PROGRAM.

What a start and a page cost falls away: a long run less a short one.
"""
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SCENARIO = Path(__file__).resolve().parents[2] / "data/scenarios/moving_ball.yaml"
PROGRAM, ADDRESS = Path(sys.argv[1]).resolve(), "tcp://127.0.0.1:5591"


def steps_and_wall_s(level, seconds, sides):
    with tempfile.TemporaryDirectory() as place:
        began_s = time.monotonic()
        runs = [subprocess.Popen([PROGRAM, "servo", SCENARIO, "-o", f"run_{k}", "--quiet", "--perception", level,
                                  "--set", f"duration_s={seconds}", *side], cwd=place, stdout=subprocess.DEVNULL,
                                 stderr=subprocess.DEVNULL) for k, side in enumerate(sides)]
        for run in runs:
            run.wait()
        wall_s = time.monotonic() - began_s
        return json.loads((Path(place) / "run_0/summary.json").read_text())["steps"], wall_s


print("perception   steps/s in lockstep   alone")
for level, short_s, long_s in ("geometric", 5, 605), ("image", 2, 12):
    rates = []
    for sides in [["--serve", ADDRESS], ["--peer", ADDRESS]], [[]]:
        (few, short_wall_s), (many, long_wall_s) = (steps_and_wall_s(level, each, sides) for each in (short_s, long_s))
        rates.append((many - few) / (long_wall_s - short_wall_s))
    print(f"{level:12} {rates[0]:19.0f} {rates[1]:7.0f}")
