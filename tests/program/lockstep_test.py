"""Lockstep from outside: our program drives and is driven, and no peer that dies, hangs or lies brings it down."""
import csv
import json
import os
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

import jsonschema
import zmq

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ["BALLSERVO_PROGRAM"]
MUJOCO_ROBOT = os.environ.get("BALLSERVO_MUJOCO_ROBOT")
SCENARIOS = ROOT / "data/scenarios"
EXAMPLES = ROOT / "app/examples"
VALIDATOR = jsonschema.Draft202012Validator(json.loads((ROOT / "data/lockstep.schema.json").read_text()))
DEADLINE_S = 2
LINES = zmq.Context()
LINES.linger = 0
OF_THE_ROBOT = ("step time_s x_m y_m yaw_rad v_mps w_radps v_command_mps w_command_radps range_m bearing_rad "
                "clearance_m in_view hidden pan_rad pan_command_radps").split()
OF_THE_CONTROLLER = ("step time_s v_command_mps w_command_radps state reason track_state error_1 error_2 "
                     "v_intended_mps w_intended_radps shield pan_command_radps").split()


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Robot(threading.Thread):
    """Stands, and sees a ball ahead of it. From step `at` on, `spoil` makes the parts of an answer; None: silence."""

    def __init__(self, spoil=lambda answer: [json.dumps(answer).encode()], at=30):
        super().__init__(daemon=True)
        self.spoil, self.at, self.requests, self.heard_s = spoil, at, [], []
        self.line = LINES.socket(zmq.ROUTER)
        self.address = f"tcp://127.0.0.1:{self.line.bind_to_random_port('tcp://127.0.0.1')}"
        self.start()

    def run(self):
        while self.line.poll(20000):
            *envelope, body = self.line.recv_multipart()
            self.heard_s.append(time.monotonic())
            request = json.loads(body)
            VALIDATOR.validate(request)
            self.requests.append(request)
            if "end" in request:
                break
            step, now_s = len(self.requests) - 1, request["until_s"]
            ball = {"state": "confirmed", "p_m": [0, 0.2, 2], "covariance_m2": [[1e-6, 0, 0], [0, 1e-6, 0], [0, 0, 1e-6]]}
            answer = {"ballservo_lockstep": 1, "time_s": now_s, "odometry": [0, 0, 0], "twist": [0, 0],
                      "frames": [{"frame": step, "time_s": now_s - 0.01, "arrived_s": now_s, "ball": ball}]}
            VALIDATOR.validate(answer)
            parts = self.spoil(answer) if step >= self.at else [json.dumps(answer).encode()]
            if parts is not None:
                self.line.send_multipart([*envelope, *parts])
        self.line.close()


def endless(port):
    """ZeroMQ's wire by hand: an answer whose parts never end."""
    listener = socket.socket()
    listener.bind(("127.0.0.1", port))
    listener.listen()
    line, _ = listener.accept()
    listener.close()
    line.sendall(b"\xff" + bytes(8) + b"\x7f\x03\x00" + b"NULL".ljust(20, b"\0") + bytes(32))
    said = b""
    while len(said) < 64:
        said += line.recv(64 - len(said))
    ready = b"\x05READY\x0bSocket-Type" + struct.pack(">I", 3) + b"REP"
    line.sendall(b"\x04" + bytes([len(ready)]) + ready)
    time.sleep(1)
    request = line.recv(1000000)
    begin = end = 2 + request[1]  # after READY
    while request[end + 1]:
        end += 2 + request[end + 1]
    line.sendall(request[begin:end + 2])  # the request's number, and an empty part
    part = b"\x03" + struct.pack(">Q", 900000) + bytes(900000)
    try:
        for _ in range(3000):
            line.sendall(part)
    except OSError:
        line.close()


