"""The page of a sweep."""
import json
import os
import re
import unittest

from pages import HOSTILE, ROOT, SCRATCH, PageTest, drawn, page_of, program, titles

SCENARIO = ROOT / "data/scenarios/clutter.yaml"
WHOLE, AGAINST, PART = SCRATCH / "whole", SCRATCH / "against", SCRATCH / "part"
DRAWN = ["Settling time", "Over the time-optimal run", "Distance error", "Bearing error", "Distance, rms",
         "Least clearance", "Ball out of view"]


def setUpModule():
    common = ("--trials", 6, "--set", "duration_s=12")  # some are too slow
    program("sweep", SCENARIO, "-o", WHOLE, *common)
    program("sweep", SCENARIO, "-o", AGAINST, *common, "--set", "law.name=visp", "--against", WHOLE)
    program("sweep", SCENARIO, "-o", PART, *common, "--shard", "2/3")


class SweepPage(PageTest):
    def test_drawn_again_it_is_the_same_file(self):
        folder = self.copy(AGAINST)
        before = (folder / "report.html").read_bytes()
        program("report", folder)
        self.assertEqual((folder / "report.html").read_bytes(), before)

    def test_holds_every_figure(self):
        worst = json.loads((WHOLE / "report.json").read_text())["worst"]
        self.assertEqual(titles(page_of(WHOLE)),
                         ["All ways from above", *(f"seed {trial['seed']}" for trial in worst),
                          *3 * ["Where it succeeds"], *DRAWN])

    def test_tells_the_figures_of_the_summary(self):
        html, s = page_of(WHOLE), json.loads((WHOLE / "summary.json").read_text())
        low, high = s["success_ci95"]
        text = (f"{s['reached']} of {s['trials'] - s['infeasible']}: {100 * s['success_rate']:.2f} % "
                f"(95 % interval {100 * low:.2f} % to {100 * high:.2f} %)")
        self.assertIn(f"Reached the ball: {text}.", html)
        self.assertIn(f"{s['settled_s']['p50']:.3g} s (5 %", html)
        self.assertIn(f"{1e3 * s['range_rms_m']['p50']:.3g} mm (5 %", html)
        for group in s["failures"]:
            self.assertIn(f"<td>{group['outcome']}</td>", html)
        for trial in json.loads((WHOLE / "report.json").read_text())["worst"]:
            self.assertIn(trial["command"].replace("'", "&#39;"), html)

    def test_tells_of_the_other_sweep_it_is_held_against(self):
        html, other = page_of(AGAINST), json.loads((AGAINST / "summary.json").read_text())["against"]
        self.assertIn("this sweep (law visp, perception geometric) less the other (law\ncone, perception geometric); "
                      f"{other['success']['pairs']} pairs", html)
        self.assertIn(f"{1e3 * other['median_differences']['range_rms_m']['median']:.4g} mm", html)
        self.assertNotIn("different worlds", html)
        self.assertNotIn("less the other", page_of(WHOLE))

    def test_says_when_it_is_a_part_or_was_interrupted(self):
        folder = self.copy(PART)
        self.assertIn("Part 2/3 of the sweep", drawn(folder))
        self.edit(folder, "summary.json", lambda summary: summary.update(interrupted=True))
        self.assertIn("Interrupted: 2 of 6 trials are done", drawn(folder))
        whole = page_of(WHOLE)
        self.assertNotIn("Part ", whole)
        self.assertNotIn("Interrupted", whole)

    def test_draws_success_by_what_seeds_drew(self):
        folder = self.copy(WHOLE)
        cell = {"value": 1.5, "trials": 4, "reached": 3, "low": 0.2, "high": 0.99}
        self.edit(folder, "report.json", lambda facts: facts.update(
            success_by=[{"key": "balls.0.x", "cells": [cell]}, {"key": HOSTILE, "cells": [cell, cell]}]))
        self.assertIn("Success by balls.0.x", titles(drawn(folder)))

    def test_escapes_every_text(self):
        folder = self.copy(AGAINST)
        self.edit(folder, "report.json", lambda facts: facts.update(
            title=HOSTILE, gain_warning=HOSTILE, scenario={HOSTILE: HOSTILE}, against={"law": HOSTILE, "perception": ""},
            worst=[{**trial, "command": HOSTILE} for trial in facts["worst"]]))
        self.edit(folder, "summary.json", lambda summary: (
            summary.update(law=HOSTILE, perception=HOSTILE, shard=HOSTILE),
            summary["against"].update(other=HOSTILE),
            summary.update(failures=[{"outcome": HOSTILE, "cause": HOSTILE, "count": 1, "seeds": [1]}])))
        trials = (folder / "trials.csv").read_text()
        (folder / "trials.csv").write_text(trials.replace("the robot reached the ball", "<script>alert(1)"))
        self.assertGreaterEqual(drawn(folder).count("&lt;script&gt;"), 10)

    def test_stands_one_trial_and_none_that_can_be(self):
        folder = self.copy(WHOLE)
        lines = (folder / "trials.csv").read_text().splitlines()
        seed = int(lines[1].split(",")[1])
        self.edit(folder, "report.json", lambda facts: facts.update(
            worst=[trial for trial in facts["worst"] if trial["seed"] == seed]))
        (folder / "trials.csv").write_text("\n".join(lines[:2]) + "\n")
        drawn(folder)
        (folder / "trials.csv").write_text(
            lines[0] + "\n" + re.sub(",reached,|,timeout,", ",infeasible,", lines[1]) + "\n")
        self.edit(folder, "report.json", lambda facts: facts.update(worst=[]))
        self.edit(folder, "summary.json", lambda summary: summary.update(
            reached=0, success_ci95=[None, None], failures=[]))
        self.assertIn("Reached the ball: -.", drawn(folder))

    def test_refuses_a_trace_that_is_none(self):
        for bad in ("", "{}", "[]", '{"seed":1}', '{"seed":"x"}', "[" * 100000):
            folder = self.copy(PART)
            (folder / "traces.jsonl").write_text(bad + "\n")
            self.assertIn("not as ballservo writes it", program("report", folder, code=2).stderr, bad[:20])

    def test_refuses_to_wait_for_a_pipe(self):
        folder = self.copy(WHOLE)
        (folder / "trials.csv").unlink()
        os.mkfifo(folder / "trials.csv")
        self.assertIn("trials.csv: found no regular file", program("report", folder, code=2).stderr)


if __name__ == "__main__":
    unittest.main()
