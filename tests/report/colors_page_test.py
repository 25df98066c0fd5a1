"""The page of calibrate colors --preview."""
import json
import unittest

import numpy as np
from PIL import Image
from pages import HOSTILE, SCRATCH, PageTest, drawn, page_of, program, titles

LEARNT, SHOWN = SCRATCH / "learnt", SCRATCH / "shown"
FIGURES = ["Strength of the light", "Colour of the light", "Fading towards grey", "What the table makes of each class&#39;s pixels"]
BALLS = {"red": (200, 30, 30), "blue": (30, 60, 200)}


def picture(path, *balls, size=(160, 120)):
    """Balls (colour, centre, radius) before grey."""
    v, u = np.mgrid[:size[1], :size[0]]
    image = np.full((*v.shape, 3), 128, np.uint8)
    for color, (x, y), radius in balls:
        image[np.hypot(u - x, v - y) <= radius] = color
    Image.fromarray(image).save(path)


def setUpModule():
    picture(SCRATCH / "red.png", (BALLS["red"], (60, 60), 22))
    picture(SCRATCH / "blue.png", (BALLS["blue"], (90, 50), 22), size=(1600, 1200))
    program("calibrate", "colors", "--class", "red=red.png", "--class", "blue=blue.png", "--at", "blue=90,50,22", "-o",
            "both.colors", "--preview", LEARNT, "--json", "both.json")
    program("calibrate", "colors", "--show", "both.colors", "--preview", SHOWN)


class ColorsPage(PageTest):
    def test_drawn_again_it_is_the_same_file(self):
        for kept in LEARNT, SHOWN:
            folder = self.copy(kept)
            before = (folder / "report.html").read_bytes()
            program("report", folder)
            self.assertEqual((folder / "report.html").read_bytes(), before)

    def test_holds_every_figure_and_picture(self):
        for folder, png, jpeg in (LEARNT, 3, 6), (SHOWN, 3, 0):
            html = drawn(self.copy(folder))
            self.assertEqual(titles(html), FIGURES)
            self.assertEqual((html.count("data:image/png"), html.count("data:image/jpeg")), (png, jpeg))
        self.assertEqual(len(list(LEARNT.glob("*.png"))), 2 * 7)
        self.assertLess(len(html), 2e6)

    def test_tells_the_figures_of_the_json(self):
        html = page_of(LEARNT)
        for name, color in json.loads((SCRATCH / "both.json").read_text())["classes"].items():
            row = html.split(f"<tr><td>{name}</td>")[1].split("</tr>")[0]
            light = color["light"]
            for text in (len(color["circles"]), color["samples"], color["table_cells"],
                         f"{100 * color['kept_fraction']:.1f} %", f"{100 * color['background_fraction']:.2f} %",
                         f"{color['chroma']:.0f}", f"{color['dissolves_at_chroma']:.0f}",
                         f"{light['level_low']:.2g} to {light['level_high']:.2g}",
                         f"{100 * round(light['warmest_k'] / 100)} to {100 * round(light['coolest_k'] / 100)}"):
                self.assertIn(f">{text}</td>", row)
        self.assertIn("learnt from red.png, blue.png", html)
        self.assertIn("as the file holds them", page_of(SHOWN))

    def change(self, **changes):
        folder = self.copy(LEARNT)
        self.edit(folder, "report.json", lambda facts: facts.update(changes))
        return folder

    def facts(self):
        return json.loads((LEARNT / "report.json").read_text())

    def test_says_what_is_shared_and_where_pixels_go(self):
        classes = self.facts()["classes"]
        classes["red"].update(kept_fraction=0.61, overlap={"blue": 0.28}, shared={"blue": 0.456})
        html = drawn(self.change(classes=classes, warnings=["red and blue share much"]))
        self.assertIn(">blue 45.6 %</td>", html)
        self.assertIn("<li>red and blue share much</li>", html)
        for share in (61, 28, 11):
            self.assertIn(f">{share}</text>", html)

    def test_escapes_every_text(self):
        facts = self.facts()
        classes = {HOSTILE: {**facts["classes"]["red"], "shared": {HOSTILE: 1}}}
        classes[HOSTILE]["circles"][0]["source"] = HOSTILE
        pictures = [[{**panel, "caption": HOSTILE} for panel in panels] for panels in facts["pictures"]]
        html = drawn(self.change(classes=classes, pictures=pictures, file=HOSTILE, sources=[HOSTILE], warnings=[HOSTILE],
                                 camera_settings={HOSTILE: HOSTILE}))
        self.assertGreaterEqual(html.count("&lt;script&gt;"), 12)

    def test_stands_any_number_of_classes_and_values_that_are_not_known(self):
        red = self.facts()["classes"]["red"]
        for count in (0, 1, 15):
            drawn(self.change(classes={f"a_class_with_a_long_name_{k}": red for k in range(count)}))
        unknown = {**red, **dict.fromkeys(("kept_fraction", "background_fraction", "chroma", "dissolves_at_chroma")),
                   "rgb": [None, None, None], "light": {**red["light"], "level_high": None}}
        drawn(self.change(classes={"red": unknown, "blue": {**red, "rgb": [0, 0, 0]}}, pictures=[]))

    def test_takes_pictures_from_its_own_folder_only(self):
        pictures = self.facts()["pictures"]
        pictures[0][0]["file"] = "../../../../../../../etc/passwd"
        with self.assertRaises(FileNotFoundError):
            drawn(self.change(pictures=pictures))

    def test_a_broken_picture_is_named(self):
        folder = self.copy(LEARNT)
        (folder / "red_a_source.png").write_bytes(b"no picture")
        self.assertIn("red_a_source.png", program("report", folder, code=2).stderr)


if __name__ == "__main__":
    unittest.main()
