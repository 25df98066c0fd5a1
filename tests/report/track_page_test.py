"""The page of a file of tracks."""
import csv
import json
import math
import os
import random
import subprocess
import unittest

import numpy as np
from pages import HOSTILE, ROOT, SCRATCH, PageTest, check, draw, program, titles

from ballservo.report import tracks

COLUMNS = ("source,frame,time_s,track_id,class,state,quality,cx_px,cy_px,r_px,x_m,y_m,z_m,"
           "sxx_m2,sxy_m2,sxz_m2,syy_m2,syz_m2,szz_m2").split(",")
IN_3D = ["From above", "Distance", "Height"]
WAY, LAST = "The way through the picture", ["Quality", "When each was seen"]


def row(frame, track_id=1, place=(0.1, 0.2, 2.0), **changes):
    """A ball of 70 mm before a camera of 600 px."""
    found = dict(source="a.mp4", frame=frame, time_s=frame / 30, track_id=track_id, state="confirmed", quality=0.9)
    found["class"] = "red"
    if place:
        x, y, z = place
        found.update(x_m=x, y_m=y, z_m=z, cx_px=320 + 600 * x / z, cy_px=240 + 600 * y / z, r_px=21 / z, sxx_m2=1e-6, sxy_m2=0,
                     sxz_m2=1e-6, syy_m2=1e-6, syz_m2=0, szz_m2=1e-4)
    else:
        found.update(cx_px=320, cy_px=240, r_px=20)
    return {**found, **changes}


