#!/usr/bin/python3
"""usage: attacks.py PROGRAM DATA [--attacks N | --seconds S] [--first K] [--seed SEED] [--only KIND] [--jobs N]

Attacks every command that the program names, by chance: outputs named onto inputs, odd names, bad streams, full disks,
damaged inputs, odd values, signals at any moment. Whatever comes, the exit code is one of the contract's, inputs and
earlier results stay as they were, or are replaced whole, and nothing unfinished is left behind.
"""
import argparse, collections, concurrent.futures, hashlib, os, pathlib, random, re, resource, shutil, signal, subprocess
import sys, tempfile, time

# For each command its inputs, and a name for each output; the merges take what the set-up makes.
COMMANDS = {
    "calibrate board": ["--board", "chessboard:5x4", "--square", "0.03"],
    "calibrate camera": ["in/board", "--board", "chessboard:5x4", "--square", "0.03", "--model", "pinhole"],
    "calibrate diff": ["in/camera.yaml", "in/other.yaml"],
    "calibrate radius": "in/pictures --colors in/red.colors --camera in/camera.yaml --distances in/distances.csv".split(),
    "calibrate colors": ["--class", "red=in/pictures/frame_0000.png", "--add", "in/red.colors"],
    "detect": "in/pictures --colors in/red.colors --camera in/camera.yaml --diameter 0.12".split(),
    "track": "in/film.mkv --colors in/red.colors --camera in/camera.yaml --diameter 0.12".split(),
    "live": "in/film.mkv --colors in/red.colors --camera in/camera.yaml --diameter 0.12".split(),
    "render": ["in/scenario.yaml", "--frames", "3"],
    "servo": ["in/scenario.yaml", "--perception", "truth"],
    "sweep": ["in/scenario.yaml", "--trials", "4", "--perception", "truth"],
    "sweep merge": ["in/part_1", "in/part_2"],
    "compare": ["in/plan.yaml"],
    "compare merge": ["in/half_1", "in/half_2"],
    "report": ["in/whole", "in/rows.csv"],
}
NAMES = {"FILE.csv": "rows.csv", "FILE.colors": "new.colors", "FILE": "file", "DIR": "folder"}
CAMERA = """image_width: 160
image_height: 120
camera_name: small
camera_matrix: {rows: 3, cols: 3, data: [120.0, 0.0, %s, 0.0, 120.0, 59.5, 0.0, 0.0, 1.0]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0.0, 0.0, 0.0, 0.0, 0.0]}
"""
PLAN = """frames: 2
methods: [vote, paper_one_step]
defaults:
  camera: {focal_px: 200, width_px: 160, height_px: 120}
  ball: {color: red, diameter_m: 0.07}
  depth_m: 0.5
conditions: [{name: near}, {name: file, camera: {file: camera.yaml}}]
"""


class Program:
    def __init__(self, path):
        self.path = path
        self.outputs = {}
        self.values = {}
        for command in self.commands(""):
            text = self.help(command)
            self.outputs[command] = re.findall(r"^  (?:-o,)?(--[a-z-]+) (\S+)", self.section(text, "Outputs"), re.M)
            self.values[command] = re.findall(r"^  (--[a-z-]+) (N|NUMBER|METRES|I/N|[A-Z_.=,]+)", self.section(text, "Options"), re.M)

    def help(self, command):
        return subprocess.run([self.path, *command.split(), "--help"], capture_output=True, text=True).stdout

    @staticmethod
    def section(text, title):
        found = re.search(rf"^{title}:\n((?:  .*\n)*)", text, re.M)
        return found.group(1) if found else ""

    def commands(self, above):
        found = []
        for name in re.findall(r"^  ([a-z]+) ", self.section(self.help(above), "Subcommands"), re.M):
            command = f"{above} {name}".strip()
            if command != "calibrate":
                found.append(command)
            found += self.commands(command)
        return found


def board(path, shift):
    """A chessboard seen a little from the side, as PGM."""
    rows = bytearray()
    for y in range(240):
        for x in range(320):
            w = 1 + shift * (x - 160) / 900
            u, v = (x - 60 - 4 * shift) / 32 * w, (y - 40 + 3 * shift) / 32 * w
            inside = 0 <= u < 6 and 0 <= v < 5
            rows.append(30 if inside and (int(u) + int(v)) % 2 == 0 else 225)
    path.write_bytes(b"P5\n320 240\n255\n" + bytes(rows))


