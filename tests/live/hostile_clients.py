#!/usr/bin/python3
"""usage: hostile_clients.py PROGRAM DATA [--inputs N] [--first K] [--seed SEED] [--only KIND] [--source FILE] [--patience S]

Clients of the live page that mean harm, or slip: garbage, halves of requests, wrong hosts and origins, wrong frames,
wrong commands, right commands at the wrong time, connections that end at any moment; half of them to a film, half to
a scenario. Two clients that do as the page does are served all the while, and in the end the program ends as it is told.
"""
import argparse, base64, collections, concurrent.futures, json, os, pathlib, random, subprocess, sys, tempfile, threading, time

from page_client import BINARY, CLOSE, PING, TEXT, Connection, PageClient, Served, frame

VERBS = ("look painted teach why rename camera hold keep undo pause step record save calibrate calibrate_stop calibrate_go_on calibrate_undo "
         "save_camera diameter load touch speed reset dance").split()
TOUCHES = "ball obstacle box robot law gain latency noise light avoidance dance".split()
FIELDS = ("serial u_px v_px radius_px name class view value board square_m diameter_m base64 factor touch x_m y_m yaw_rad per_s latency_s type do").split()
VALUES = [None, True, 0, -1, 7, 1e-320, 1e308, -1e308, 1 << 63, 1 << 64, 0.5, "", "red", "picture", "candidates", "chessboard:9x6", "chessboard:50x50",
          "circles:0x-3", "é\u0000\ud83d\ude00", "x" * 5000, "../../etc/passwd", "%s%n", [], {}, [[]], "1e400", "{a: &b [*b]}", "AAAA", "====", 0.07]
NAMES = {"u_px": [200, 320.5], "v_px": [120, 200], "radius_px": [0, 20, 1e9], "class": ["red", "green"], "view": ["picture", "candidates", "taught", "votes"]}