class LockstepTest(unittest.TestCase):
    def setUp(self):
        self.place = Path(tempfile.mkdtemp(prefix="ballservo_lockstep_"))
        self.addCleanup(shutil.rmtree, self.place)

    def start(self, folder, *words, scenario="static_ball.yaml", level="geometric", deadline_s=30):
        process = subprocess.Popen([PROGRAM, "servo", SCENARIOS / scenario, "-o", folder, "--perception", level,
                                    "--deadline", str(deadline_s), *map(str, words)],
                                   cwd=self.place, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        return process

    def end(self, process, code):
        out, err = process.communicate(timeout=100)
        self.assertEqual(process.returncode, code, out + err)
        return out, err

    def summary(self, folder):
        return json.loads((self.place / folder / "summary.json").read_text())

    def columns(self, folder, names):
        with open(self.place / folder / "log.csv") as log:
            return [[row[name] for name in names] for row in csv.DictReader(log)]

    def test_the_example_robot_is_driven_to_its_ball(self):
        port = free_port()
        robot = subprocess.Popen(["/usr/bin/python3", EXAMPLES / "lockstep_robot.py", str(port)], text=True,
                                 stdout=subprocess.PIPE)
        self.addCleanup(robot.kill)
        self.end(self.start("out", "--seed", 3, "--peer", f"tcp://127.0.0.1:{port}"), 0)
        self.assertIn("0.80", robot.communicate(timeout=20)[0])
        summary = self.summary("out")
        self.assertLess(abs(summary["range_error_m"]), 0.005)
        self.assertEqual(summary["outcome"], "reached")
        self.assertTrue((self.place / "out/report.html").exists())

    @unittest.skipUnless(MUJOCO_ROBOT, "the example mujoco_robot was not built: there is no MuJoCo (libmujoco-dev)")
    def test_the_example_robot_in_mujoco_is_driven_to_its_ball(self):
        for scenario, clearance_m in ("static_ball.yaml", 1), ("corridor.yaml", 0.1):
            port = free_port()
            robot = subprocess.Popen([MUJOCO_ROBOT, str(port)], cwd=self.place, stdout=subprocess.PIPE, text=True)
            self.addCleanup(robot.kill)
            self.end(self.start(scenario, "--seed", 3, "--peer", f"tcp://127.0.0.1:{port}", scenario=scenario), 0)
            self.assertIn("reached", robot.communicate(timeout=20)[0])
            self.assertEqual(robot.returncode, 0)
            summary = self.summary(scenario)
            self.assertEqual(summary["outcome"], "reached")
            self.assertLess(abs(summary["range_error_m"]), 0.005)
            self.assertGreater(summary["min_clearance_m"], clearance_m)

    @unittest.skipUnless(MUJOCO_ROBOT, "the example mujoco_robot was not built: there is no MuJoCo (libmujoco-dev)")
    def test_the_example_robot_in_mujoco_says_what_it_cannot_build(self):
        port = free_port()
        robot = subprocess.Popen([MUJOCO_ROBOT, str(port)], cwd=self.place, stderr=subprocess.PIPE, text=True)
        self.addCleanup(robot.kill)
        _, err = self.end(self.start("out", "--peer", f"tcp://127.0.0.1:{port}", scenario="moving_ball.yaml"), 1)
        for said in err, robot.communicate(timeout=20)[1]:
            self.assertIn("balls: moving ones are not built here", said)
        self.assertEqual(robot.returncode, 1)

    def test_the_example_controller_drives_to_the_ball(self):
        port = free_port()
        served = self.start("out", "--seed", 3, "--serve", f"tcp://127.0.0.1:{port}")
        controller = subprocess.run(["/usr/bin/python3", EXAMPLES / "lockstep_controller.py", str(port)], text=True,
                                    capture_output=True, timeout=100)
        self.assertEqual(controller.returncode, 0, controller.stderr)
        self.end(served, 0)
        self.assertEqual(self.summary("out")["outcome"], "reached")

    def test_our_program_on_both_sides_is_our_program_alone(self):
        pan = "camera.mount.pan.max_rad=1.57"
        for scenario, level, sets in (("obstacles.yaml", "geometric", ["avoidance.floor=false", "duration_s=6", pan]),
                                      ("obstacles.yaml", "image", ["duration_s=1", pan])):
            words = ["--seed", 3, "--quiet"] + [word for each in sets for word in ("--set", each)]
            address = f"tcp://127.0.0.1:{free_port()}"
            runs = [self.start(f"{level}_{who}", *words, *more, scenario=scenario, level=level)
                    for who, more in (("alone", []), ("served", ["--serve", address]),
                                      ("driving", ["--peer", address, "--set", "duration_s=60"]))]
            for run in runs:
                self.end(run, 1)  # there is no time to reach the ball
            alone, driving = f"{level}_alone", f"{level}_driving"
            self.assertEqual(len(self.columns(alone, ["step"])), 1 + 50 * (6 if level == "geometric" else 1))
            self.assertEqual(self.columns(alone, OF_THE_ROBOT), self.columns(f"{level}_served", OF_THE_ROBOT))
            self.assertEqual(self.columns(alone, OF_THE_CONTROLLER), self.columns(driving, OF_THE_CONTROLLER))
            # Nobody told the driving side the truth.
            known = "range_error_m bearing_error_rad min_clearance_m out_of_view_s time_optimal_s".split()
            self.assertEqual([self.summary(driving)[key] for key in known], [None] * 5)
            self.assertEqual({*map(tuple, self.columns(driving, ["x_m", "range_m", "in_view"]))}, {("", "", "")})
            self.assertIn("the peer told no truth", (self.place / driving / "report.html").read_text())
            self.assertIn("law of a peer", (self.place / f"{level}_served/report.html").read_text())

    def test_robots_that_hang_or_lie_end_the_run(self):
        nan = [b'{"ballservo_lockstep": 1, "time_s": 0.6, "odometry": [NaN, 0, 0], "twist": [0, 0], "frames": []}']
        for spoil, words in ((lambda answer: None, "was silent for 2 s"), (lambda answer: nan, "in JSON"),
                             (lambda answer: [json.dumps({**answer, "time_s": 0.1}).encode()], "time_s: found 0.1"),
                             (lambda answer: [bytes(50000000)], "was silent for 2 s")):
            robot = Robot(spoil)
            _, err = self.end(self.start("out", "--peer", robot.address, "--force", deadline_s=DEADLINE_S), 1)
            self.assertIn(words, err)
            robot.join(20)
            summary = self.summary("out")
            self.assertEqual(summary["outcome"], "fault")
            self.assertIn(words, summary["outcome_text"])
            self.assertEqual(summary["steps"], 30)
            self.assertGreater(robot.requests[-2]["command"][0], 0.01)  # it was driving
            self.assertEqual(robot.requests[-1]["command"], [0, 0])
            waited_s = robot.heard_s[-1] - robot.heard_s[-2]
            print(f"{words}: told to rest {waited_s:.3f} s after it was asked last")
            self.assertLess(waited_s, DEADLINE_S + 1)

    def test_a_picture_of_another_size_is_said_to_be_so(self):
        robot = Robot(lambda answer: [json.dumps(answer).encode(), bytes(1280 * 720 * 3)], at=0)
        _, err = self.end(self.start("out", "--peer", robot.address, level="image"), 1)
        self.assertIn("picture of frames[0]: found 2764800 bytes; allowed: 921600 bytes: 480 rows of 640 pixels", err)
        self.assertFalse((self.place / "out").exists())

    def test_a_message_without_an_end_is_cut_off(self):
        port = free_port()
        threading.Thread(target=endless, args=(port,), daemon=True).start()
        _, err = self.end(self.start("out", "--peer", f"tcp://127.0.0.1:{port}"), 1)
        self.assertIn("sends a message without an end", err)

    def test_controllers_that_hang_or_lie_end_the_run(self):
        drive = {"ballservo_lockstep": 1, "command": [0.2, 0]}
        for lie, words in (({**drive, "until_s": 0.9}, "until_s: found 0.9; allowed: 0.4: a step is 0.02 s"),
                           ({**drive, "until_s": 0.4, "command": [0.2]}, "command: found [0.2]"),
                           ({**drive, "until_s": 0.4, "end": "enough"}, "the controller left: enough"),
                           (None, "was silent for 2 s")):
            port = free_port()
            served = self.start("out", "--serve", f"tcp://127.0.0.1:{port}", "--force", deadline_s=DEADLINE_S)
            line = LINES.socket(zmq.REQ)
            self.addCleanup(line.close)
            line.connect(f"tcp://127.0.0.1:{port}")
            for step in range(20):
                line.send_json({**drive, "until_s": step / 50})
                self.assertTrue(line.poll(20000))
                answer = line.recv_json()
                VALIDATOR.validate(answer)
                self.assertEqual("robot" in answer, step == 0)
            if lie:
                line.send_json(lie)
                self.assertTrue(line.poll(20000))
                answer = line.recv_json()
                VALIDATOR.validate(answer)
                self.assertIn(words, answer["over"]["text"])
            left = lie is not None and "end" in lie
            _, err = self.end(served, 130 if left else 1)
            self.assertIn(words, err)
            self.assertEqual(self.summary("out")["outcome"], "interrupted" if left else "fault")

    def test_a_second_controller_is_refused_and_the_first_drives_on(self):
        port = free_port()
        served = self.start("out", "--serve", f"tcp://127.0.0.1:{port}", "--set", "duration_s=0.8")
        first, second = (LINES.socket(zmq.REQ) for _ in range(2))
        for line in first, second:
            self.addCleanup(line.close)
            line.connect(f"tcp://127.0.0.1:{port}")

        def answer(line, step):
            line.send_json({"ballservo_lockstep": 1, "command": [0.2, 0], "until_s": step / 50})
            self.assertTrue(line.poll(20000))
            return line.recv_json()

        for step in range(41):
            self.assertNotIn("over", answer(first, step))
            if step in (0, 20):
                refusal = answer(second, step)
                VALIDATOR.validate(refusal)
                self.assertIn("another controller drives", refusal["over"]["text"])
        self.assertEqual(answer(first, 41)["over"]["outcome"], "timeout")
        self.end(served, 1)
        self.assertEqual(self.summary("out")["outcome"], "timeout")

    def test_who_waits_can_be_interrupted(self):
        for option in "--peer", "--serve":
            waiting = self.start("out", option, f"tcp://127.0.0.1:{free_port()}")
            self.assertRegex(waiting.stderr.readline(), "waiting for a (robot|controller) at tcp://127.0.0.1:[0-9]+")
            waiting.send_signal(signal.SIGINT)
            self.end(waiting, 130)
            self.assertFalse((self.place / "out").exists())

    def test_what_does_not_go_together_is_refused(self):
        for words, said in ((["--peer", "tcp://127.0.0.1"], "--peer: found 'tcp://127.0.0.1'"),
                            (["--peer", "ipc:///tmp/x:1"], "--peer"), (["--serve", "tcp://127.0.0.1:99999"], "--serve"),
                            (["--serve", "tcp://203.0.113.7:5577"], "--serve"),
                            (["--peer", "tcp://127.0.0.1:1", "--serve", "tcp://127.0.0.1:0"], "--serve: found with --peer"),
                            (["--peer", "tcp://127.0.0.1:1", "--realtime"], "--realtime: found with --peer"),
                            (["--serve", "tcp://127.0.0.1:0", "--touches", "x.yaml"], "--touches"),
                            (["--peer", "tcp://127.0.0.1:1", "--video"], "--video")):
            self.assertIn(said, self.end(self.start("out", *words), 2)[1])

    def test_a_robot_without_sonars_is_not_driven_among_obstacles(self):
        robot = Robot()
        _, err = self.end(self.start("out", "--peer", robot.address, scenario="obstacles.yaml"), 2)
        self.assertIn("a robot without sonars", err)
        robot.join(20)
        self.assertEqual(robot.requests[-1]["command"], [0, 0])
        self.assertIn("end", robot.requests[-1])


if __name__ == "__main__":
    unittest.main()
