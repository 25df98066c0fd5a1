"""The page of app/demo.sh."""
import json
import re
import unittest

from pages import HOSTILE, PIXEL, PageTest, drawn


class DemoPage(PageTest):
    def results(self, name="red", settled_s=6.04):
        folder = self.folder()
        for below in ("boards", "colors", "found", "stages", "servo", "compare"):
            (folder / below).mkdir()
        for picture in ("boards/board_01.png", "colors/smarties_figure.png", "found/smarties.png",
                        "stages/smarties_stages.png"):
            (folder / picture).write_bytes(PIXEL)
        (folder / "report.json").write_text('{"page": "demo"}')
        (folder / "left.json").write_text(json.dumps({
            "used": 12, "images": 13, "rms_px": 0.1234, "held_out_rms_px": None, "fx_px": 535.91,
            "ball_sigma_covered_mm": 1.25, "ball_sigma_mm": 9.0}))
        (folder / "servo/summary.json").write_text(json.dumps({
            "outcome": "reached", "settled_s": settled_s, "range_error_m": 0.00123, "bearing_error_rad": -1e-9}))
        (folder / "detections.csv").write_text(
            "source,class,quality,cx_px,cy_px,r_px\n" + 2 * f'a,"{name}",0.98765,10.23456,20,5e-7\n')
        (folder / "compare/pairs.csv").write_text(
            "condition,method_a,method_b,frames,center_median_px,radius_median_px,position_median_mm\n"
            "base,a,b,20,0.00012345,,0.5\n")
        return folder

    def test_tells_what_the_files_hold(self):
        html = drawn(self.results())
        for text in ("12 of\n13 photographs", "0.123 px", "within unknown px", "535.9 px", "<b>2 red</b>", "<b>reached</b>",
                     "6.0 s", "1.2 mm off", "0.00 degrees", ">0.9877<", ">10.23<", ">5e-07<", ">0.0001234<"):
            self.assertIn(text, html)
        self.assertIn("<b>unknown s</b>", drawn(self.results(settled_s=None)))

    def test_holds_its_pictures_and_links_to_what_lies_beside_it_only(self):
        html = drawn(self.results())
        self.assertEqual(html.count('src="data:image/'), 4)
        for link in re.findall(r'(?:href|src)="([^"]*)"', html):
            self.assertRegex(link, r"^(data:image/|[a-z]+(/[a-z]+)?\.[a-z0-9]+$)")

    def test_escapes_every_text(self):
        html = drawn(self.results(name=HOSTILE.replace('"', '""')))
        self.assertGreaterEqual(html.count("&lt;script&gt;"), 3)


if __name__ == "__main__":
    unittest.main()
