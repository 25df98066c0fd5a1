"""The pages of calibrate camera --report and calibrate diff --report."""
import json
import math
import unittest
from pathlib import Path

from pages import EXAMPLES, HOSTILE, PIXEL, ROOT, SCRATCH, PageTest, drawn, page_of, program, titles

CORNERS = [[60.0 * x, 50.0 * y] for x in range(1, 10) for y in range(1, 7)]
CAMERA = """image_width: 640
image_height: 480
camera_name: c
camera_matrix: {{rows: 3, cols: 3, data: [{f}, 0, 319.5, 0, {f}, 239.5, 0, 0, 1]}}
distortion_model: plumb_bob
distortion_coefficients: {{rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}}
"""
DIFFERENCE = SCRATCH / "difference"


def setUpModule():
    for name, focal_px in (("a", 600.5), ("b", 606.505)):
        (SCRATCH / f"{name}.yaml").write_text(CAMERA.format(f=focal_px))
    program("calibrate", "diff", "a.yaml", "b.yaml", "--report", DIFFERENCE)


def board(name, **changes):
    residuals = [[0.1 * math.sin(x), 0.1 * math.cos(y)] for x, y in CORNERS]
    return {"name": name, "file": "board_01_page.jpg", "rms_px": 0.25, "corners_px": CORNERS, "residuals_px": residuals,
            "set_aside": [1] + [0] * (len(CORNERS) - 1), **changes}


def calibration(**changes):
    return {"page": "camera", "looked_at": 9, "picture_px": [640, 480], "principal_point_px": [319.5, 239.5],
            "model": "brown", "rms_px": 0.123, "held_out_rms_px": None, "noise_px": 0.1, "structure_px": None,
            "coverage": 0.71, "focal_distance_correlation": 0.95, "ball_sigma_mm": 4.321, "covered_ball_sigma_mm": None,
            "parameters": [{"name": "fx_px", "value": 535.912, "sigma": 0.45}],
            "trials": [{"model": name, "rms_px": 0.2, "held_out_rms_px": None, "remark": ""} for name in ("a", "b")],
            "warnings": ["mind it"], "advice": ["take more"], "overlay_enlarged": 50, "boards": [board("1.png"), board("2.png")],
            "ball_maps": [{"range_m": 1.0, "columns": 3, "sigma_mm": [1, 2, None, 3, 4, 50]}],
            "remarks": ["2.png: dim"], "rejected": [["3.png", "no board"]], **changes}


class CameraPage(PageTest):
    def drawn(self, **changes):
        folder = self.folder()
        (folder / "board_01_page.jpg").write_bytes(PIXEL)
        (folder / "report.json").write_text(json.dumps(calibration(**changes)))
        return drawn(folder)

    def test_holds_every_figure_and_picture(self):
        html = self.drawn()
        self.assertEqual(titles(html), ["All corners, residuals 200 times enlarged",
                                        "Residuals by distance from the principal point",
                                        "A ball at 1 m: at worst 50.00 mm"])
        self.assertEqual(html.count("data:image/jpeg"), 2)

    def test_tells_figures_advice_and_rejections(self):
        html = self.drawn()
        for text in ("2 of 9 pictures of 640 x 480 pixels", "placed to 4.32 mm", "0.123 px", "unknown",
                     "too few boards to tell", "71 %", "0.950", "4.32 mm (1 sigma)", "535.912", "0.45", "lens model brown",
                     "Models tried", "mind it", "take more", "1.png: RMS 0.250 px", "2.png: dim", "no board"):
            self.assertIn(text, html)
        self.assertNotIn("Models tried", self.drawn(trials=[]))
        self.assertNotIn("<h2>Warnings", self.drawn(warnings=[]))

    def test_escapes_every_text(self):
        html = self.drawn(boards=[board(HOSTILE)], rejected=[[HOSTILE, HOSTILE]], remarks=[HOSTILE], advice=[HOSTILE],
                          warnings=[HOSTILE], model=HOSTILE, trials=2 * calibration(remark=HOSTILE)["trials"])
        self.assertGreaterEqual(html.count("&lt;script&gt;"), 8)

    def test_stands_perfect_boards_and_such_without_corners(self):
        self.drawn(boards=[board("1", residuals_px=[[0, 0]] * len(CORNERS))])
        self.drawn(boards=[board("1", set_aside=[1] * len(CORNERS))], ball_maps=[])
        self.drawn(boards=[], ball_sigma_mm=None)
        self.drawn(boards=[board("1", corners_px=[[319.5, 239.5]], residuals_px=[[1e300, None]], set_aside=[0])])

    def test_of_real_photographs(self):
        pictures = next(filter(None, (sorted((place / EXAMPLES).glob("left0*.jpg")) for place in
                                      (Path("/"), ROOT / "build/opencv-doc"))), None)
        if not pictures:
            self.skipTest("opencv-doc's pictures are not here")
        program("calibrate", "camera", *pictures, "--board", "chessboard:9x6", "--square", 0.025, "--model", "brown", "-o",
                "left.yaml", "--json", "left.json", "--report", "boards")
        html, results = drawn(SCRATCH / "boards"), json.loads((SCRATCH / "left.json").read_text())
        self.assertEqual(html.count("data:image/jpeg"), results["used"])
        self.assertIn(f"{results['rms_px']:.3f} px", html)
        self.assertIn(results["advice"][0], html)


class DifferencePage(PageTest):
    def test_drawn_again_it_is_the_same_file(self):
        folder = self.copy(DIFFERENCE)
        before = (folder / "report.html").read_bytes()
        program("report", folder)
        self.assertEqual((folder / "report.html").read_bytes(), before)

    def test_tells_the_figures(self):
        html, facts = page_of(DIFFERENCE), json.loads((DIFFERENCE / "report.json").read_text())
        for text in (f"{facts['ball_difference_median_mm']:.3g} mm apart", facts["verdict"],
                     f"median {facts['difference_median_px']:.4f} px", "640 x 480 px"):
            self.assertIn(text, html)
        self.assertEqual(titles(html), ["Difference at the ball, and displacement in the picture"])
        self.assertEqual(html.split("differ most at the ball")[1].split("</table>")[0].count("<tr>"), 1 + 8)

    def test_maps_the_uncertainty_where_it_is_known(self):
        folder = self.copy(DIFFERENCE)
        self.edit(folder, "report.json", lambda facts: facts.update(
            ball_sigma_rms_mm=1.0, places=[{**place, "ball_sigma_mm": 1.0} for place in facts["places"]]))
        self.assertEqual(len(titles(drawn(folder))), 2)

    def test_escapes_every_text(self):
        folder = self.copy(DIFFERENCE)
        self.edit(folder, "report.json", lambda facts: facts.update(a=HOSTILE, b=HOSTILE, verdict=HOSTILE))
        self.assertGreaterEqual(drawn(folder).count("&lt;script&gt;"), 3)

    def test_stands_cameras_that_agree_and_places_that_are_not_known(self):
        for value in (0, None):
            folder = self.copy(DIFFERENCE)
            self.edit(folder, "report.json", lambda facts: facts.update(
                difference_median_px=0, ball_difference_median_mm=0, ball_difference_max_mm=0,
                places=[{**place, **dict.fromkeys(("dx_px", "dy_px", "ball_dx_mm", "ball_dy_mm", "ball_dz_mm"), value)}
                        for place in facts["places"]]))
            drawn(folder)


if __name__ == "__main__":
    unittest.main()
