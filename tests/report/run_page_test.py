"""The page of a closed-loop run."""
import csv
import json
import math
import re
import shlex
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path
from unittest import mock

from pages import HOSTILE, PROGRAM, ROOT, SCRATCH, PageTest, drawn, main, page_of, program, titles

SCENARIO = ROOT / "data/scenarios/static_ball.yaml"
REACHED, SEEN = SCRATCH / "reached", SCRATCH / "seen"


def setUpModule():
    program("servo", SCENARIO, "-o", REACHED, "--perception", "geometric", "--seed", 3)
    program("servo", SCENARIO, "-o", SEEN, "--seed", 3, "--set", "duration_s=0.5", code=1)


class RunPage(PageTest):
    def test_drawn_again_it_is_the_same_file(self):
        folder = self.copy(REACHED)
        before = (folder / "report.html").read_bytes()
        (folder / "report.html").unlink()
        self.assertEqual(program("report", folder).stdout.strip(), str(folder / "report.html"))
        self.assertEqual((folder / "report.html").read_bytes(), before)

    def test_holds_every_figure(self):
        self.assertEqual(titles(page_of(REACHED)),
                         ["From above", "The ball&#39;s way through the picture", "Distance error", "Bearing error",
                          "Distance error at the end", "Bearing error at the end", "The law&#39;s own errors",
                          "Clearance", "Forward speed", "Turning rate"])

    def test_tells_the_figures_of_the_summary(self):
        folder = self.copy(REACHED)
        html, s = drawn(folder), json.loads((folder / "summary.json").read_text())
        self.assertIn(f"reached: {s['outcome_text']}.</p>", html)
        for text in (f"{1e3 * s['range_error_m']:.2f} mm", f"{math.degrees(s['bearing_error_rad']):.3f} deg",
                     f"{s['settled_s']:.2f} s", f"{s['settled_s'] / s['time_optimal_s']:.2f}",
                     f"{s['min_clearance_m']:.2f} m", f"{s['steps']}"):
            self.assertIn(f"<td>{text}</td>", html)
        self.assertIn("time-optimal run that turns first, then drives</th>", html)

    def test_tells_out_of_view_from_not_seen(self):
        folder = self.copy(REACHED)
        with open(folder / "log.csv", newline="") as log:
            steps = list(csv.DictReader(log))
        for unseen, shown in ((0, "0.00"), (50, "1.00")):  # 50 steps a second
            with open(folder / "log.csv", "w", newline="") as log:
                table = csv.DictWriter(log, steps[0])
                table.writeheader()
                table.writerows({**step, "track_state": ("coasting", "none", "confirmed", "tentative")[k % 2 + 2 * (k >= unseen)]}
                                for k, step in enumerate(steps))
            self.assertRegex(drawn(folder), rf"not seen, for whatever reason</th><td>{shown} s of \d")
        self.assertIn("ball in free sight, outside the picture</th>", drawn(folder))

    def test_says_how_to_repeat_it(self):
        html = page_of(REACHED)
        self.assertIn("seed 3", html)
        command = re.search('<pre class="wrap">(.*)</pre>', html).group(1)
        program(*shlex.split(command)[1:])
        self.assertEqual((SCRATCH / "again/log.csv").read_bytes(), (REACHED / "log.csv").read_bytes())

    def test_is_coloured_by_its_outcome(self):
        self.assertIn('<p class="note good">reached', page_of(REACHED))
        self.assertIn('<p class="note bad">', page_of(SEEN))

    def test_names_the_laws_errors(self):
        folder = self.copy(REACHED)
        for law, names in (("cone", (">log of the range<", ">azimuth (rad)<")), ("my own", (">error 1<", ">error 2<"))):
            self.edit(folder, "report.json", lambda facts: facts.update(law=law))
            for name in names:
                self.assertIn(name, drawn(folder))

    def test_a_run_that_did_not_settle_has_no_ending_and_a_dash(self):
        html = page_of(SEEN)
        self.assertNotIn("Distance error at the end", titles(html))
        self.assertRegex(html, r"settled after</th><td>-</td>")

    def test_shows_the_key_frames(self):
        folder = self.copy(SEEN)
        frames = json.loads((folder / "report.json").read_text())["key_frames"]
        self.assertGreater(len(frames), 1)
        self.assertEqual(drawn(folder).count("data:image/jpeg"), len(frames))

    def test_shows_each_change_of_the_controllers_state_once(self):
        folder = self.copy(REACHED)
        with open(folder / "log.csv", newline="") as log:
            words = [(row["state"], row["reason"]) for row in csv.DictReader(log)]
        changes = sum(now != before for now, before in zip(words, [None, *words]))
        table = drawn(folder).split("What the controller did, and why")[1].split("</table>")[0]
        self.assertEqual(table.count("<tr>"), 1 + changes)

    def test_shows_a_film_where_there_is_one(self):
        folder = self.copy(REACHED)
        self.assertNotIn("<video", drawn(folder))
        (folder / "video.mp4").touch()
        self.assertIn('src="video.mp4"', drawn(folder))

    def test_escapes_every_text(self):
        folder = self.copy(SEEN)
        self.edit(folder, "report.json", lambda facts: facts.update(
            title=HOSTILE, law=HOSTILE, perception=HOSTILE,
            key_frames=[{**frame, "caption": HOSTILE} for frame in facts["key_frames"]]))
        self.edit(folder, "summary.json", lambda facts: facts.update(outcome=HOSTILE, outcome_text=HOSTILE))
        self.edit(folder, "manifest.json", lambda facts: facts.update(scenario={HOSTILE: HOSTILE}))
        log = (folder / "log.csv").read_text().splitlines()
        cells = log[1].split(",")
        cells[10] = '"' + HOSTILE.replace('"', '""') + '"'
        (folder / "log.csv").write_text("\n".join([log[0], ",".join(cells), *log[2:]]))
        self.assertGreaterEqual(drawn(folder).count("&lt;script&gt;"), 7)

    def test_takes_pictures_from_its_own_folder_only(self):
        folder = self.copy(SEEN)
        self.edit(folder, "report.json",
                  lambda facts: facts["key_frames"][0].update(file="../../../../../../../etc/passwd"))
        with self.assertRaises(FileNotFoundError):
            drawn(folder)

    def test_stands_a_run_without_steps_and_one_with_a_single_step(self):
        folder = self.copy(REACHED)
        lines = (folder / "log.csv").read_text().splitlines()
        for steps in (1, 0):
            (folder / "log.csv").write_text("\n".join(lines[:1 + steps]) + "\n")
            self.edit(folder, "report.json", lambda facts: (
                facts["ball"].update(path_m=facts["ball"]["path_m"][:steps]),
                facts["image"].update(truth_px=[], measured_px=[], outlines_px={"desired": []})))
            self.edit(folder, "summary.json", lambda facts: facts.update(dict.fromkeys(
                ("settled_s", "time_optimal_s", "range_error_m", "bearing_error_rad", "min_clearance_m"))))
            self.assertEqual(len(titles(drawn(folder))), 8)

    def test_stands_numbers_that_cannot_be_drawn(self):
        folder = self.copy(REACHED)
        text = (folder / "log.csv").read_text().splitlines()
        for line, value in enumerate(("", "nan", "inf", "-1e308"), 5):
            cells = text[line].split(",")
            for place in (5, 6, 12, 13, 15, 16):
                cells[place] = value
            text[line] = ",".join(cells)
        (folder / "log.csv").write_text("\n".join(text))
        drawn(folder)


