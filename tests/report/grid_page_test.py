"""The page of a grid: curves for one key, maps for two, a table for any number."""
import unittest

from pages import HOSTILE, ROOT, SCRATCH, PageTest, drawn, program, titles

SCENARIO = ROOT / "data/scenarios/static_ball.yaml"
GAIN, LAW, PITCH = ("--vary", "law.gain_per_s=0.5,1,2"), ("--vary", "law.name=cone,visp"), ("--vary", "duration_s=20,30")


def setUpModule():
    for name, vary in ("one", GAIN), ("words", LAW), ("two", GAIN + LAW), ("three", GAIN + LAW + PITCH):
        program("sweep", SCENARIO, "-o", SCRATCH / name, "--trials", 2, "--perception", "truth", *vary)


class GridPage(PageTest):
    def test_figures_follow_the_number_of_keys(self):
        for name, figures in (("one", ["Reached", "Settling time"]), ("words", ["Reached", "Settling time"]),
                              ("two", ["Reached (%)", "Settling time (s)"]), ("three", [])):
            with self.subTest(name):
                html = drawn(self.copy(SCRATCH / name))
                self.assertEqual(titles(html), figures)
                cells = {"one": 3, "words": 2, "two": 6, "three": 12}[name]
                self.assertEqual(html.count("2 of 2: 100.0 % ("), cells)

    def test_drawn_again_it_is_the_same_file(self):
        folder = self.copy(SCRATCH / "two")
        before = (folder / "report.html").read_bytes()
        program("report", folder)
        self.assertEqual((folder / "report.html").read_bytes(), before)

    def test_says_when_it_is_a_part_or_was_interrupted(self):
        folder = self.copy(SCRATCH / "one")
        self.edit(folder, "summary.json", lambda held: held.update(shard="2/3", interrupted=True, trials_planned=99))
        html = drawn(folder)
        self.assertIn("Part 2/3", html)
        self.assertIn("of 99 trials are done", html)

    def test_escapes_every_text(self):
        folder = self.copy(SCRATCH / "words")
        self.edit(folder, "report.json", lambda held: held.update(title=HOSTILE))
        self.edit(folder, "report.json", lambda held: held["grid"][0].update(key=HOSTILE))
        self.edit(folder, "summary.json", lambda held: [cell["values"].update({HOSTILE: HOSTILE})
                                                        for cell in held["cells"]])
        self.assertNotIn("<script>", drawn(folder))

    def test_a_suite_has_a_row_a_scenario_and_says_what_went_wrong(self):
        suite = SCRATCH / "suite.yaml"
        suite.write_text(f"scenarios: [{SCENARIO}, {SCENARIO.with_name('moving_ball.yaml')}]")
        program("sweep", suite, "-o", SCRATCH / "suite", "--trials", 2, "--perception", "truth", "--set", "duration_s=1")
        html = drawn(self.copy(SCRATCH / "suite"))
        self.assertEqual(html.count("0 of 2: 0.0 % ("), 2)
        for said in "static_ball", "moving_ball", "What went wrong", "timeout":
            self.assertIn(said, html)
        self.assertNotIn("less the first cell", html)  # of another world
        self.assertNotIn("nan", html)

    def test_stands_cells_without_a_success(self):
        program("sweep", SCENARIO, "-o", SCRATCH / "none", "--trials", 2, "--perception", "truth", "--set",
                "duration_s=1", *GAIN, *LAW)
        self.assertIn("0 of 2: 0.0 % (", drawn(self.copy(SCRATCH / "none")))


if __name__ == "__main__":
    unittest.main()
