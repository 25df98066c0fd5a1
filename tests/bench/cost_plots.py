#!/usr/bin/python3 -s
"""What a frame and a run cost, against what is in them: cost_plots.py BUILD [-o DIR] [--quick].

Draws cost_perception.png and cost_servo.png and writes their numbers, cost.csv. Everything is processor time of one
thread as a ratio, a median of rounds in which all take turns; bars go from the least to the greatest. The machine should
be idle for 10 minutes. --quick: the first points alone, hastily.
"""
import argparse
import csv
import json
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "app/python"))
from ballservo.report.page import COLORS, Figure  # noqa: E402

# Of each plot: what stands below it, and for each of its points a benchmark's name, or a scenario and its settings.
FRAMES = {
    "pixels": ("pixels (millions), one ball", {w * h / 1e6: f"{w}x{h}/cold" for w, h in (
        (320, 240), (640, 480), (1024, 683), (1280, 960), (1920, 1080))}),
    "balls": ("balls, 640x480", {n: f"640x480/cold/balls:{n}" for n in (0, 1, 2, 4, 8, 12)}),
    "boxes": ("boxes of nearly its colour more, 640x480", {n: f"640x480/cold/boxes:{n}" for n in (0, 4, 8, 16, 32)})}
WORLDS = {
    "worlds": ("", {name: (name,) for name in (
        "static_ball", "moving_ball", "corridor", "obstacles", "movers", "poles")}),
    "obstacles": ("obstacles in obstacles.yaml", {2 * n: ("obstacles", *(f"obstacles.{k}.count=[{n},{n}]" for k in (0, 1)))
                                                  for n in (0, 2, 4, 8)})}
LEVELS = {"geometric": 24, "image": 1}  # worlds a round


def perception(build, quick):
    """Ratios by plot, point and series: of detect's time and track's to that of reading the frame once."""
    for plot, (_, points) in FRAMES.items():
        names = "|".join(list(points.values())[:2 if quick else None])
        done = subprocess.run([build / "tests/bench/perception_bench", f"--benchmark_filter=^(read|detect|track)/({names})$",
                               "--benchmark_format=json", f"--benchmark_repetitions={2 if quick else 3}",
                               "--benchmark_enable_random_interleaving=true",
                               f"--benchmark_min_time={0.001 if quick else 0.3}"], stdout=subprocess.PIPE, check=True)
        times = {}
        for run in json.loads(done.stdout)["benchmarks"]:
            if run["run_type"] == "iteration":
                times.setdefault(run["run_name"].split("/repeats:")[0], []).append(run["cpu_time"])
        for x, name in points.items():
            for series in ("detect", "track"):
                for time, read in zip(times.get(f"{series}/{name}", ()), times.get(f"read/{name}", ())):
                    yield plot, x, series, time / read


def servo(build, quick):
    """Simulated seconds of the runs' first eight a second of the processor, without the program's start and its page."""
    with tempfile.TemporaryDirectory() as place:
        program = Path(shutil.copy(build / "app/ballservo", place))  # no Python package beside it: it draws no page

        def sweep(scenario, *sets, level, worlds, first, duration_s):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([program, "sweep", ROOT / f"data/scenarios/{scenario}.yaml", "-o", f"{place}/out", "--force", "--quiet",
                            "--threads", "1", "--perception", level, "--trials", str(worlds), "--seed", str(first),
                            *(f"--set={each}" for each in (f"duration_s={duration_s}", *sets))], check=True,
                           stdout=subprocess.DEVNULL, env={"LD_LIBRARY_PATH": str(build / "app")})
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            with open(f"{place}/out/trials.csv") as file:
                simulated_s = sum(float(trial["duration_s"] or 0) for trial in csv.DictReader(file))
            return simulated_s, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

        for turn in range(1 if quick else 3):
            _, start_s = sweep("static_ball", level="truth", worlds=1, first=0, duration_s=0.1)
            for plot, (_, points) in WORLDS.items():
                for x, words in list(points.items())[:2 if quick else None]:
                    for level, worlds in LEVELS.items():
                        simulated_s, used_s = sweep(*words, level=level, worlds=worlds, first=worlds * turn,
                                                    duration_s=1 if quick else 8)
                        yield plot, x, level, simulated_s / max(used_s - start_s, 1e-3)


def draw(file, plots, rows, y_label, **scale):
    figure = Figure(figsize=(840 / 72, 300 / 72))
    for axes, (plot, (x_label, points)) in zip(figure.subplots(1, len(plots), **scale), plots.items()):
        for series, color in zip(dict.fromkeys(row[2] for row in rows if row[0] == plot), COLORS):
            x, middle, least, most = zip(*((row[1], *row[3:]) for row in rows if row[0] == plot and row[2] == series))
            bars = [[m - low for m, low in zip(middle, least)], [high - m for m, high in zip(middle, most)]]
            axes.errorbar(x, middle, bars, color=color, label=series, capsize=3, marker="o", markersize=4,
                          linestyle="" if isinstance(x[0], str) else "-")
        axes.set(xlabel=x_label)
        if isinstance(next(iter(points)), str):
            axes.set_xticks(range(len(x)), x, rotation=35, ha="right", rotation_mode="anchor")
        axes.yaxis.set_major_formatter("{x:g}")
        if axes.get_yscale() == "linear":
            axes.set_ylim(bottom=0)
    figure.axes[0].set_ylabel(y_label)
    figure.axes[-1].legend()
    figure.savefig(file, dpi=144)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path)
    parser.add_argument("-o", dest="folder", type=Path, default=ROOT / "data/images")
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    found = {}
    for measure in perception, servo:
        for *which, ratio in measure(given.build.resolve(), given.quick):
            found.setdefault(tuple(which), []).append(ratio)
    rows = [(*which, *(float(f"{each:.3g}") for each in (statistics.median(ratios), min(ratios), max(ratios))))
            for which, ratios in found.items()]
    with open(given.folder / "cost.csv", "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(("plot", "x", "series", "median", "least", "greatest"))
        table.writerows(rows)
    draw(given.folder / "cost_perception.png", FRAMES, rows, "time / reading the frame once")
    draw(given.folder / "cost_servo.png", WORLDS, rows, "simulated s / processor s", sharey=True, subplot_kw={"yscale": "log"})


if __name__ == "__main__":
    main()
