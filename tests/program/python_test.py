"""`import ballservo`: the command line's numbers to the last bit, and exceptions for whatever arrays come."""
import csv
import io
import itertools
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings
from pathlib import Path

import cv2
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PROGRAM, PACKAGE = os.environ["BALLSERVO_PROGRAM"], os.environ["BALLSERVO_PYTHON"]
sys.dont_write_bytecode = True
sys.path.insert(0, PACKAGE)
import ballservo  # noqa: E402
import ballservo.tables  # noqa: E402

COLORS, CAMERA = str(ROOT / "data/colors/red.colors"), str(ROOT / "data/cameras/wide.yaml")
SCENARIO = str(ROOT / "data/scenarios/static_ball.yaml")
METRIC = {"colors": COLORS, "camera": CAMERA, "diameter": "0.12+-0.0003"}


class Unhurried:
    """Does at once what it is told, but no faster than at 0.2 m/s."""

    def __init__(self, pose):
        self.x, self.y, self.yaw = pose
        self.time_s, self.v, self.w = 0.0, 0.0, 0.0

    def command(self, v, w):
        self.v, self.w = np.clip(v, -0.2, 0.2), w

    def advance(self, time_s):
        dt, self.time_s = time_s - self.time_s, time_s
        self.x += self.v * np.cos(self.yaw) * dt
        self.y += self.v * np.sin(self.yaw) * dt
        self.yaw += self.w * dt
        return self.x, self.y, self.yaw, self.v, self.w


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

    def test_a_path_begins_where_it_is_written(self):
        (self.place / "elsewhere").mkdir()
        copy = shutil.copy(SCENARIO, self.place / "elsewhere")
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.place)
        with self.assertRaisesRegex(ballservo.InputError, "camera.file.*begins in the folder that you are in.*scenario's folder"):
            ballservo.Scenario(copy)
        set_here = ["camera.file=wide.yaml"]
        self.assertEqual(ballservo.Scenario(copy, set_here).camera.model, "brown")
        with self.assertRaises(ballservo.InputError):
            ballservo.Scenario(copy, ["camera.file=../wide.yaml"])

    def test_a_run_is_the_command_lines(self):
        self.program("servo", SCENARIO, "-o", "run", "--perception", "geometric", "--seed", 3, "--set", "law.name=visp")
        run = ballservo.simulate(ballservo.Scenario(SCENARIO, ["law.name=visp"], 3))
        self.assertEqual(run.log_csv, (self.place / "run/log.csv").read_text())
        self.assertEqual(run.tracks_csv, (self.place / "run/tracks.csv").read_text())
        summary = json.loads((self.place / "run/summary.json").read_text())
        self.assertEqual({**run.summary, "timing": 0}, {**summary, "timing": 0})

    def same_run(self, one, other):
        self.assertEqual(one.log_csv, other.log_csv)
        self.assertEqual(one.tracks_csv, other.tracks_csv)
        self.assertEqual({**one.summary, "timing": 0}, {**other.summary, "timing": 0})

    def test_a_run_step_by_step_is_the_whole_run(self):
        moving = ballservo.Scenario(str(ROOT / "data/scenarios/moving_ball.yaml"), seed=4)
        looking = ballservo.Scenario(SCENARIO, ["duration_s=1.5"], 2)
        stepped = [(ballservo.Run(moving), []), (ballservo.Run(looking, "image"), [])]
        while not all(run.over for run, _ in stepped):  # beside each other
            for run, steps in stepped:
                if (step := run.step()) is not None:
                    steps.append(step)
        for (run, steps), whole in zip(stepped, (ballservo.simulate(moving), ballservo.simulate(looking, "image"))):
            self.same_run(run, whole)
            self.assertIsNone(run.step())
            self.assertEqual(list(run), [])
            log, tracks = run.log, run.tracks
            self.assertEqual(len(steps), len(log["step"]))
            for row, step in enumerate(steps):
                self.assertEqual([step.time_s, *step.pose, *step.command, step.state, step.bearing_rad],
                                 [log[name][row] for name in "time_s x_m y_m yaw_rad v_command_mps w_command_radps state "
                                  "bearing_rad".split()])
            frames = {step.frame.frame: step.frame for step in steps if step.frame}
            self.assertEqual(list(frames), list(range(len(frames))))
            self.assertIsNone(steps[0].frame)
            for row, number in enumerate(tracks["frame"]):
                if number in frames:  # else it was still on its way at the end
                    frame = frames[number]
                    self.assertEqual([frame.time_s, frame.state, *frame.p_m, frame.covariance_m2[0, 2]],
                                     [tracks[name][row] for name in "time_s state x_m y_m z_m sxz_m2".split()])
                    error_m = frame.p_m - frame.true_p_m
                    self.assertLess(error_m @ np.linalg.solve(frame.covariance_m2, error_m), 25)
                    self.assertLess(abs(frame.outline_px - frame.true_outline_px).max(), 3)
                    self.assertGreater(frame.visible_fraction, 0.9)
            for step in steps:
                if step.frame:
                    self.assertLessEqual(step.frame.arrived_s, step.time_s)
                    later = frames.get(step.frame.frame + 1)
                    self.assertTrue(later is None or later.arrived_s > step.time_s)

    def test_a_frame_without_a_ball_says_so(self):
        away = ballservo.Scenario(SCENARIO, ["robot.pose.yaw_rad=3.1", "vary={}", "duration_s=0.3"])
        frame = list(ballservo.Run(away))[-1].frame
        self.assertEqual((frame.state, frame.p_m, frame.covariance_m2, frame.outline_px, frame.true_outline_px,
                          frame.visible_fraction), ("none", None, None, None, None, 0))

    def test_a_run_is_left_or_fails(self):
        scenario = ballservo.Scenario(SCENARIO)
        whole = ballservo.simulate(scenario).log_csv.splitlines()
        run = ballservo.Run(scenario)
        for step in run:
            if step.time_s > 1:
                break
        for result in "summary", "log_csv", "tracks_csv", "log", "tracks":
            with self.assertRaisesRegex(RuntimeError, "the run goes on"):
                getattr(run, result)
        run.stop()
        run.stop()
        self.assertEqual((run.over, run.step(), run.summary["outcome"]), (True, None, "interrupted"))
        self.assertEqual(run.log_csv.splitlines(), whole[:len(run.log["step"]) + 1])
        self.assertEqual(run.log["time_s"][-1], step.time_s)

        class Noted(Unhurried):
            def command(self, v, w):
                super().command(v, w)
                told.append((v, w))

        told = []
        run = ballservo.Run(scenario, robot=Noted(scenario.pose))
        for _ in range(100):
            run.step()
        self.assertNotEqual(told[-1], (0, 0))
        del run
        self.assertEqual(told[-1], (0, 0))

        def law(p_CB, v_CB):
            return 1 / (2 - run.step().time_s), 0

        run = ballservo.Run(scenario, law=law)
        with self.assertRaisesRegex(RuntimeError, "in a step already"):
            list(run)
        self.assertEqual((run.over, run.step(), run.summary["outcome"]), (True, None, "interrupted"))
        self.assertGreater(len(run.log["step"]), 0)
        with self.assertRaisesRegex(ballservo.InputError, "perception"):
            ballservo.Run(scenario, "x")

    def test_threads_share_a_run(self):
        scenario = ballservo.Scenario(SCENARIO)
        run, steps, refused = ballservo.Run(scenario), [], []

        def drive():
            while not run.over:
                try:
                    steps.extend(step.time_s for step in [run.step()] if step)
                except RuntimeError:
                    refused.append(1)

        threads = [threading.Thread(target=drive) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.same_run(run, ballservo.simulate(scenario))
        self.assertEqual(sorted(steps), run.log["time_s"].tolist())

    def test_a_law_of_ones_own_drives_to_the_ball(self):
        scenario = ballservo.Scenario(SCENARIO, seed=2)
        steps = []

        def law(p_CB, v_CB):
            p_RB = scenario.X_RC[:3, :3] @ p_CB + scenario.X_RC[:3, 3]
            return 1.5 * (np.hypot(*p_RB[:2]) - scenario.goal_p_RB[0]), 3 * np.arctan2(p_RB[1], p_RB[0])

        run = ballservo.simulate(scenario, law=law, on_step=steps.append)
        self.assertEqual(run.summary["outcome"], "reached")
        self.assertLess(abs(run.log["range_m"][-50:] - 0.8).max(), 0.01)
        self.assertEqual([step.time_s for step in steps], run.log["time_s"].tolist())
        self.assertEqual([step.pose[0] for step in steps], run.log["x_m"].tolist())
        self.assertNotEqual(run.log_csv, ballservo.simulate(scenario).log_csv)
        self.assertEqual(ballservo.simulate(scenario, law=lambda p, v: None).summary["outcome"], "timeout")

    def test_a_look_is_the_first_rendered_picture(self):
        scenario = ballservo.Scenario(SCENARIO)
        np.testing.assert_array_equal(scenario.look(), self.pictures[0])
        self.assertGreater(abs(scenario.look((0, 0, 0.3)).astype(int) - self.pictures[0]).mean(), 3)

    def test_a_robot_of_ones_own_is_driven(self):
        scenario = ballservo.Scenario(SCENARIO, ["duration_s=60"])
        robot, steps = Unhurried(scenario.pose), []
        run = ballservo.simulate(scenario, robot=robot, on_step=steps.append)
        self.assertEqual(run.summary["outcome"], "reached")
        self.assertGreater(run.summary["settled_s"], (steps[0].range_error_m - 0.1) / 0.2)
        self.assertEqual((run.log["x_m"][-1], run.log["y_m"][-1]), (robot.x, robot.y))

    def test_a_camera_of_ones_own_is_looked_through(self):
        scenario = ballservo.Scenario(SCENARIO, ["duration_s=4"])
        times = []

        def camera(X_WC, time_s):
            times.append(time_s)
            bgr = np.full((480, 640, 3), 110, np.uint8)
            p_CB = np.linalg.inv(X_WC) @ [*scenario.p_WB(time_s), 1]
            (x, y), = scenario.camera.project(p_CB[None, :3])
            radius = 480 * 0.06 / p_CB[2]
            cv2.circle(bgr, (round(x * 16), round(y * 16)), round(radius * 16), (40, 30, 190), -1, cv2.LINE_AA, 4)
            return bgr

        run = ballservo.simulate(scenario, "image", camera=camera)
        self.assertAlmostEqual(np.diff(times).mean(), 1 / 30, 6)
        self.assertIn("confirmed", run.tracks["state"])
        self.assertLess(run.log["range_m"][-1], run.log["range_m"][0] - 0.5)
        with self.assertRaisesRegex(ballservo.InputError, "camera: found a picture of 640 x 479 px; allowed: .*640 x 480"):
            ballservo.simulate(scenario, "image", camera=lambda *_: np.zeros((479, 640, 3), np.uint8))
        for wrong in np.zeros((480, 640), np.uint8), None:
            with self.assertRaises(ballservo.InputError):
                ballservo.simulate(scenario, "image", camera=lambda X_WC, time_s, wrong=wrong: wrong)
        with self.assertRaisesRegex(ballservo.InputError, "perception"):
            ballservo.simulate(scenario, camera=camera)

    def test_what_callbacks_raise_comes_out(self):
        scenario = ballservo.Scenario(SCENARIO)

        class Own(Exception):
            pass

        class Broken(Unhurried):
            def __init__(self, after):
                super().__init__(scenario.pose)
                self.after = after

            def command(self, v, w):
                if self.time_s >= self.after:
                    raise Own("command")

            def advance(self, time_s):
                return [super().advance(time_s), "x", (1, 2), [np.nan] * 5][self.after]

        def fails(*_):
            raise Own("failed")

        for port in {"law": fails}, {"robot": Broken(0)}, {"on_step": fails}:
            with self.assertRaises(Own):
                ballservo.simulate(scenario, **port)
        with self.assertRaises(Own):
            ballservo.simulate(scenario, "image", camera=fails)
        for after in 1, 2, 3:
            with self.assertRaisesRegex(ballservo.InputError, "robot.advance"):
                ballservo.simulate(scenario, robot=Broken(after))
        for said in 3, "ab", (1, 2, 3), ("a", 1), object(), (np.nan, 0), (0, np.inf):
            with self.assertRaisesRegex(ballservo.InputError, "law"):
                ballservo.simulate(scenario, law=lambda p, v, said=said: said)
        with self.assertRaises(AttributeError):
            ballservo.simulate(scenario, robot=object())

    def test_ctrl_c_is_heard(self):
        obstacles = str(ROOT / "data/scenarios/obstacles.yaml")
        for work in (f"simulate(ballservo.Scenario({SCENARIO!r}, ['law.gain_per_s=0.01', 'duration_s=3600']))",
                     f"sweep({obstacles!r}, 100000)", f"compare({str(ROOT / 'data/comparisons/full.yaml')!r})"):
            child = subprocess.Popen([sys.executable, "-c", "import ballservo; print(flush=True); ballservo." + work],
                                     env={**os.environ, "PYTHONPATH": PACKAGE}, stdout=subprocess.PIPE,
                                     stderr=subprocess.PIPE, text=True)
            child.stdout.readline()
            time.sleep(0.3)
            self.assertIsNone(child.poll(), work)
            child.send_signal(signal.SIGINT)
            self.assertIn("KeyboardInterrupt", child.communicate(timeout=60)[1], work)

    def test_a_sweep_is_the_command_lines(self):
        self.program("sweep", SCENARIO, "-o", "grid", "--trials", 3, "--vary", "law.gain_per_s=0.5,2", "--vary",
                     "law.name=cone,visp", "--seed", 5, "--set", "duration_s=20")
        sweep = ballservo.sweep(SCENARIO, 3, {"law.gain_per_s": [0.5, np.int64(2)], "law.name": ["cone", "visp"]},
                                ["duration_s=20"], seed=5)
        for table, columns in ("trials", sweep.trials), ("grid", sweep.grid):
            rows = list(csv.DictReader((self.place / f"grid/{table}.csv").read_text().splitlines()))
            self.assertEqual(list(rows[0]), list(columns))
            for name, column in columns.items():
                for row, value in zip(rows, column, strict=True):
                    self.assertTrue(row[name] == str(value) or row[name] == "" and np.isnan(value)
                                    or float(row[name]) == value, (name, row[name], value))
        self.assertEqual(sweep.summary, json.loads((self.place / "grid/summary.json").read_text()))
        alone = ballservo.sweep(SCENARIO, 2)
        self.assertEqual((alone.summary["reached"], alone.grid), (2, None))
        with self.assertRaisesRegex(ballservo.InputError, "(?s)gain.*-1"):
            ballservo.sweep(SCENARIO, 2, {"law.gain_per_s": [1, -1]})

    def test_a_comparison_is_the_command_lines(self):
        plan = self.place / "plan.yaml"
        plan.write_text("""seed: 1
frames: 4
methods: [vote, paper_one_step, sphere_converged]
defaults: {camera: {focal_px: 857, width_px: 640, height_px: 480}, ball: {color: red, diameter_m: 0.07}, depth_m: 1.0}
conditions: [{name: base}, {name: noisy, noise: {read: 10}}]
""")
        self.program("compare", plan, "-o", "comparison", "--seed", 3)
        tables = ballservo.compare(plan, seed=3)
        self.assertLessEqual({"compare", "fits", "frames", "pairs", "tests"}, set(tables))
        for name in "compare", "fits", "frames":
            text = (self.place / f"comparison/{name}.csv").read_text()
            for column, values in ballservo.tables.columns(text).items():
                np.testing.assert_array_equal(tables[name][column], values, column)

    def test_a_comparison_on_ones_own_pictures_is_the_command_lines(self):
        words = {"images": self.place / "pictures", "truth": self.place / "pictures/truth.csv", "colors": COLORS,
                 "camera": CAMERA, "diameter": 0.12, "start": "vote"}
        self.program("compare", "-o", "own_pictures", *itertools.chain.from_iterable((f"--{k}", v) for k, v in words.items()))
        tables = ballservo.compare(**words)
        for name in "compare", "fits", "frames":
            text = (self.place / f"own_pictures/{name}.csv").read_text()
            for column, values in ballservo.tables.columns(text).items():
                np.testing.assert_array_equal(tables[name][column], values, column)
        for wrong in ({}, {"plan": "x.yaml", "images": "y"}, {"images": "y"}, {**words, "start": "here"},
                      {**words, "diameter": np.nan}):
            with self.assertRaises(ballservo.InputError):
                ballservo.compare(**wrong)

    @staticmethod
    def boards():
        square_px = 40
        board = np.full((9 * square_px, 12 * square_px), 255, np.uint8)
        for x, y in itertools.product(range(10), range(7)):
            if (x + y) % 2:
                board[(y + 1) * square_px:(y + 2) * square_px, (x + 1) * square_px:(x + 2) * square_px] = 0
        for k in range(8):  # through a pinhole of 500 px
            R = cv2.Rodrigues(np.array([0.5 * np.sin(k), 0.5 * np.cos(2.1 * k), 0.1 * k]))[0]
            t = np.array([0.05 * np.sin(3 * k), 0.04 * np.cos(k), 0.5 + 0.03 * k]) - R @ [0.15, 0.1125, 0]
            K = np.array([[500, 0, 320], [0, 500, 240], [0, 0, 1]])
            H = K @ np.column_stack([R[:, 0] * 0.025 / square_px, R[:, 1] * 0.025 / square_px, t])
            yield cv2.warpPerspective(board, H, (640, 480), borderValue=128, flags=cv2.INTER_AREA)

    def board_files(self, pictures):
        for k, picture in enumerate(pictures):
            cv2.imwrite(str(self.place / f"board_{k}.png"), picture)
        return [self.place / f"board_{k}.png" for k in range(len(pictures))]

    def test_a_camera_calibration_is_the_command_lines(self):
        boards = self.board_files(list(self.boards()))
        self.program("calibrate", "camera", *boards, "--board", "chessboard:9x6", "--square", "0.025", "-o", "left.yaml",
                     "--json", "left.json")
        done = ballservo.calibrate_camera(boards, "chessboard:9x6", 0.025)
        self.assertAlmostEqual(done.camera.parameters["fx_px"], 500, delta=2)
        (self.place / "own").mkdir()
        done.camera.save(self.place / "own/left.yaml")
        for name in "left.yaml", "left.yaml.covariance.json":
            self.assertEqual((self.place / "own" / name).read_bytes(), (self.place / name).read_bytes())
        self.assertEqual(json.dumps(done.summary, sort_keys=True),
                         json.dumps(json.loads((self.place / "left.json").read_text()), sort_keys=True))
        np.testing.assert_array_equal(ballservo.Camera.load(self.place / "left.yaml").covariance, done.camera.covariance)
        with self.assertRaisesRegex(ballservo.InputError, "nowhere"):
            ballservo.calibrate_camera([self.place / "nowhere.png"], "chessboard:9x6", 0.025)

    def test_pictures_of_a_board_are_as_good_as_their_files(self):
        gray = list(self.boards())
        color = [np.dstack([picture // 2, picture, picture]) for picture in gray]
        wide = np.zeros((480, 700, 3), np.uint8)
        wide[:, :640] = color[0]
        color = [wide[:, :640], *color[1:], np.zeros((480, 640, 3), np.uint8)]
        for pictures in gray, color:
            before = [picture.copy() for picture in pictures]
            of_arrays = ballservo.calibrate_camera(pictures, "chessboard:9x6", 0.025)
            np.testing.assert_array_equal(pictures, before)
            of_files = ballservo.calibrate_camera(self.board_files(pictures), "chessboard:9x6", 0.025)
            self.assertEqual(of_arrays.camera.parameters, of_files.camera.parameters)
            np.testing.assert_array_equal(of_arrays.camera.covariance, of_files.camera.covariance)
            said = json.dumps(of_files.summary)
            for k in range(len(pictures)):
                for name in str(self.place / f"board_{k}.png"), f"board_{k}.png":
                    said = said.replace(name, f"picture {k + 1}")
            self.assertEqual(json.dumps(of_arrays.summary), said)
        self.assertEqual(of_arrays.summary["rejected"][0]["file"], "picture 9")
        file = self.place / "board_0.png"
        for sources, said in (
                ([gray[0], gray[1] / 255, gray[2][None, None]],
                 r"(?s)picture 2: found an array of float64 \(480, 640\); allowed: uint8 .*\(height, width\)"
                 r".*picture 3: found .* \(1, 1, 480, 640\)"),
                ([color[0][..., :2]], r"picture 1: found .*\(480, 640, 2\)"), ([gray[0][:0]], r"picture 1: found .*\(0, 640\)"),
                ([gray[0].astype(np.uint16)], "picture 1: found .*uint16"), ([np.zeros((), np.uint8)], r"picture 1: found .*\(\)"),
                ([gray[0], gray[1][:, ::-1]], "picture 2: found strides.*ascontiguousarray"), ([gray[0].T], "ascontiguousarray"),
                ([gray[0], gray[1], gray[2][:470]], "picture 3: found a picture of 640x470; allowed: one of 640x480"),
                ([np.zeros((8000, 8000), np.uint8)], "picture 1: found a picture of 8000x8000; allowed: at most 32000000 pixels"),
                ([gray[0], file], "sources: found files and arrays"), ([], "sources: found none"), (gray[0], "sources: found .*ndarray"),
                ("x.png", "sources: found .*str"), ([file, 3], "picture 2: found <class 'int'>"), (None, "sources: found .*NoneType")):
            with self.assertRaisesRegex(ballservo.InputError, said):
                ballservo.calibrate_camera(sources, "chessboard:9x6", 0.025)
        with self.assertRaisesRegex(RuntimeError, "not found in any picture"):
            ballservo.calibrate_camera([np.full((480, 640), 90, np.uint8)], "chessboard:9x6", 0.025)

    def test_objects_are_as_good_as_their_files(self):
        camera, colors = ballservo.Camera.load(METRIC["camera"]), ballservo.Colors.load(Path(COLORS))
        of_files = ballservo.Detector(**METRIC).detect(self.pictures[0])
        of_objects = ballservo.Detector(colors, camera, METRIC["diameter"]).detect(self.pictures[0])
        np.testing.assert_array_equal(of_objects[0].covariance_m2, of_files[0].covariance_m2)
        followed = ballservo.Tracker(colors, camera, 0.12).update(self.pictures[0], 0)
        np.testing.assert_array_equal(followed[0].p_m, of_files[0].p_m)
        self.assertEqual(camera.covariance.shape, (9, 9))
        self.assertEqual(camera.parameters["fx_px"], 480)

    def test_learning_is_the_command_lines(self):
        ball = ballservo.Detector(COLORS).detect(self.pictures[0])[0].outline_px
        off = self.pictures[0].copy()
        cv2.circle(off, tuple(map(round, ball[:2])), round(ball[2] * 1.5), (120, 120, 120), -1)
        cv2.imwrite(str(self.place / "off.png"), off)
        self.program("calibrate", "colors", "--class", "red=pictures/frame_0000.png", "--at",
                     "red=" + ",".join(map(repr, ball.tolist())), "--background", "off.png", "-o", "taught.colors")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            colors = ballservo.Colors.learn({"red": [self.pictures[0]]}, at={"red": ball}, background=[off])
        colors.save(self.place / "own.colors")
        self.assertEqual((self.place / "own.colors").read_bytes(), (self.place / "taught.colors").read_bytes())
        with self.assertRaisesRegex(ballservo.InputError, "blue"):
            ballservo.Colors.learn({"red": [self.pictures[0]]}, at={"blue": (1, 2, 3)})

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
                         lambda a: ballservo.calibrate_camera([a, a], "chessboard:9x6", 0.025),
                         lambda a: tracker.update(a, chance.choice([np.nan, 1.0, -np.inf]))):
                try:
                    call(array)
                    answers += 1
                except (ValueError, TypeError, RuntimeError):
                    refusals += 1
        self.assertGreater(answers, 50)
        self.assertGreater(refusals, 3000)

    def test_whatever_arguments_come_their_names_are_told(self):
        scenario = ballservo.Scenario(SCENARIO)
        sweep = ballservo.sweep
        picture = np.zeros((48, 64, 3), np.uint8)
        saved = self.place / "saved.yaml"
        camera = ballservo.Camera.load(CAMERA)
        camera.save(saved)
        for call, said in (
                (lambda: scenario.look((np.nan, 0, 0)), "pose: found .nan, 0, 0."),
                (lambda: scenario.look((0, 1e308, 0)), "pose"),
                (lambda: sweep(SCENARIO, 1, threads=10**9), "threads: found 1000000000; allowed: 0 to 1024"),
                (lambda: sweep(SCENARIO, 2**40), "trials: found 1099511627776; allowed: 1 to 1000000"),
                (lambda: sweep(SCENARIO, 1, {"law.gain_per_s": [object()]}), "vary: law.gain_per_s"),
                (lambda: sweep(SCENARIO, 1, {"law.gain_per_s": None}), "vary: law.gain_per_s: found None"),
                (lambda: sweep(SCENARIO, 1, {"law.name": "cone"}), "allowed: a list of values"),
                (lambda: ballservo.compare("plan.yaml", threads=-1), "threads"),
                (lambda: ballservo.calibrate_camera(["x"], "chessboard:9x6", 0.1, threads=10**9), "threads"),
                (lambda: ballservo.Colors.learn({"red": ["x.png"]}), "pictures of red: found <class 'list'>"),
                (lambda: ballservo.Colors.learn({1: [picture]}), "pictures: found 1; allowed: names"),
                (lambda: ballservo.Tracker(COLORS).update(picture, np.nan), "time_s: found nan"),
                (lambda: camera.save(saved), "or overwrite=True to replace it"),
                (lambda: ballservo.Detector(COLORS, CAMERA, "x"), "^diameter: found 'x'")):
            with self.assertRaisesRegex(ballservo.InputError, said):
                call()

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

    def test_an_object_that_was_never_made_is_refused(self):
        camera, colors, detector, scenario = (
            kind.__new__(kind) for kind in (ballservo.Camera, ballservo.Colors, ballservo.Detector, ballservo.Scenario))
        for call in (lambda: camera.project(np.ones((1, 3))), lambda: camera.covariance,
                     lambda: ballservo.Detector(COLORS, camera=camera, diameter=0.07),
                     lambda: colors.classify(self.pictures[0]), lambda: detector.detect(self.pictures[0]),
                     lambda: ballservo.simulate(scenario)):
            with self.assertRaisesRegex(TypeError, "never made"):
                call()

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
        (self.place / "pybind11").write_text("ballservo._ballservo.[A-Z][A-Za-z]+\nballservo._ballservo.(Ball|Camera|CameraCalibration|Colors|Frame|Step|Sweep).__init__\n")
        done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "ballservo._ballservo", "--ignore-positional-only",
                               "--allowlist", "pybind11", "--ignore-unused-allowlist"],
                              cwd=self.place, env={**os.environ, "MYPYPATH": PACKAGE, "PYTHONPATH": PACKAGE},
                              capture_output=True, text=True)
        if "No module named" in done.stderr:
            self.skipTest("no python3-mypy")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=2)