def set_up(program, data, place):
    """Good inputs of all kinds, most made by the program."""
    stock = place / "in"
    (stock / "board").mkdir(parents=True)

    def run(command, *more):
        done = subprocess.run([program.path, *command.split(), *more], cwd=place, capture_output=True, text=True)
        assert done.returncode == 0, (command, done.stderr)

    for k in range(5):
        board(stock / "board" / f"{k}.pgm", k - 2)
    (stock / "camera.yaml").write_text(CAMERA % "79.5")
    (stock / "other.yaml").write_text(CAMERA % "80.5")
    (stock / "plan.yaml").write_text(PLAN)
    shutil.copy(data / "colors/red.colors", stock / "red.colors")
    scenario = (data / "scenarios/static_ball.yaml").read_text()
    scenario = scenario.replace("../cameras/wide.yaml", "camera.yaml").replace("../colors/", "")
    scenario = scenario.replace("duration_s: 30", "duration_s: 3").replace("position: {x_m: 3.0", "position: {x_m: 1.2")
    (stock / "scenario.yaml").write_text(scenario.split("vary:")[0])
    run("render in/scenario.yaml -o in/pictures --frames 6")
    (stock / "distances.csv").write_text("source,distance_m\n" + "".join(f"frame_{k:04}.png,1.2\n" for k in range(6)))
    run("track in/pictures --colors in/red.colors --video in/film.mkv -o in/rows.csv")
    for part in "1", "2":
        run(f"sweep in/scenario.yaml --trials 4 --perception truth --shard {part}/2 -o in/part_{part}")
        run(f"compare in/plan.yaml --shard {part}/2 -o in/half_{part}")
    run("sweep merge in/part_1 in/part_2 -o in/whole")


def wait_until_heard(child):
    """Until the program hears signals: before its first instruction they are the system's."""
    ours = 1 << (signal.SIGINT - 1) | 1 << (signal.SIGTERM - 1)
    while child.poll() is None:
        caught = re.search(r"^SigCgt:\t(\w+)", pathlib.Path(f"/proc/{child.pid}/status").read_text(), re.M)
        if int(caught.group(1), 16) & ours == ours:
            break
        time.sleep(0.001)