class Hostile:
    """One connection, and what comes of it."""
    def __init__(self, url, seed):
        self.random = random.Random(seed)
        self.kind = self.random.choice([name[3:] for name in dir(self) if name.startswith("as_")])
        self.url = url

    def run(self):
        self.connection = Connection(self.url)
        try:
            getattr(self, "as_" + self.kind)()
            if self.random.random() < 0.3:
                return self.connection.reset()
            if self.random.random() < 0.3:
                self.connection.socket.settimeout(0.05)
                self.connection.rest()
        except (OSError, EOFError):
            pass  # thrown out, which is right
        self.connection.socket.close()

    def send(self, *parts):
        """In pieces, and sometimes not to the end."""
        data = b"".join(parts)
        if self.random.random() < 0.15:
            data = data[:self.random.randrange(len(data) + 1)]
        at = self.random.randrange(len(data) + 1)
        for piece in data[:at], data[at:]:
            self.connection.socket.sendall(piece)

    def noise(self, most=300):
        return self.random.randbytes(self.random.randrange(most))

    def broken(self, data):
        data = bytearray(data)
        for _ in range(self.random.randrange(1, 6)):
            at, how = self.random.randrange(len(data) or 1), self.random.randrange(3)
            if how == 0:
                data[at:at + 1] = self.random.randbytes(1)
            elif how == 1:
                del data[at:at + self.random.randrange(1, 9)]
            else:
                data[at:at] = data[at:at + self.random.randrange(1, 30)]
        return bytes(data)

    def socket(self):
        self.connection.socket.sendall(self.connection.upgrade(path=self.random.choice(["/socket"] * 9 + ["/stream"])))
        return self.connection.socket.recv(4096)

    # ---- before the WebSocket

    def as_garbage(self):
        self.send(self.noise(5000))

    def as_broken_request(self):
        self.send(self.broken(self.random.choice([self.connection.request("/live.js"), self.connection.upgrade()])))

    def as_wrong_request(self):
        pick = self.random.choice
        self.send(self.connection.request(pick(["/", "/../../etc/passwd", "/socket", "*", "http://x/", "/%00%ff", "/" + "a" * 9000, "/?" + "?" * 99]),
                                          pick(["GET", "POST", "PUT", "OPTIONS", "TRACE", "PRI", "x" * 99]),
                                          pick(["evil.example", "", "127.0.0.1", "[::1]:80", "localhost:99999", "[", ":", "\x00", "é", None]),
                                          pick(["", "Origin: null\r\n", "Content-Length: 99999999999999999999\r\n", "Transfer-Encoding: chunked\r\n",
                                                "Content-Length: 5\r\nContent-Length: 6\r\n", "Expect: 100-continue\r\n", "X: " + "x" * 20000 + "\r\n",
                                                "".join(f"X{k}: y\r\n" for k in range(2000)), " folded\r\n", "\x00: \x01\r\n"])), self.noise())

    def as_wrong_upgrade(self):
        self.send(self.connection.request("/socket", more="Connection: Upgrade\r\nUpgrade: websocket\r\n" + self.random.choice([
            "", "Sec-WebSocket-Version: 99\r\n", "Sec-WebSocket-Version: 13\r\n", "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: short\r\n",
            "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nOrigin: http://evil.example\r\n"])), frame(b'{"do":"undo"}'))

    # ---- frames

    def as_garbage_frames(self):
        self.socket()
        self.send(self.noise(3000))

    def as_broken_frames(self):
        self.socket()
        self.send(self.broken(b"".join(frame(self.command()) for _ in range(self.random.randrange(1, 5)))))

    def as_wrong_frames(self):
        self.socket()
        pick, text = self.random.choice, b'{"do":"look","view":"picture"}'
        self.send(*(pick([frame(text, masked=False), frame(text, reserved=pick([1, 2, 4])), frame(text, pick([3, 7, 11, 15])), frame(text, 0),
                          frame(text, length=pick([0, 125, 1 << 16, 1 << 24, (1 << 63) - 1, 1 << 63])), frame(text, final=False), frame(b"\xff\xfe", TEXT),
                          frame(b"x" * 200, PING), frame(b"x", PING, final=False), frame(b"\x03", CLOSE), frame(b"\x00\x00", CLOSE),
                          frame(b"\x03\xe8\xff", CLOSE), frame(b"", PING) * 300, frame(b"[" * (1 << 20 | 5)), frame(self.noise(), BINARY)])
                    for _ in range(self.random.randrange(1, 4))))

    # ---- commands

    def value(self, field):
        return self.random.choice(NAMES.get(field, VALUES) if self.random.random() < 0.5 else VALUES)

    def command(self):
        """What may be said, with anything as arguments."""
        what = {field: self.value(field) for field in self.random.sample(FIELDS, self.random.randrange(7))}
        if self.random.random() < 0.7:
            what["touch"] = {field: self.value(field) for field in self.random.sample(FIELDS, self.random.randrange(4))}
            what["touch"] |= {"do": self.random.choice(TOUCHES), "x_m": self.random.uniform(0, 4), "y_m": self.random.uniform(-2, 2)}
        if self.random.random() < 0.2:
            what["base64"] = base64.b64encode(self.broken(COLORS) if self.random.random() < 0.9 else COLORS).decode()
        if self.random.random() < 0.5:
            what |= {"serial": self.random.randrange(max(1, NEWEST[self.url] - 20), NEWEST[self.url] + 2)}
        what["do"] = self.random.choice(VERBS)
        return json.dumps(what).encode()

    def as_wrong_messages(self):
        self.socket()
        deep = self.random.choice([10, 1000, 100000, 300000])
        self.send(frame(self.random.choice([
            b"", b"7", b"null", b"[]", b'{"do":3}', b'{"do":"look"}', b'{"do":"look","view":[]}', b'{"do":"undo","do":"pause"}', b'{"do":"undo",', b'"\\ud800"',
            b'{"do":"speed","factor":1e999}', b'{"do":"\\u0000"}', b'{"do":"' + b"x" * 100000 + b'"}', b'{"do":"touch","touch":' + b"[" * deep + b"]" * deep + b"}",
            b'{"do":"touch","touch":' + b'{"do":' * deep + b"7" + b"}" * deep + b"}", b'{"do":"why","serial":' + b"[" * deep + b"]" * deep + b"}",
            b'{"do":"touch","touch":{"do":"' + b"[" * deep + b'"}}']), self.random.choice([TEXT, BINARY])))
        self.connection.socket.settimeout(0.2)
        self.connection.socket.recv(100)

    def as_wild_commands(self):
        self.socket()
        self.send(*(frame(self.command(), self.random.choice([TEXT, BINARY])) for _ in range(self.random.randrange(1, 12))))

    def as_flood(self):
        self.socket()
        self.send(*(frame(self.command()) for _ in range(100)))

    def as_deaf(self):
        """Asks for pictures, and reads none."""
        self.socket()
        self.send(*(frame(b'{"do":"look","view":"%s"}' % view.encode()) + frame(b'{"do":"painted"}') for view in NAMES["view"] * 5))