class TrackPage(PageTest):
    def written(self, rows, columns=COLUMNS, name="tracks.csv"):
        file = self.folder() / name
        with open(file, "w", newline="", encoding="utf-8") as text:
            table = csv.DictWriter(text, columns, extrasaction="ignore")
            table.writeheader()
            table.writerows(rows)
        return file

    def drawn(self, rows, **options):
        file = self.written(rows, **options)
        draw(file)
        html = file.with_suffix(".html").read_text(encoding="utf-8")
        check(html)
        return html

    def table(self, html):
        return [[cell.split(">")[1] for cell in line.split("</td>")[:-1]]
                for line in html.split("speed, median (m/s)")[1].split("</table>")[0].split("<tr>")[1:]]

    def test_of_a_run(self):
        program("servo", ROOT / "data/scenarios/moving_ball.yaml", "-o", SCRATCH / "run", "--perception", "geometric", "--set",
                "duration_s=3", code=1)
        file = SCRATCH / "run/tracks.csv"
        said = program("report", file, "--json", "pages.json")
        page = file.with_suffix(".html")
        self.assertEqual(said.stdout.strip(), str(page))
        self.assertEqual(json.loads((SCRATCH / "pages.json").read_text())["pages"], [str(page)])
        html = page.read_text()
        check(html)
        self.assertEqual(titles(html), [WAY, *IN_3D, *LAST])
        program("report", file)
        self.assertEqual(page.read_text(), html)

    def test_figures_follow_what_the_columns_hold(self):
        self.assertEqual(titles(self.drawn([row(k) for k in range(9)])), [WAY, *IN_3D, *LAST])
        self.assertEqual(titles(self.drawn([row(k, place=None) for k in range(9)])), [WAY, "Radius", *LAST])

    def test_lists_tracks_and_frames(self):
        rows = [row(k, state="tentative" if k < 3 else "confirmed", quality=k / 100) for k in range(2, 60, 2)]
        rows += [row(k, 7, (0, 0, 1 + k / 100), state="coasting" if k >= 80 else "confirmed") for k in range(60, 90)]
        html = self.drawn(rows)
        self.assertIn("49 of 90 frames up to the last row (54.4 %)", html)
        self.assertIn("48 confirmed, 1 tentative, 10 coasting", html)
        first, second = self.table(html)
        self.assertEqual(first, ["1", "red", "0.07", "1.93", "29", "0", "0.30", "10.5", "2.012", "0.00"])
        self.assertEqual(second, ["7", "red", "2.00", "2.97", "20", "10", "0.90", "12.4", "1.695", "0.30"])

    def test_the_speed_is_a_lines_and_not_the_noises(self):
        noise = random.Random(3)
        rows = [row(k, place=(k / 30, 0, 2 + noise.gauss(0, 0.01))) for k in range(300)]
        self.assertAlmostEqual(float(self.table(self.drawn(rows))[0][-1]), 1.0, delta=0.01)

    def test_videos_and_folders_are_told_apart(self):
        stills = [row(0, source=f"{k}.png", time_s=k / 30) for k in range(5)]
        videos = [row(k, source=name) for name in ("b.mp4", "c.mp4") for k in range(4)]
        again = [row(k, source="c.mp4") for k in range(2, 4)]
        html = self.drawn(stills + videos + again)
        for name, share in (("0.png to 4.png", "5 of 5 pictures that have a row"), ("b.mp4", "4 of 4 frames"),
                            ("c.mp4", "4 of 4 frames"), ("c.mp4", "2 of 4 frames")):
            self.assertRegex(html, f"<td>{name}</td><td>{share}")
        self.assertEqual(html.count("<h2>"), 4)

    def test_states_are_drawn_apart(self):
        dotted = [self.drawn([row(k, state="coasting" if k in gone else "confirmed") for k in range(20)]).count("dasharray")
                  for gone in ((), (7, 8))]
        self.assertEqual(dotted[0], 0)
        self.assertEqual(dotted[1], 5)

    def test_lines_and_bands_end_at_a_gap_in_time(self):
        for frames, gaps in ([*range(20)], 0), ([*range(9), *range(40, 50)], 1):
            sequence = tracks.Sequence(tracks.read_tracks(self.written([row(k) for k in frames])))
            plot = tracks.distance(sequence).plot
            self.assertEqual(np.isnan(plot.lines[0].get_ydata()).sum(), 1 + gaps)  # and one at its end
            self.assertEqual(len(plot.collections[0].get_paths()), 1 + gaps)

    def test_bands_and_ellipses_are_two_sigma_wide(self):
        sequence = tracks.Sequence(tracks.read_tracks(self.written([row(k, place=(0, 0, 2)) for k in range(9)])))
        band = tracks.distance(sequence).plot.collections[0].get_paths()[0].vertices[:, 1]
        self.assertAlmostEqual(band.max() - band.min(), 4 * 0.01)
        ellipse = tracks.from_above(sequence).plot.patches[0]
        large = 0.5 * (1.01e-4 + math.sqrt(0.99e-4 ** 2 + 4e-12))
        self.assertAlmostEqual(ellipse.height, 4 * math.sqrt(large))
        self.assertAlmostEqual(ellipse.angle % 180, 180 - math.degrees(0.5 * math.atan2(2e-6, 0.99e-4)), places=6)

    def test_escapes_every_text(self):
        html = self.drawn([row(0, **{"source": HOSTILE, "track_id": HOSTILE, "class": HOSTILE})], name="$<b>&.csv")
        self.assertGreaterEqual(html.count("&lt;"), 6)
        self.assertNotIn("<b>", html)

    def test_stands_what_nobody_would_call_a_track(self):
        random_cell = ("", "nan", "inf", "-inf", "1e99", "-1e308", "1e-300", "0", "-5")
        chance = random.Random(5)
        numbers = [name for name in COLUMNS if name not in ("source", "track_id", "class", "state")]
        for case in range(0, 15, 7):
            rows = [{**row(k, chance.randrange(1 + case)), "state": chance.choice(("tentative", "confirmed", "coasting")),
                     **{name: chance.choice(random_cell) for name in chance.sample(numbers, case + 1)}} for k in range(40)]
            self.drawn(rows)
        self.drawn([row(0)])
        self.drawn([dict.fromkeys(COLUMNS, "") | {"state": "coasting"}] * 2)
        page = tracks.page(self.written([row(k, k, source=f"{k % 2}.mp4") for k in range(300)]))
        self.assertEqual((len(page["described"]), page["undrawn"], page["unlisted"]), (6, 294, 200))

    def test_a_hundred_thousand_rows_are_drawn_soon_and_small(self):
        noise = random.Random(9)
        html = self.drawn([row(k, max(0, k - 50000) // 17, (noise.gauss(0, 1), noise.gauss(0, 1), 3 + noise.gauss(0, 1)),
                               state=("confirmed", "coasting")[k % 7 == 0]) for k in range(100000)])
        self.assertLess(len(html), 4e6)

    def test_says_what_is_wrong_with_a_file(self):
        for rows, columns, message in (
                ([], COLUMNS, "tracks.csv: no row to draw"), ([row(0)], COLUMNS[:-2], "tracks: no column syz_m2, szz_m2"),
                ([row(0, state="detected")], COLUMNS, "rows of detect, which have no track"), ([row(0, x_m="far")], COLUMNS, "x_m: "),):
            file = self.written(rows, columns)
            said = program("report", file, code=2).stderr
            self.assertIn(message, said)
            self.assertEqual(said.count("allowed: "), 1)
            self.assertFalse(file.with_suffix(".html").exists())
        file.write_bytes(bytes(range(256)) * 9)
        program("report", file, code=2)
        file.unlink()
        os.mkfifo(file)
        self.assertIn("no file", program("report", file, code=2).stderr)

    def test_figures_for_a_paper(self):
        file = self.written([row(k) for k in range(9)])
        program("report", file, "--figures")
        place = file.with_name("tracks_figures")
        script = place / "distance.py"
        before = script.with_suffix(".svg").read_bytes()
        script.with_suffix(".svg").unlink()
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "app/python"), "PYTHONDONTWRITEBYTECODE": "1"}
        subprocess.run(["/usr/bin/python3", "-s", script], check=True, cwd=SCRATCH, env=environment)
        self.assertEqual(script.with_suffix(".svg").read_bytes(), before)
        self.assertEqual(len(list(place.iterdir())), 3 * 6)
        self.assertIn("--force", program("report", file, "--figures", code=2).stderr)


if __name__ == "__main__":
    unittest.main()