class ReportCommand(PageTest):
    def test_refuses_what_is_no_folder_of_results(self):
        self.assertIn("no report.json", program("report", SCRATCH, code=2).stderr)
        folder = self.copy(REACHED)
        for text in ("", "[]", "{}", '{"page": "no page"}', '{"page": "run"}', '{"page": ["run"]}'):
            (folder / "report.json").write_text(text)
            (folder / "report.html").write_text("as it was")
            self.assertIn("not as ballservo writes it", program("report", folder, code=2).stderr, text)
            self.assertEqual((folder / "report.html").read_text(), "as it was")

    def test_draws_several_folders_and_says_where(self):
        folders = [self.copy(REACHED), self.copy(SEEN)]
        self.assertEqual(program("report", *folders, "--quiet").stdout.split(),
                         [str(folder / "report.html") for folder in folders])

    def test_neither_imports_nor_reads_settings_from_where_it_is_called(self):
        for name in ("matplotlib.py", "jinja2.py", "ballservo.py"):
            (SCRATCH / name).write_text("raise SystemExit('imported from the working folder')")
            self.addCleanup((SCRATCH / name).unlink)
        (SCRATCH / "matplotlibrc").write_text("no such setting\n")
        self.addCleanup((SCRATCH / "matplotlibrc").unlink)
        folder = self.copy(REACHED)
        before = (folder / "report.html").read_bytes()
        self.assertEqual(program("report", folder, "--quiet", PYTHONPATH=str(SCRATCH)).stderr, "")
        self.assertEqual((folder / "report.html").read_bytes(), before)

    def test_an_interrupt_ends_it_cleanly(self):
        folders = [self.copy(REACHED) for _ in range(8)]
        for folder in folders:
            (folder / "report.html").write_text("as it was")
        for after_s in (0, 0.4):
            drawing = subprocess.Popen([PROGRAM, "report", *folders], stderr=subprocess.PIPE, text=True)
            while not Path(f"/proc/{drawing.pid}/task/{drawing.pid}/children").read_text():
                time.sleep(0.01)
            time.sleep(after_s)
            drawing.send_signal(signal.SIGINT)
            self.assertEqual((drawing.communicate()[1].splitlines()[-1], drawing.returncode),
                             ("ballservo: interrupted", 130))
            for folder in folders:  # each page is the old one or a whole new one, whenever the signal came
                page = (folder / "report.html").read_text()
                self.assertTrue(page == "as it was" or page.rstrip().endswith("</html>"), page[-200:])
                self.assertEqual([file.name for file in folder.iterdir() if file.name.startswith("report.html")],
                                 ["report.html"])

    def test_needs_no_home(self):
        self.assertEqual(program("report", self.copy(REACHED), "--quiet", HOME="/nowhere").stderr, "")

    def test_without_matplotlib_a_run_stands_without_a_page(self):
        folder = SCRATCH / "undrawn"
        done = program("servo", SCENARIO, "-o", folder, "--perception", "geometric", "--set", "duration_s=1", code=1,
                       MPLBACKEND="no such backend")
        self.assertIn("report.html not drawn", done.stderr)
        self.assertIn("`ballservo report", done.stderr)
        self.assertTrue((folder / "summary.json").exists())
        self.assertFalse((folder / "report.html").exists())
        program("report", folder)

    def test_names_the_packages_that_are_missing(self):
        with mock.patch.dict(sys.modules, {"jinja2": None, "ballservo.report.page": None}):
            with self.assertRaisesRegex(SystemExit, "install python3-matplotlib python3-jinja2"):
                main([self.copy(REACHED)])

    def test_says_which_file_is_none(self):
        for name, text, said in (
                ("log.csv", "", "log.csv: found an empty file"), ("log.csv", "a\r\rb", "log.csv: found no CSV"),
                ("summary.json", "null", "summary.json: found no object"),
                ("report.json", "[" * 100000, "report.json: found no JSON"), ("report.json", "{}", "no 'page'")):
            folder = self.copy(REACHED)
            (folder / name).write_text(text)
            self.assertIn(f"not as ballservo writes it: {said}", program("report", folder, code=2).stderr, text[:9])


if __name__ == "__main__":
    unittest.main()