def state(folder):
    """What each file below the folder holds; pages are drawn anew by whoever likes."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.name == "report.html" and path.parent.name == "whole":
            continue
        if path.is_symlink():
            found[path] = os.readlink(path)
        elif path.is_file():
            found[path] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


class Attack:
    def __init__(self, program, stock, place, seed, only):
        self.program, self.place, self.random = program, place, random.Random(seed)
        shutil.rmtree(place, ignore_errors=True)
        shutil.copytree(stock, place, symlinks=True)
        self.command = self.random.choice(sorted(program.outputs))
        self.outputs = {o: "out_" + NAMES[t] + o.strip("-") + self.extension(o) for o, t in program.outputs[self.command]}
        self.optional = [o for o in self.outputs if o != "--output"]
        kinds = [k[7:] for k in dir(self) if k.startswith("attack_")]
        self.kind = only or self.random.choice(kinds)
        self.arguments = [program.path, *self.command.split(), *COMMANDS[self.command]]
        self.allowed, self.before, self.options, self.stop_s, self.said = {2}, None, {}, None, ""

    def extension(self, option):
        output = {"calibrate camera": ".yaml", "calibrate board": ".pdf"}.get(self.command, "")
        return {"--video": ".mkv", "--save-camera": ".yaml", "--output": output}.get(option, "")

    def words(self, **names):
        chosen = [o for o in self.optional if self.random.random() < 0.4]
        named = {o: self.outputs[o] for o in (["--output"] if "--output" in self.outputs else []) + chosen}
        named.update(names)
        return [word for pair in named.items() for word in pair]

    def attack_output_onto_input(self):
        target = self.random.choice(sorted((self.place / "in").rglob("*")))
        used = [w for w in COMMANDS[self.command] if w.startswith("in/") or "=in/" in w]
        used = [w.split("=")[-1] for w in used]
        if used and self.random.random() < 0.7:
            target = self.place / self.random.choice(used)
            if target.is_dir() and self.random.random() < 0.7:
                target = self.random.choice(sorted(p for p in target.iterdir() if p.is_file()))
        beside_pictures = target.parent.name == "pictures" and target.suffix != ".png"  # of a folder pictures alone are read
        read = any(str(target.relative_to(self.place)).startswith(u) for u in used) and not beside_pictures
        spelling = self.random.choice(["plain", "dots", "absolute", "link", "hard", "folder link"])
        name = str(target.relative_to(self.place))
        if spelling == "dots":
            name = "./in/../" + name
        elif spelling == "absolute":
            name = str(target)
        elif spelling == "link" or (spelling == "hard" and target.is_dir()):
            (self.place / "link").symlink_to(target)
            name = "link"
        elif spelling == "hard":
            os.link(target, self.place / "link")
            name = "link"
        elif spelling == "folder link":
            (self.place / "also").symlink_to(target.parent)
            name = "also/" + target.name
        option = self.random.choice(list(self.outputs))
        self.arguments += self.words(**{option: name}) + ["--force"]
        # What no input is may be replaced, or is refused by another rule; inputs stay in any case.
        self.allowed = {2} if read else {0, 1, 2}
        self.changeable = None if read else target

    def attack_odd_name(self):
        (self.place / "itself").symlink_to("itself")
        (self.place / "dangling").symlink_to("no/where")
        name = self.random.choice(["", "x" * 300, "itself", "-", "no/such/folder/x", "in/plan.yaml/x", "/dev/full", "/dev/null",
                                   "/proc/self/mem", "dangling", "a\nb/c", "/", ".", "..", "x" * 5000, "/proc/x", b"\xff/\xfe"])
        option = self.random.choice(list(self.outputs))
        self.arguments += self.words(**{option: name})
        self.allowed = {0, 1, 2} if name in ("-",) else {2}

    def attack_odd_input(self):
        places = [k for k, w in enumerate(self.arguments) if w.startswith("in/")]
        if places:
            self.arguments[self.random.choice(places)] = self.random.choice(
                ["", "x" * 300, "http://127.0.0.1:9/x", "concat:in/film.mkv", "/dev/zero", "/dev/full", "/proc/self/mem", "in", "/",
                 "camera:99", "camera:x", "in/%03d.png", "-", "in/camera.yaml:x", b"\xff", "in/film.mkv", "in/plan.yaml", "/root/.none"])
        self.arguments += self.words()
        self.allowed = {0, 1, 2}

    def attack_streams(self):
        def closes(which):
            def close():
                for number in which:
                    os.close(number)
            return close

        which = self.random.choice([(0,), (1,), (2,), (1, 2), (0, 1, 2), "full", "full both", "pipe"])
        if isinstance(which, tuple):
            self.options["preexec_fn"] = closes(which)
        elif which != "pipe":
            full = open("/dev/full", "w")
            self.options["stderr"] = full
            if "both" in which:
                self.options["stdout"] = full
        else:
            reading, writing = os.pipe()
            os.close(reading)
            self.options["stdout"] = self.options["stderr"] = writing
        self.arguments += self.words()
        if self.random.random() < 0.5:
            self.arguments += [self.random.choice(["--help", "--no-such", "--json"])]
        self.allowed = {0, 1, 2}

    def attack_full_disk(self):
        limit = int(2 ** self.random.uniform(0, 16))
        self.options["preexec_fn"] = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
        self.arguments += self.words()
        self.allowed = {0, 1, 2}

    def attack_damaged_input(self):
        files = [p for w in COMMANDS[self.command] for p in self.files(w.split("=")[-1])]
        if not files:  # a command that reads none
            return self.attack_odd_value()
        self.changed = True
        path = self.random.choice(files)
        held = bytearray(path.read_bytes())
        for _ in range(self.random.choice([1, 1, 3, 30])):
            way, at = self.random.randrange(4), self.random.randrange(len(held) + 1)
            if way == 0:
                del held[at:]
            elif way == 1:
                held[at:at] = self.random.choice([b"\0", b"\xff\xfe", b"1e999", b"nan", b"-1", b'"', b"[" * 5000, b"\xef\xbb\xbf", b"\r\n"])
            elif way == 2 and at < len(held):
                held[at] = self.random.randrange(256)
            else:
                held[at:at] = held[:self.random.randrange(1, 400)]
        path.write_bytes(bytes(held))
        self.arguments += self.words()
        self.allowed = {0, 1, 2}

    def files(self, word):
        path = self.place / word
        return sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path] if path.is_file() else []

    def attack_odd_value(self):
        for _ in range(self.random.choice([1, 1, 2])):
            option = self.random.choice([v[0] for v in self.program.values[self.command]] or ["--seed"])
            value = self.random.choice(["", "-1", "0", "1e308", "nan", "inf", "99999999999999999999", "0x10", "1,5", "x", "-", "a=b", "=",
                                        "law.name=visp", "duration_s=nan", "2/1", "1/2", "9/9", "\u00e4", "'", "1", "3"])
            self.arguments += [f"{option}={value}"]
        self.arguments += self.words()
        self.allowed = {0, 1, 2}

    def attack_signal(self):
        self.arguments += self.words()
        if self.command != "live" and self.random.random() < 0.7:  # over a good result
            subprocess.run(self.arguments, cwd=self.place, capture_output=True)
            self.arguments += ["--force", "--seed", "3"]
        if self.random.random() < 0.5 and self.command not in ("report", "compare merge", "sweep merge"):
            longer = {"render": ("3", "3000"), "sweep": ("4", "900")}.get(self.command, ("", ""))
            self.arguments = [longer[1] if word == longer[0] and before in ("--frames", "--trials") else word
                              for before, word in zip([""] + self.arguments, self.arguments)]
        self.stop_s = self.random.uniform(0, 2.5) ** 2 / 2.5
        self.allowed = {0, 1, 130}

    def run(self):
        """Nothing, or what is wrong."""
        getattr(self, "attack_" + self.kind)()
        serves = self.command == "live" and self.stop_s is None  # ends when it is told to
        if serves:
            self.stop_s = 2
            self.allowed |= {130} if 0 in self.allowed else set()
        before = state(self.place)
        options = {"stdout": subprocess.PIPE if serves else subprocess.DEVNULL, "stderr": subprocess.PIPE, "stdin": subprocess.DEVNULL, **self.options}
        child = subprocess.Popen(self.arguments, cwd=self.place, **options)
        late = 0
        try:
            if serves and child.stdout:
                child.stdout.readline()  # its address, or the end
            if self.stop_s is not None:
                wait_until_heard(child)
                try:
                    child.wait(self.stop_s)
                except subprocess.TimeoutExpired:
                    child.send_signal(self.random.choice([signal.SIGINT, signal.SIGTERM]))
                asked = time.time()
                child.wait(60)
                late = time.time() - asked
            self.said = (child.communicate(timeout=300)[1] or b"").decode(errors="replace")
        except subprocess.TimeoutExpired:
            child.kill()
            return "does not end"
        after = state(self.place)
        code = child.returncode
        faults = []
        if code not in self.allowed:
            faults.append(f"exit code {code}")
        if "fault of ours" in self.said:
            faults.append("a fault of its own")
        faults += [f"left {p.name}" for p in after if ".partial-" in str(p)]
        gone = [p for p, held in before.items() if after.get(p) != held and p.parts[len(self.place.parts)] == "in"]
        faults += [f"changed {p}" for p in gone if p != getattr(self, "changeable", None) and p.parent != getattr(self, "changeable", None)]
        replaced = [p for p, held in before.items() if after.get(p) != held and p not in gone and p.name != "unfinished.journal"]
        gone_or_cut = [p for p in replaced if p not in after or p.suffix == ".json" and re.search(r'"interrupted": true', p.read_text())]
        if code not in (0, 1) and (gone_or_cut if code == 130 else replaced):
            faults.append(f"replaced {replaced[0]} in spite of exit code {code}")
        self.late_s = late
        return "; ".join(faults)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("data", type=pathlib.Path)
    parser.add_argument("--attacks", type=int, default=10**9)
    parser.add_argument("--seconds", type=float, default=1e9)
    parser.add_argument("--first", type=int, default=0, help="the number of the first attack")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    program = Program(os.path.abspath(options.program))
    unknown = set(program.outputs) ^ set(COMMANDS)
    assert not unknown, f"commands without an attack, or attacks without a command: {unknown}"
    begin, counts, wrong, late = time.time(), collections.Counter(), [], []
    with tempfile.TemporaryDirectory() as folder:
        place = pathlib.Path(folder).resolve()
        (place / "stock").mkdir()
        set_up(program, options.data.resolve(), place / "stock")

        def one(k):
            if time.time() - begin > options.seconds:
                return
            attack = Attack(program, place / "stock", place / str(k), options.seed * 10**6 + k, options.only)
            fault = attack.run()
            counts[attack.kind] += 1
            late.append(getattr(attack, "late_s", 0))
            if fault:
                wrong.append(fault)
                print(f"attack {k} ({attack.kind}): {fault}\n  {attack.arguments[1:]}\n  {attack.said[-300:].strip()}", flush=True)
            shutil.rmtree(attack.place, ignore_errors=True)

        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            pending, k = set(), options.first
            while k < options.first + options.attacks and time.time() - begin < options.seconds:
                while len(pending) < 2 * options.jobs and k < options.first + options.attacks:
                    pending.add(pool.submit(one, k))
                    k += 1
                done, pending = concurrent.futures.wait(pending, return_when=concurrent.futures.FIRST_COMPLETED)
                for future in done:
                    future.result()
    signalled = sorted(l for l in late if l > 0)
    if signalled:
        print(f"after a signal: median {signalled[len(signalled) // 2]:.2f} s, p99 {signalled[int(0.99 * len(signalled))]:.2f} s, most {signalled[-1]:.2f} s")
    print(f"{sum(counts.values())} attacks {dict(counts)}: {len(wrong)} got through, {time.time() - begin:.0f} s")
    sys.exit(bool(wrong))


main()