NEWEST, COLORS = collections.Counter(), b""


class Witness:
    """Does as the page does; knows how long it had to wait for an answer."""
    def __init__(self, url, patience_s):
        self.url, self.patience_s, self.longest_s, self.moments, self.fault, self.ended = url, patience_s, 0, 0, "", False
        self.thread = threading.Thread(target=self.watch)
        self.thread.start()

    def watch(self):
        try:
            client = PageClient(self.url, self.patience_s)
            client.say(do="look", view="picture")
            while not self.ended:
                begin = time.monotonic()
                client.say(do="are you there")
                while "answer" not in (heard := client.hear()):
                    self.moments += 1
                    NEWEST[self.url] = heard["state"]["serial"]
                    client.say(do="painted")
                assert "refused" in heard
                if "too much" not in heard["refused"]:
                    self.longest_s = max(self.longest_s, time.monotonic() - begin)
                time.sleep(0.02)
        except Exception as error:
            self.fault = f"{type(error).__name__}: {error}"

    def end(self):
        self.ended = True
        self.thread.join()


def film(program, data, place):
    """A ball in a room, small."""
    for command in (["render", data / "scenarios/static_ball.yaml", "-o", "room", "--frames", "20"],
                    ["track", "room", "--colors", data / "colors/red.colors", "--video", "film.mkv", "-o", "rows.csv"]):
        subprocess.run([program, *command, "--quiet"], cwd=place, check=True, stdout=subprocess.DEVNULL)
    return place / "film.mkv"


def main():
    global COLORS
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("data", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--inputs", type=int, default=400)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only")
    parser.add_argument("--source", type=pathlib.Path, help="instead of a film of its own")
    parser.add_argument("--patience", type=float, default=30, help="s that a well-behaved client may wait for an answer")
    options = parser.parse_args()
    COLORS = (options.data / "colors/red.colors").read_bytes()
    faults, counts, begin = [], collections.Counter(), time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        place = pathlib.Path(folder)
        source = options.source.resolve() if options.source else film(options.program, options.data, place)
        served = [Served(options.program, source, "--colors", options.data / "colors/red.colors", "-o", "new.colors", "--save-camera", "new.yaml", cwd=place),
                  Served(options.program, options.data / "scenarios/obstacles.yaml", "--perception", "geometric", "--record", "run", cwd=place)]
        witnesses = [Witness(each.url, options.patience) for each in served for _ in range(2)]

        def one(number):
            hostile = Hostile(served[number % 2].url, options.seed * 10**6 + number)
            if options.only:
                hostile.kind = options.only
            counts[hostile.kind] += 1
            try:
                hostile.run()
            except OSError as error:
                return f"input {number} ({hostile.kind}): {error}"

        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            for fault in pool.map(one, range(options.first, options.first + options.inputs)):
                faults += [fault] if fault else []
                if len(faults) > 20 or any(each.child.poll() is not None for each in served):
                    pool.shutdown(cancel_futures=True)
                    break
        time.sleep(0.5)
        for witness in witnesses:
            witness.end()
            faults += [f"a well-behaved client: {witness.fault}"] if witness.fault else []
            faults += [f"a well-behaved client waited {witness.longest_s:.1f} s"] if witness.longest_s > options.patience else []
        for each, name in zip(served, ("film", "scenario")):
            memory_mb = each.memory_mb() if each.child.poll() is None else 0
            code = each.end()
            faults += [f"{name}: exit code {code}"] if code else []
            faults += [f"{name}: {each.said[-3000:]}"] if code or "ERROR" in each.said or "runtime error" in each.said or "fault of ours" in each.said else []
            print(f"{name}: {memory_mb:.0f} MB, " + ", ".join(f"{w.moments} moments, {w.longest_s:.2f} s at most for an answer" for w in witnesses if w.url == each.url))
    print(f"{sum(counts.values())} inputs {dict(counts)} in {time.monotonic() - begin:.0f} s: {len(faults)} faults", *faults[:20], sep="\n")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
