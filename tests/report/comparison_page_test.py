"""The page of a comparison."""
import json
import unittest

from pages import HOSTILE, SCRATCH, PageTest, drawn, page_of, program, titles

WHOLE = SCRATCH / "whole"
PLAN = """
frames: 6
conditions:
  - {name: base}
  - {name: noisy, noise: {read: 8}}
"""


def setUpModule():
    (SCRATCH / "plan.yaml").write_text(PLAN)
    program("compare", "plan.yaml", "-o", WHOLE)


class ComparisonPage(PageTest):
    def swept(self, folder):
        """The same with its two conditions as a sweep of one number."""
        self.edit(folder, "comparison.json", lambda setting: setting.update(conditions=[
            {**condition, "swept_key": "start.x", "swept_label": "blur (px)", "swept_value": k + 1, "swept_log": True}
            for k, condition in enumerate(setting["conditions"])]))

    def test_drawn_again_it_is_the_same_file(self):
        folder = self.copy(WHOLE)
        before = (folder / "report.html").read_bytes()
        program("report", folder)
        self.assertEqual((folder / "report.html").read_bytes(), before)

    def test_holds_every_figure(self):
        figures = titles(page_of(WHOLE))
        both = "Error of one step and of the converged fit, by condition"
        self.assertEqual(figures[:4], ["sphere_one_step against sphere_converged", both,
                                       "paper_one_step against paper_converged", both])
        for title in ("Error of the ball&#39;s centre in 3-D, median", "Where the errors lie: base",
                      "What each costs, and how well it does"):
            self.assertIn(title, figures)

    def test_draws_sweeps(self):
        folder = self.copy(WHOLE)
        self.swept(folder)
        text = (folder / "compare.csv").read_text()
        (folder / "compare.csv").write_text(text.replace("vote,6,6,0,", "vote,6,5,1,"))
        html = drawn(folder)
        for title in ("3-D error against blur (px)", "Balls found against blur (px)",
                      "Way to the converged fit against blur (px)"):
            self.assertIn(title, titles(html))
        self.assertIn("displaced: vote is that start", html)

    def test_tells_answers_and_methods(self):
        html, facts = page_of(WHOLE), json.loads((WHOLE / "report.json").read_text())
        for text in ("The exact fit (sphere_one_step): of 2 conditions, one step is enough in ", "The paper&#39;s fit: ",
                     "stepping on moves the ball by ", *(method["minimises"] for method in facts["methods"])):
            self.assertIn(text.replace("'", "&#39;"), html)

    def test_names_in_latex_are_escaped(self):
        folder = self.copy(WHOLE)
        drawn(folder)
        self.assertIn("sphere\\_one\\_step & 6/6 & ", (folder / "tables.tex").read_text())

    def test_tables_hold_every_row_of_the_files(self):
        html = page_of(WHOLE)
        rows = (WHOLE / "compare.csv").read_text().splitlines()
        methods = len({row.split(",")[1] for row in rows[1:]})
        for name in ("base", "noisy"):
            table = html.split(f"<summary>{name}:")[1].split("</details>")[0]
            self.assertEqual(table.count("<tr>"), 1 + methods)
        first = dict(zip(rows[0].split(","), rows[1].split(",")))
        self.assertIn(f"<td class=\"number\">{first['found']} of {first['frames']}</td>", html)

    def test_shows_each_picture_and_says_where_there_is_none(self):
        folder = self.copy(WHOLE)
        photos = json.loads((folder / "report.json").read_text())["photos"]
        shown = sum(map(len, photos.values()))
        self.assertGreater(shown, 2)
        self.assertEqual(drawn(folder).count('src="data:image/'), shown)
        self.edit(folder, "report.json", lambda facts: facts.update(photos={}))
        self.assertIn("The pictures are not at hand here", drawn(folder))

    def test_without_places_it_says_so(self):
        folder = self.copy(WHOLE)
        lines = [line.split(",") for line in (folder / "compare.csv").read_text().splitlines()]
        for name in ("position_median_mm", "position_median_low_mm", "position_median_high_mm"):
            column = lines[0].index(name)
            for line in lines[1:]:
                line[column] = ""
        (folder / "compare.csv").write_text("\n".join(map(",".join, lines)) + "\n")
        html = drawn(folder)
        self.assertIn("No place in space is known", html)
        self.assertEqual(len(titles(html)), 2)

    def test_rates_of_breaks_are_drawn_where_there_are_some(self):
        folder = self.copy(WHOLE)
        table = (folder / "certificate.csv").read_text().splitlines()
        row = dict(zip(table[0].split(","), table[1].split(",")))
        row.update(threshold="0.5", tested_frames="20", tested_breaks="9")
        (folder / "certificate.csv").write_text("\n".join((table[0], ",".join(row.values()))) + "\n")
        self.edit(folder, "summary.json", lambda summary: summary.update(certificates=[
            {"words": HOSTILE, "caught_rate": 0.5, "false_alarm_rate": None, "roc_area": 0.75}]))
        self.edit(folder, "report.json", lambda facts: facts.update(roc=[
            {"one_step": row["one_step"], "rule": "next_step", "false_alarms": [0, 0.5, 1], "caught": [0, 0.9, 1]}]))
        html = drawn(folder)
        self.assertIn("How well the rules tell breaks", titles(html))
        self.assertIn('<td class="number">50.0 %</td><td class="number">-</td><td class="number">0.750</td>', html)

    def test_escapes_every_text(self):
        folder = self.copy(WHOLE)

        def hostile(facts):
            facts.update(peer_settings=[HOSTILE])
            for method in facts["methods"]:
                method.update(minimises=HOSTILE)
            facts["one_step_pairs"][0].update(worst_condition=HOSTILE)
            facts["photos"]["worst"][0]["source"] = HOSTILE

        def hostile_setting(setting):
            setting["text"].update(subject=HOSTILE, setting=HOSTILE)
            setting["conditions"][0].update(words=HOSTILE)
        self.edit(folder, "report.json", hostile)
        self.edit(folder, "comparison.json", hostile_setting)
        self.assertGreaterEqual(drawn(folder).count("&lt;script&gt;"), 15)


if __name__ == "__main__":
    unittest.main()
