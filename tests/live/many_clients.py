#!/usr/bin/python3
"""usage: many_clients.py PROGRAM DATA [--seconds S] [--source FILE]

Eight clients of the live page: five as a browser, one slow, one that asks for pictures and reads nothing, one that comes
and goes. The pictures keep the pace that they have for one client, and the memory does not grow. Once with a film, once
with a scenario.
"""
import argparse, os, pathlib, socket, sys, tempfile, threading, time

from hostile_clients import film
from page_client import PageClient, Served

MOST_GROWTH_MB = 40
LEAST_RATE = 0.7  # of what one client gets


class Many:
    def __init__(self, served):
        self.served, self.ended, self.step, self.taken, self.faults, self.visits = served, False, {}, {}, [], 0

    def browse(self, name, pause_s=0.0):
        client = PageClient(self.served.url, 60)
        client.say(do="look", view="picture")
        while not self.ended:
            state = client.hear()["state"]
            self.step[name] = state.get("frame", state.get("step"))
            self.taken[name] = self.taken.get(name, 0) + 1
            time.sleep(pause_s)
            client.say(do="painted")

    def stall(self):
        """Let go after a while, it comes again."""
        while not self.ended:
            client = PageClient(self.served.url, 60)
            client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            try:
                while not self.ended:
                    client.say(do="look", view="picture")
                    client.say(do="painted")
                    time.sleep(0.1)
            except OSError:
                pass

    def come_and_go(self):
        while not self.ended:
            client = PageClient(self.served.url, 60)
            client.say(do="look", view="picture")
            self.visits += 1
            if self.visits % 2:
                client.hear()
                client.socket.close()
            else:
                client.reset()
            time.sleep(0.05)

    def start(self, what, *arguments):
        def guarded():
            try:
                what(*arguments)
            except Exception as error:
                self.faults.append(f"{what.__name__}: {type(error).__name__}: {error}")
        thread = threading.Thread(target=guarded)
        thread.start()
        return thread

    def rate_hz(self, seconds):
        """Pictures or control steps a second."""
        begin, first = time.monotonic(), self.step["first"]
        time.sleep(seconds)
        return (self.step["first"] - first) / (time.monotonic() - begin)


def watch(name, served, seconds):
    many = Many(served)
    threads = [many.start(many.browse, "first")]
    time.sleep(3)
    alone_hz = many.rate_hz(5)
    threads += [many.start(many.browse, f"browser {k}") for k in range(4)]
    threads += [many.start(many.browse, "slow", 1.0), many.start(many.stall), many.start(many.come_and_go)]
    time.sleep(10)
    before_mb = served.memory_mb()
    rate_hz = many.rate_hz(seconds)
    after_mb = served.memory_mb()
    many.ended = True
    for thread in threads:
        thread.join()
    print(f"{name}: {alone_hz:.1f} Hz for one client, {rate_hz:.1f} Hz for eight; {before_mb:.1f} MB, after {seconds:.0f} s {after_mb:.1f} MB; "
          f"{many.visits} visits, moments {many.taken}")
    faults = many.faults
    faults += [f"{after_mb - before_mb:.1f} MB more"] if after_mb > before_mb + MOST_GROWTH_MB else []
    faults += ["the pace is lost"] if rate_hz < LEAST_RATE * alone_hz else []
    code = served.end()
    return [f"{name}: {fault}" for fault in faults + ([f"exit code {code}: {served.said[-2000:]}"] if code else [])]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("data", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--seconds", type=float, default=15)
    parser.add_argument("--source", type=pathlib.Path, help="instead of a film of its own")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        place = pathlib.Path(folder)
        source = options.source.resolve() if options.source else film(options.program, options.data, place)
        faults = watch("film", Served(options.program, source, "--colors", options.data / "colors/red.colors"), options.seconds)
        faults += watch("scenario", Served(options.program, options.data / "scenarios/obstacles.yaml", "--perception", "geometric"), options.seconds)
    print(*faults, sep="\n")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
