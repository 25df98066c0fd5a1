"""`import ballservo`: the command line's numbers to the last bit, and exceptions for whatever arrays come."""
import csv
import io
import itertools
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path

import cv2
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PROGRAM, PACKAGE = os.environ["BALLSERVO_PROGRAM"], os.environ["BALLSERVO_PYTHON"]
sys.dont_write_bytecode = True
sys.path.insert(0, PACKAGE)
import ballservo  # noqa: E402

COLORS, CAMERA = str(ROOT / "data/colors/red.colors"), str(ROOT / "data/cameras/wide.yaml")
SCENARIO = str(ROOT / "data/scenarios/static_ball.yaml")
METRIC = {"colors": COLORS, "camera": CAMERA, "diameter": "0.12+-0.0003"}


class PythonTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.place = Path(tempfile.mkdtemp(prefix="ballservo_python_"))
        cls.addClassCleanup(shutil.rmtree, cls.place)
        cls.program("render", SCENARIO, "-o", "pictures", "--frames", "6")
        # The camera's own uncertainty is a part of the covariance.
        shutil.copy(CAMERA, cls.place)
        METRIC["camera"] = str(cls.place / "wide.yaml")
        Path(METRIC["camera"] + ".covariance.json").write_text(json.dumps({
            "parameters": ["fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2", "k3"],
            "values": [480.0, 480.0, 319.5, 239.5, -0.12, 0.04, 0.0004, -0.0003, 0.0],
            "covariance": [[25.0 if i == j < 2 else 0.0 for j in range(9)] for i in range(9)]}))
        cls.pictures = [cv2.imread(str(cls.place / f"pictures/frame_{k:04}.png")) for k in range(6)]

    @classmethod
    def program(cls, *words):
        return subprocess.run([PROGRAM, *map(str, words)], cwd=cls.place, check=True, capture_output=True, text=True)

    def rows(self, command):
        words = itertools.chain.from_iterable((f"--{key}", value) for key, value in METRIC.items())
        return list(csv.DictReader(io.StringIO(self.program(command, "pictures", *words).stdout)))

    def same(self, rows, balls):
        self.assertEqual(len(rows), len(balls))
        self.assertGreaterEqual(len(rows), 6)
        for row, ball in zip(rows, balls):
            self.assertEqual((row["class"], row["state"], row["track_id"]),
                             (ball.color_class, ball.state, str(ball.track_id or "")))
            s = ball.covariance_m2
            self.assertEqual([float(row[key]) for key in "quality cx_px cy_px r_px x_m y_m z_m sxx_m2 sxy_m2 sxz_m2 "
                              "syy_m2 syz_m2 szz_m2".split()],
                             [ball.quality, *ball.outline_px, *ball.p_m, s[0, 0], s[0, 1], s[0, 2], s[1, 1], s[1, 2],
                              s[2, 2]])

    def test_detections_and_tracks_are_the_command_lines(self):
        detector, tracker = ballservo.Detector(**METRIC), ballservo.Tracker(**METRIC)
        self.same(self.rows("detect"), [ball for bgr in self.pictures for ball in detector.detect(bgr)])
        self.same(self.rows("track"), [ball for k, bgr in enumerate(self.pictures) for ball in tracker.update(bgr, k / 30)])

    def test_a_run_is_the_command_lines(self):
        self.program("servo", SCENARIO, "-o", "run", "--perception", "geometric", "--seed", 3, "--set", "law.name=visp")
        run = ballservo.simulate(ballservo.Scenario(SCENARIO, ["law.name=visp"], 3))
        self.assertEqual(run.log_csv, (self.place / "run/log.csv").read_text())
        self.assertEqual(run.tracks_csv, (self.place / "run/tracks.csv").read_text())
        summary = json.loads((self.place / "run/summary.json").read_text())
        self.assertEqual({**run.summary, "timing": 0}, {**summary, "timing": 0})

    def test_a_view_is_looked_at_where_it_lies(self):
        bgr = self.pictures[0]
        wide = np.full((480, 700, 3), 128, np.uint8)
        wide[:, :640] = bgr
        detector = ballservo.Detector(COLORS)
        outlines = [[ball.outline_px.tolist() for ball in detector.detect(picture)] for picture in (bgr, wide[:, :640])]
        self.assertEqual(*outlines)
        self.assertIsNone(detector.detect(bgr)[0].p_m)
        for view in bgr[::-1], bgr[:, ::-1], bgr[..., ::-1], bgr[:, ::2], bgr.transpose(1, 0, 2):
            with self.assertRaisesRegex(ballservo.InputError, "ascontiguousarray"):
                detector.detect(view)
            detector.detect(np.ascontiguousarray(view))

    def test_whatever_arrays_come_there_is_an_answer_or_an_exception(self):
        chance = random.Random(1)
        colors, camera = ballservo.Colors.load(COLORS), ballservo.Camera.load(CAMERA)
        detector, tracker = ballservo.Detector(COLORS), ballservo.Tracker(COLORS)
        detector.detect(self.pictures[0])
        answers = refusals = 0
        for _ in range(3000):
            shape = [chance.choice([0, 1, 2, 3, 4, 7, 40]) for _ in range(chance.choice([0, 1, 2, 3, 3, 3, 4]))]
            kind = chance.choice(["u1", "u1", "u1", "i1", "u2", "f8", "f4", "?", "O", "S3", "M8[s]"])
            array = np.zeros(shape, kind) if chance.random() < 0.8 else np.broadcast_to(np.zeros((), kind), shape)
            for axis in range(array.ndim):
                if chance.random() < 0.3:
                    array = array[(slice(None),) * axis + (slice(None, None, chance.choice([-1, 2, -2])),)]
            if kind[0] == "f" and chance.random() < 0.5:
                array = array + chance.choice([np.nan, np.inf, 1e308])
            for call in (colors.classify, detector.detect, camera.project, camera.unproject,
                         lambda a: tracker.update(a, chance.choice([np.nan, 1.0, -np.inf]))):
                try:
                    call(array)
                    answers += 1
                except (ValueError, TypeError, RuntimeError):
                    refusals += 1
        self.assertGreater(answers, 50)
        self.assertGreater(refusals, 3000)

    def test_cameras_and_colours(self):
        camera = ballservo.Camera.load(CAMERA)
        points = np.array([[0.1, -0.2, 1.0], [0, 0, -1], [np.nan, 0, 1]])
        pixels = camera.project(points)
        self.assertTrue(np.isnan(pixels[1:]).all())
        np.testing.assert_allclose(camera.unproject(pixels[:1])[0], points[0] / np.linalg.norm(points[0]), atol=1e-12)
        camera.save(str(self.place / "copy.yaml"))
        np.testing.assert_array_equal(ballservo.Camera.load(str(self.place / "copy.yaml")).project(points), pixels)
        with self.assertRaises(ballservo.InputError):
            camera.save(str(self.place / "copy.yaml"))
        colors = ballservo.Colors.learn({"red": [self.pictures[0]]})
        colors.save(str(self.place / "learnt.colors"))
        self.assertEqual(ballservo.Colors.load(str(self.place / "learnt.colors")).classes, ["red"])
        classes = colors.classify(self.pictures[0])
        self.assertEqual((classes.shape, classes.dtype, classes.max()), ((480, 640), np.uint8, 1))
        with self.assertRaises(RuntimeError):
            ballservo.Colors.learn({"red": [np.full((120, 160, 3), 128, np.uint8)]})
        with self.assertRaisesRegex(ballservo.InputError, "(?s)law.gain_per_s.*law.nam"):
            ballservo.Scenario(SCENARIO, ["law.gain_per_s=-1", "law.nam=x"])
        with self.assertRaises(ballservo.InputError):
            ballservo.Detector(COLORS, camera=CAMERA)

    def test_threads(self):
        shared, found = ballservo.Detector(**METRIC), []

        def look():
            own = ballservo.Detector(**METRIC)
            found.append([[ball.p_m.tolist() for ball in own.detect(bgr)] for bgr in self.pictures])
            for bgr in self.pictures:  # in whatever order threads come
                self.assertEqual(len(shared.detect(bgr)), 1)

        threads = [threading.Thread(target=look) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(found, [found[0]] * 4)

    def test_the_stubs_are_the_module(self):
        # What pybind11 has of its own: a metaclass, and constructors that refuse.
        (self.place / "pybind11").write_text("ballservo._ballservo.[A-Z][a-z]+\nballservo._ballservo.(Ball|Camera|Colors|Run).__init__\n")
        done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "ballservo._ballservo", "--ignore-positional-only",
                               "--allowlist", "pybind11", "--ignore-unused-allowlist"],
                              cwd=self.place, env={**os.environ, "MYPYPATH": PACKAGE, "PYTHONPATH": PACKAGE},
                              capture_output=True, text=True)
        if "No module named" in done.stderr:
            self.skipTest("no python3-mypy")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
