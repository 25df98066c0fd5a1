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
    results("sweep", "sweep", SCENARIO, "--trials", 4, "--set", "duration_s=6.2")
    vary = ("--vary", "law.gain_per_s=0.5,1,2", "--vary", "camera.latency_s=0.03,0.1")
    results("grid", "sweep", SCENARIO, "--trials", 2, "--perception", "truth", *vary)
    results("band", "sweep", SCENARIO, "--trials", 2, "--perception", "truth", *vary[:2])
    (SCRATCH / "plan.yaml").write_text("frames: 4\nconditions:\n" + "".join(
        f"  - {{name: {name}, noise: {{read: {k}}}}}\n" for k, name in enumerate(("base", "noisy"), 1)))
    results("comparison", "compare", "plan.yaml")
    for folder in FOLDERS.values():
        figures.write_figures(page.module_of(folder), folder)


def run(*scripts):
    """In one interpreter, one after another."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "app/python"), "PYTHONDONTWRITEBYTECODE": "1"}
    each = "import runpy, sys\nfor script in sys.argv[1:]: runpy.run_path(script, run_name='__main__')"
    return subprocess.run(["/usr/bin/python3", "-s", "-c", each, *scripts], cwd=SCRATCH, env=environment,
                          capture_output=True, text=True)


class FiguresForAPaper(PageTest):
    def test_each_figure_of_a_page_is_there_three_times(self):
        names = ("bearing_error bearing_error_at_the_end clearance distance_error distance_error_at_the_end forward_speed "
                 "from_above the_ball_s_way_through_the_picture the_law_s_own_errors turning_rate").split()
        self.assertEqual(sorted(file.name for file in (FOLDERS["run"] / "figures").iterdir()),
                         [f"{name}.{kind}" for name in names for kind in ("pdf", "py", "svg")])

    def test_a_script_draws_the_same_files_by_itself(self):
        scripts, before = [], {}
        for name, folder in FOLDERS.items():
            of_page = sorted((self.copy(folder) / "figures").glob("*.py"))
            scripts += of_page if name == "run" else of_page[-1:]
        for file in (script.with_suffix(kind) for script in scripts for kind in (".svg", ".pdf")):
            before[file] = file.read_bytes()
            file.unlink()
        self.assertEqual(run(*scripts).stderr, "")
        for file in before:
            self.assertEqual(file.read_bytes(), before[file], file)

    def test_what_is_changed_in_a_script_is_drawn(self):
        folder = self.copy(FOLDERS["run"])
        script = folder / "figures/clearance.py"
        self.assertLess(len(script.read_text().splitlines()), 20)
        script.write_text(script.read_text().replace("clearance (m)", "room left (m)").replace('"Clearance"', '"Room"'))
        self.assertEqual(run(script).stderr, "")
        self.assertIn("room left (m)", script.with_suffix(".svg").read_text())

    def test_changed_scripts_are_not_overwritten_unasked(self):
        folder = self.copy(FOLDERS["band"])
        script = folder / "figures/settling_time.py"
        script.write_text("mine")
        self.assertIn("--force", program("report", folder, "--figures", code=2).stderr)
        program("report", folder)
        self.assertEqual(script.read_text(), "mine")
        program("report", folder, "--figures", "--force")
        self.assertNotEqual(script.read_text(), "mine")

    def test_texts_of_results_stay_comments_of_a_script(self):
        folder = self.copy(FOLDERS["run"])
        self.edit(folder, "report.json", lambda facts: facts.update(law=HOSTILE + '\nraise SystemExit(3)\r"""\nexit(3)\n'))
        module, name = page.module_of(folder), "the_law_s_own_errors"
        for number, (other, drawing) in enumerate(figures.figures(module, folder).items()):
            if other == name:
                (folder / f"figures/{name}.py").write_text(figures.script(name, number, drawing, module, ".."))
        done = run(folder / f"figures/{name}.py")
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_all_is_as_wide_as_a_column_and_can_be_read(self):
        for folder in FOLDERS.values():
            for name, drawing in figures.figures(page.module_of(folder), folder).items():
                with self.subTest(f"{folder.name}: {name}"):
                    svg, pdf = ((folder / f"figures/{name}.{kind}").read_bytes() for kind in ("svg", "pdf"))
                    width, _ = map(float, re.search(rb'width="([\d.]+)pt" height="([\d.]+)pt"', svg).groups())
                    self.assertAlmostEqual(width, COLUMN_PT, delta=0.1)
                    self.assertNotRegex(pdf, rb"CreationDate|/Type3")
                    sizes = [float(size) for size in re.findall(rb"font: (?:bold |[\d.]+ )*([\d.]+)px", svg)]
                    self.assertGreaterEqual(min(sizes, default=6), 5.5)
                    self.assertEqual(next(figures.pictures(drawing)), ("svg", svg))
                    drawn = drawing.plot.figure
                    with matplotlib.rc_context(figures.STYLE):
                        box = drawn.get_tightbbox(None)
                    self.assertGreaterEqual(box.x0, -0.02)
                    self.assertLessEqual(box.x1, drawn.get_figwidth() + 0.02)


if __name__ == "__main__":
    unittest.main()
