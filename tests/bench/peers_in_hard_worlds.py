#!/usr/bin/python3
"""Our robot and one that MRPT's navigation drives, in the same hard worlds: peers_in_hard_worlds.py BUILD [SEEDS].

Seeds from 1000 on, at level geometric; MRPT's robot in lockstep. For each world and controller: reached, collisions,
hit by a ball while the robot rested, the rest, median and 95 % of the time until the ball is reached.
"""
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import median

SCENARIOS = Path(__file__).resolve().parents[2] / "data/scenarios"
WORLDS = ["corridor", "dead_end", "door", "poles", "dense", "corner", "movers", "obstacles"]
BUILD, SEEDS = Path(sys.argv[1]).resolve(), range(1000, 1000 + int(sys.argv[2] if len(sys.argv) > 2 else 50))


def summary_of(world, seed, controller, port, folder):
    """One run. The navigator keeps its tables in `folder`, so the first run there takes longer."""
    run = folder / f"{controller}_{world}_{seed}"
    ours = [BUILD / "app/ballservo", "servo", SCENARIOS / f"{world}.yaml", "-o", run, "--quiet", "--perception",
            "geometric", "--seed", str(seed)]
    if controller == "ballservo":
        subprocess.run(ours, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    else:
        robot = subprocess.Popen([*ours, "--deadline", "60", "--serve", f"tcp://127.0.0.1:{port}"],
                                 stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        subprocess.run([BUILD / "tests/bench/mrpt_controller", str(port)], cwd=folder, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        robot.wait()
    return json.loads((run / "summary.json").read_text())


def row(world, controller, summaries):
    outcomes = Counter(each["outcome"] for each in summaries)
    unfinished = outcomes.total() - outcomes["reached"] - outcomes["collision"] - outcomes["hit_by"]
    settled_s = sorted(each["settled_s"] for each in summaries if each["outcome"] == "reached")
    times = f"{median(settled_s):8.1f} {settled_s[round(0.95 * (len(settled_s) - 1))]:8.1f}" if settled_s else ""
    return (f"{world:10} {controller:10} {outcomes.total():5} {outcomes['reached']:8} {outcomes['collision']:11} "
            f"{outcomes['hit_by']:12} {unfinished:11} {times}")


def main():
    workers = os.cpu_count()
    print("world      controller  runs  reached  collisions  hit at rest  unfinished  settled p50, p95 s")
    with tempfile.TemporaryDirectory() as place:
        def some(worker, world, controller):
            folder = Path(place) / str(worker)
            folder.mkdir(exist_ok=True)
            return [summary_of(world, seed, controller, 5600 + worker, folder) for seed in SEEDS[worker::workers]]

        for world in WORLDS:
            for controller in "ballservo", "mrpt":
                with ThreadPoolExecutor(workers) as pool:
                    parts = pool.map(some, range(workers), [world] * workers, [controller] * workers)
                    print(row(world, controller, [each for part in parts for each in part]), flush=True)


main()
