"""Figures for a paper: each of a page's as SVG and PDF at a column's width, and the script that draws both."""
import os
import re
import subprocess
import unittest
from pathlib import Path

import matplotlib
from pages import HOSTILE, ROOT, SCRATCH, PageTest, program

from ballservo.report import figures, page

SCENARIO = ROOT / "data/scenarios/static_ball.yaml"
RUN, FOLDERS = SCRATCH / "run", {}
COLUMN_PT = 85 / 25.4 * 72


def setUpModule():
    def results(name, *words):
        FOLDERS[name] = SCRATCH / name
        program(*words[:2], "-o", FOLDERS[name], *words[2:])
    results("run", "servo", SCENARIO, "--perception", "geometric", "--seed", 3)
    results("sweep", "sweep", ROOT / "data/scenarios/clutter.yaml", "--trials", 6, "--set", "duration_s=12")
    vary = ("--vary", "law.gain_per_s=0.5,1,2", "--vary", "camera.latency_s=0.03,0.1")
    results("grid", "sweep", SCENARIO, "--trials", 2, "--perception", "truth", *vary)
    results("band", "sweep", SCENARIO, "--trials", 2, "--perception", "truth", *vary[:2])
    (SCRATCH / "plan.yaml").write_text("frames: 4\nconditions:\n" + "".join(
        f"  - {{name: {name}, noise: {{read: {k}}}}}\n" for k, name in enumerate(("base", "noisy", "noisier"), 1)))
    results("comparison", "compare", "plan.yaml")


def run(script):
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "app/python"), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(["/usr/bin/python3", "-s", script], cwd=SCRATCH, env=environment, capture_output=True, text=True)


class FiguresForAPaper(PageTest):
    def written(self, folder):
        program("report", folder, "--figures")
        return sorted((folder / "figures").iterdir())

    def test_each_figure_of_a_page_is_there_three_times(self):
        folder = self.copy(FOLDERS["run"])
        names = ("bearing_error bearing_error_at_the_end clearance distance_error distance_error_at_the_end forward_speed "
                 "from_above the_ball_s_way_through_the_picture the_law_s_own_errors turning_rate").split()
        self.assertEqual([file.name for file in self.written(folder)],
                         [f"{name}.{kind}" for name in names for kind in ("pdf", "py", "svg")])

    def test_a_script_draws_the_same_files_by_itself(self):
        for name in FOLDERS:
            folder = self.copy(FOLDERS[name])
            scripts = [file for file in self.written(folder) if file.suffix == ".py"]
            for script in (scripts if name == "run" else scripts[-1:]):
                before = {kind: script.with_suffix(kind).read_bytes() for kind in (".svg", ".pdf")}
                for kind in before:
                    script.with_suffix(kind).unlink()
                self.assertEqual(run(script).stderr, "")
                for kind in before:
                    self.assertEqual(script.with_suffix(kind).read_bytes(), before[kind], script)

    def test_what_is_changed_in_a_script_is_drawn(self):
        folder = self.copy(FOLDERS["run"])
        self.written(folder)
        script = folder / "figures/clearance.py"
        self.assertLess(len(script.read_text().splitlines()), 20)
        script.write_text(script.read_text().replace("clearance (m)", "room left (m)").replace('"Clearance"', '"Room"'))
        self.assertEqual(run(script).stderr, "")
        self.assertIn("room left (m)", script.with_suffix(".svg").read_text())

    def test_changed_scripts_are_not_overwritten_unasked(self):
        folder = self.copy(FOLDERS["run"])
        self.written(folder)
        (folder / "figures/clearance.py").write_text("mine")
        self.assertIn("--force", program("report", folder, "--figures", code=2).stderr)
        self.assertEqual((folder / "figures/clearance.py").read_text(), "mine")
        program("report", folder)
        program("report", folder, "--figures", "--force")
        self.assertNotEqual((folder / "figures/clearance.py").read_text(), "mine")

    def test_texts_of_results_stay_comments_of_a_script(self):
        folder = self.copy(FOLDERS["run"])
        self.edit(folder, "report.json", lambda facts: facts.update(law=HOSTILE + '\nraise SystemExit(3)\r"""\nexit(3)\n'))
        self.written(folder)
        done = run(folder / "figures/the_law_s_own_errors.py")
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_all_is_as_wide_as_a_column_and_can_be_read(self):
        for folder in FOLDERS.values():
            module = page.module_of(folder)
            for name, drawing in figures.figures(module, folder).items():
                with self.subTest(f"{folder.name}: {name}"):
                    svg, pdf = (data for _, data in figures.pictures(drawing))
                    width, _ = map(float, re.search(rb'width="([\d.]+)pt" height="([\d.]+)pt"', svg).groups())
                    self.assertAlmostEqual(width, COLUMN_PT, delta=0.1)
                    self.assertNotRegex(pdf, rb"CreationDate|/Type3")
                    sizes = [float(size) for size in re.findall(rb"font: (?:bold |[\d.]+ )*([\d.]+)px", svg)]
                    self.assertGreaterEqual(min(sizes, default=6), 5.5)
                    with matplotlib.rc_context(figures.STYLE):
                        drawn = drawing.plot.figure
                        drawn.draw_without_rendering()
                        box = drawn.get_tightbbox(drawn.canvas.get_renderer() if hasattr(drawn.canvas, "get_renderer")
                                                  else None)
                    self.assertGreaterEqual(box.x0, -0.02)
                    self.assertLessEqual(box.x1, drawn.get_figwidth() + 0.02)


if __name__ == "__main__":
    unittest.main()
