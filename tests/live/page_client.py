"""What a browser does with the live page, and a program that serves it: for tests that need more control than a browser gives."""
import contextlib, json, os, signal, socket, struct, subprocess

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10


def frame(data, opcode=TEXT, final=True, reserved=0, masked=True, length=None):
    """A WebSocket frame; `length`: a wrong one is said."""
    said = len(data) if length is None else length
    head = bytes([final << 7 | reserved << 4 | opcode])
    size = bytes([said]) if said < 126 else b"\x7e" + struct.pack(">H", said) if said < 1 << 16 else b"\x7f" + struct.pack(">Q", said)
    head += bytes([size[0] | masked << 7]) + size[1:]
    if not masked:
        return head + data
    key = os.urandom(4)
    whole = int.from_bytes(data, "little") ^ int.from_bytes((key * (len(data) // 4 + 1))[:len(data)], "little")
    return head + key + whole.to_bytes(len(data), "little")


class Connection:
    """The host and port of a page, and a socket to it."""
    def __init__(self, url, seconds=20):
        self.host = url.split("/")[2]
        name, port = self.host.rsplit(":", 1)
        self.socket = socket.create_connection((name, int(port)), seconds)

    def request(self, target="/", method="GET", host=None, more=""):
        return f"{method} {target} HTTP/1.1\r\nHost: {self.host if host is None else host}\r\n{more}\r\n".encode()

    def upgrade(self, more="", path="/socket"):
        return self.request(path, more="Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                                            f"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n{more}")

    def rest(self):
        """What comes until the other side closes."""
        said = b""
        with contextlib.suppress(ConnectionError):
            while part := self.socket.recv(1 << 16):
                said += part
        return said

    def reset(self):
        """Goes without a word."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.socket.close()


class PageClient(Connection):
    """A client of the WebSocket."""
    def __init__(self, url, seconds=20, path="/socket"):
        super().__init__(url, seconds)
        self.socket.sendall(self.upgrade(path=path))
        self.file = self.socket.makefile("rb")
        assert b" 101 " in self.file.readline()
        while self.file.readline() != b"\r\n":
            pass

    def say(self, **what):
        self.socket.sendall(frame(json.dumps(what).encode()))

    def hear(self):
        """The next message: an answer, or a moment's text."""
        while True:
            opcode, size = self.file.read(1)[0] & 15, self.file.read(1)[0]
            size = size if size < 126 else struct.unpack(">H", self.file.read(2))[0] if size == 126 else struct.unpack(">Q", self.file.read(8))[0]
            data = self.file.read(size)
            if opcode == PING:
                self.socket.sendall(frame(data, PONG))
            elif opcode == CLOSE:
                raise ConnectionError("closed")
            else:
                return json.loads(data) if opcode == TEXT else json.loads(data[4:4 + struct.unpack("<I", data[:4])[0]])

    def ask(self, **what):
        """The answer to what is said."""
        self.say(**what)
        while (heard := self.hear()).get("answer") != what["do"]:
            pass
        return heard


class Served:
    """The program, serving; `said` is what it wrote to stderr in the end."""
    def __init__(self, program, *arguments, cwd=None):
        self.child = subprocess.Popen([program, "live", *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=cwd)
        self.url = self.child.stdout.readline().strip()
        self.said = ""
        assert self.url, self.child.communicate()[1]

    def memory_mb(self):
        with open(f"/proc/{self.child.pid}/status") as status:
            return next(int(line.split()[1]) / 1024 for line in status if line.startswith("VmRSS"))

    def end(self, seconds=60):
        """Its exit code."""
        with contextlib.suppress(OSError):
            PageClient(self.url).say(do="end")
        try:
            self.said = self.child.communicate(timeout=seconds)[1]
        except subprocess.TimeoutExpired:
            self.child.send_signal(signal.SIGKILL)
            raise AssertionError("does not end") from None
        return self.child.returncode
