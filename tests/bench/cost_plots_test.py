#!/usr/bin/python3 -s
"""cost_plots.py from end to end, hastily: cost_plots_test.py BUILD."""
import csv
import subprocess
import sys
import tempfile
from pathlib import Path

with tempfile.TemporaryDirectory() as place:
    place = Path(place)
    subprocess.run([Path(__file__).with_name("cost_plots.py"), sys.argv[1], "-o", place, "--quick"], check=True)
    assert sorted(file.name for file in place.iterdir()) == ["cost.csv", "cost_perception.png", "cost_servo.png"]
    rows = list(csv.DictReader((place / "cost.csv").open()))

of = {(row["plot"], row["x"], row["series"]): [float(row[name]) for name in ("least", "median", "greatest")] for row in rows}
assert len(of) == len(rows) == 2 * 2 * 5, f"two series of two points in each of five plots, not {len(rows)} rows"
assert all(0 < each[0] <= each[1] <= each[2] for each in of.values()), of
assert of["pixels", "0.3072", "detect"][0] > 1, "detect is quicker than reading"
assert of["worlds", "static_ball", "image"][1] < of["worlds", "static_ball", "geometric"][1], "pictures cost nothing"
