"""What `track --stream` sends: the lines keep to the schema, say what the rows say, and come as pictures are followed."""
import csv
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

import jsonschema

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/live"))
from page_client import PageClient, Served
PROGRAM = os.environ["BALLSERVO_PROGRAM"]
DATA = ROOT / "data"
SCHEMA = json.loads((DATA / "stream.schema.json").read_text())
COLORS = ["--colors", DATA / "colors/red.colors"]
EXAMPLES = ["/usr/bin/python3", ROOT / "app/examples/read_stream.py"], [os.environ["BALLSERVO_READ_STREAM"]]
METRIC = ["--camera", "wide.yaml", "--diameter", "0.12+-0.0003"]


class StreamTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.place = Path(tempfile.mkdtemp(prefix="ballservo_stream_"))
        cls.addClassCleanup(shutil.rmtree, cls.place)
        done = cls.run_program("render", DATA / "scenarios/static_ball.yaml", "-o", "pictures", "--frames", "8")
        assert done.returncode == 0, done.stderr
        # The camera's own uncertainty is a part of the covariance.
        shutil.copy(DATA / "cameras/wide.yaml", cls.place)
        values = [480.0, 480.0, 319.5, 239.5, -0.12, 0.04, 0.0004, -0.0003, 0.0]
        (cls.place / "wide.yaml.covariance.json").write_text(json.dumps({
            "parameters": ["fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2", "k3"], "values": values,
            "covariance": [[25.0 if i == j < 2 else 0.0 for j in range(9)] for i in range(9)]}))

    @classmethod
    def run_program(cls, *words):
        return subprocess.run([PROGRAM, *map(str, words)], cwd=cls.place, capture_output=True, text=True)

    def track(self, *words, code=0):
        done = self.run_program("track", "pictures", *COLORS, *words, "--force")
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def pictures_of(self, text):
        self.assertTrue(text.endswith("\n"))
        pictures = [json.loads(line) for line in text.splitlines()]
        for picture in pictures:
            jsonschema.validate(picture, SCHEMA, jsonschema.Draft202012Validator)
        return pictures

    def test_lines_say_what_the_rows_say(self):
        jsonschema.Draft202012Validator.check_schema(SCHEMA)
        before = time.time()
        done = self.track(*METRIC, "-o", "rows.csv", "--stream", "-")
        pictures = self.pictures_of(done.stdout)
        self.assertEqual([p["source"] for p in pictures], [f"frame_{k:04}.png" for k in range(8)])
        self.assertIn("pictures with a ball", done.stderr)
        with open(self.place / "rows.csv") as table:
            rows = list(csv.DictReader(table))
        balls = [(picture, ball) for picture in pictures for ball in picture["balls"]]
        self.assertEqual(len(rows), len(balls))
        self.assertGreaterEqual(len(rows), 8)
        for row, (picture, ball) in zip(rows, balls):
            self.assertEqual((row["source"], int(row["frame"]), int(row["track_id"]), row["class"], row["state"]),
                             (picture["source"], picture["frame"], ball["track_id"], ball["class"], ball["state"]))
            s = ball["covariance_m2"]
            self.assertEqual([float(row[key]) for key in "time_s quality cx_px cy_px r_px x_m y_m z_m sxx_m2 sxy_m2 "
                              "sxz_m2 syy_m2 syz_m2 szz_m2".split()],
                             [picture["time_s"], ball["quality"], *ball["outline_px"], *ball["p_m"], s[0][0], s[0][1],
                              s[0][2], s[1][1], s[1][2], s[2][2]])
            self.assertEqual(s, [list(column) for column in zip(*s)])
        sent = [before, *(p["sent_unix_s"] for p in pictures), time.time()]
        self.assertEqual(sent, sorted(sent))
        self.assertTrue(all(p["captured_unix_s"] is None for p in pictures))

    def test_what_is_not_known_is_null_and_pictures_without_a_ball_have_a_line(self):
        subprocess.run(["/usr/bin/python3", "-c", "import cv2, numpy;"
                        "cv2.imwrite('grey.png', numpy.full((480, 640, 3), 128, 'uint8'))"], cwd=self.place, check=True)
        pictures = self.pictures_of(self.track("grey.png", "--stream", "-").stdout)
        self.assertEqual(len(pictures), 9)
        self.assertEqual([p["balls"] for p in pictures if p["source"] == "grey.png"], [[]])
        self.assertTrue(all(ball["p_m"] is None and ball["covariance_m2"] is None
                            for picture in pictures for ball in picture["balls"]))

    def test_a_line_comes_before_the_next_picture_is_followed(self):
        with subprocess.Popen([PROGRAM, "track", "pictures", *map(str, COLORS), "--stream", "-"], cwd=self.place,
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as running:
            running.stdout.readline()
            received = time.time()
            last = json.loads(running.stdout.read().splitlines()[-1])
        self.assertLess(received, last["sent_unix_s"])

    def test_datagrams(self):
        for family, host, text in (socket.AF_INET, "127.0.0.1", "localhost"), (socket.AF_INET6, "::1", "[::1]"):
            with socket.socket(family, socket.SOCK_DGRAM) as receiver:
                try:
                    receiver.bind((host, 0))
                except OSError:
                    self.assertEqual(family, socket.AF_INET6)  # not on every machine
                    continue
                receiver.settimeout(30)
                port = receiver.getsockname()[1]
                self.track("-o", "rows.csv", "--stream", f"udp:{text}:{port}")
                lines = [receiver.recv(65535).decode() for _ in range(8)]
                self.assertEqual(len(self.pictures_of("".join(lines))), 8)
        self.track("-o", "rows.csv", "--stream", f"udp:127.0.0.1:{port}")  # nobody listens any longer
        self.assertEqual(self.track("--stream", f"udp:127.0.0.1:{port}").stdout,
                         (self.place / "rows.csv").read_text())

    def test_odd_places_are_refused_before_any_work(self):
        for to in ("udp:", "udp:9000", "udp::9000", "udp:127.0.0.1:0", "udp:127.0.0.1:65536", "udp:127.0.0.1:9000x",
                   "udp:no.such.host.invalid:9000", "tcp:127.0.0.1:9000", "stream.json", ""):
            done = self.track("-o", "never.csv", "--stream", to, code=2)
            self.assertIn("--stream", done.stderr)
        for words in ("-o", "-"), ("--json", "-"), ("-o", "never.csv", "--json", "-"):
            self.assertIn("where the stream goes", self.track("--stream", "-", *words, code=2).stderr)
        self.assertFalse((self.place / "never.csv").exists())

    def test_a_reader_that_goes_ends_the_work(self):
        done = subprocess.run(["bash", "-c", '{ "$0" "$@"; echo $? >code; } | head -n 1', PROGRAM, "track", "pictures",
                               *map(str, COLORS), "-o", "part.csv", "--json", "part.json", "--stream", "-"],
                              cwd=self.place, capture_output=True, text=True)
        self.assertEqual(len(self.pictures_of(done.stdout)), 1)
        self.assertEqual((self.place / "code").read_text(), "130\n")
        self.assertTrue(json.loads((self.place / "part.json").read_text())["interrupted"])

    def test_the_examples_read_it(self):
        lines = self.track(*METRIC, "--stream", "-").stdout
        said = [subprocess.run(example, text=True, input=lines, capture_output=True, check=True).stdout for example in EXAMPLES]
        self.assertEqual(len(re.findall(r"^\d\.\d{3} s: red 1 \(\w+\) at \S+ \+- 0\.\d+, .* m$", said[0], re.M)), 8)
        self.assertEqual(said[0], said[1])

    def test_the_examples_hear_datagrams(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        for example in EXAMPLES:
            with subprocess.Popen([*example, str(port)], text=True, stdout=subprocess.PIPE) as reader:
                heard = f":{port:04X} 00000000:0000"
                while heard not in Path("/proc/net/udp").read_text():
                    time.sleep(0.01)
                self.track("--stream", f"udp:127.0.0.1:{port}")
                first = reader.stdout.readline()
                reader.kill()
            self.assertRegex(first, r"^0\.002 s: red 1 \(\w+\) at [\d.]+, [\d.]+ px$")

    def test_the_page_s_program_is_read_by_a_websocket(self):
        served = Served(PROGRAM, "pictures", *COLORS, cwd=self.place)
        program, frames = PageClient(served.url, path="/stream"), []
        while len(frames) < 5:
            picture = program.hear()
            jsonschema.validate(picture, SCHEMA, jsonschema.Draft202012Validator)
            frames += [picture["source"]] if picture["balls"] else []
        self.assertGreater(len(set(frames)), 2)
        self.assertEqual(served.end(), 0)

    def test_the_reference_names_every_key(self):
        section = (ROOT / "FILES.md").read_text().split("## The stream")[1].split("\n## ")[0]
        described = set(re.findall(r"`(\w+)`", "".join(re.findall(r"^\| `.*?\|", section, re.M))))
        self.assertEqual(described, set(SCHEMA["properties"]) | set(SCHEMA["$defs"]["ball"]["properties"]))


if __name__ == "__main__":
    sys.exit(unittest.main(verbosity=2))
