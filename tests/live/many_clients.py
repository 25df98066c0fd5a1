#!/usr/bin/python3
"""usage: many_clients.py PROGRAM DATA [--seconds S] [--source FILE --colors FILE] [--least-rate SHARE] [--most-growth MB]

Eight clients of the live page: four as a browser, one slow, one that asks for pictures and reads nothing, one that reads
now and then, one that comes and goes. The pictures keep the pace that they have without any client, who reads is never
more than two pictures behind the newest, and the memory does not grow. Once with a film, once with a scenario.
"""
import argparse, os, pathlib, socket, sys, tempfile, threading, time

from hostile_clients import film
from page_client import PageClient, Served

MOST_BEHIND = 2  # pictures: what may come while one is on its way


class Many:
    def __init__(self, served):
        self.served, self.ended, self.newest, self.taken, self.behind, self.faults, self.visits = served, False, (0, 0), {}, {}, [], 0

    def hear(self, client, name, is_old=False):
        """A moment; how many behind the newest that anybody has heard of, unless it has waited to be read."""
        state = client.hear()["state"]
        serial, at = state["serial"], state.get("frame", state.get("step"))
        self.newest = max(self.newest, (serial, at))
        self.taken[name] = self.taken.get(name, 0) + 1
        if not is_old:
            self.behind.setdefault(name, []).append(self.newest[0] - serial)

    def browse(self, name, pause_s=0.0):
        client = PageClient(self.served.url, 60)
        client.say(do="look", view="picture")
        while not self.ended:
            self.hear(client, name)
            time.sleep(pause_s)
            client.say(do="painted")

    def sleepy(self):
        """What came while it slept is old; the next is not."""
        client = PageClient(self.served.url, 60)
        client.say(do="look", view="picture")
        while not self.ended:
            time.sleep(3)
            self.hear(client, "sleepy", is_old=True)
            client.say(do="painted")
            self.hear(client, "sleepy")
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

    def look(self):
        """Which picture or control step there is: by a client that goes again."""
        client = PageClient(self.served.url, 60)
        client.say(do="look", view="picture")
        state = client.hear()["state"]
        client.socket.close()
        return state.get("frame", state.get("step")), time.monotonic()

    def rate_hz(self, seconds):
        """Pictures or control steps a second."""
        first, begin = self.look()
        time.sleep(seconds)
        last, end = self.look()
        return (last - first) / (end - begin)


def watch(name, served, options):
    many = Many(served)
    time.sleep(3)
    alone_hz = many.rate_hz(min(60, options.seconds))
    threads = [many.start(many.browse, f"browser {k}") for k in range(4)]
    threads += [many.start(many.browse, "slow", 1.0), many.start(many.sleepy), many.start(many.stall), many.start(many.come_and_go)]
    time.sleep(5)
    before_mb = served.memory_mb()
    rate_hz = many.rate_hz(options.seconds)
    after_mb = served.memory_mb()
    many.ended = True
    for thread in threads:
        thread.join()
    behind = {who: max(each) for who, each in many.behind.items()}
    late = sum(behind > MOST_BEHIND for each in many.behind.values() for behind in each)
    print(f"{name}: {alone_hz:.2f} Hz without clients, {rate_hz:.2f} Hz with eight; {before_mb:.1f} MB, after {options.seconds:.0f} s {after_mb:.1f} MB; "
          f"behind at most {behind}, {late} of {sum(map(len, many.behind.values()))} more than {MOST_BEHIND}; {many.visits} visits, moments {many.taken}")
    faults = many.faults
    faults += [f"{after_mb - before_mb:.1f} MB more"] if after_mb > before_mb + options.most_growth else []
    faults += ["the pace is lost"] if rate_hz < options.least_rate * alone_hz else []
    faults += [f"{late} moments were old when they were read"] if late > options.most_late else []
    code = served.end()
    return [f"{name}: {fault}" for fault in faults + ([f"exit code {code}: {served.said[-2000:]}"] if code else [])]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("data", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--seconds", type=float, default=8)
    parser.add_argument("--source", type=pathlib.Path, help="instead of a film of its own")
    parser.add_argument("--colors", type=pathlib.Path, help="of the source's ball")
    parser.add_argument("--least-rate", type=float, default=0.7, help="of the pace without clients")
    parser.add_argument("--most-growth", type=float, default=40, help="of the memory, in MB")
    parser.add_argument("--most-late", type=int, default=20, help="moments: this program has to share the machine, too")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        place = pathlib.Path(folder)
        source = options.source.resolve() if options.source else film(options.program, options.data, place)
        colors = options.colors.resolve() if options.colors else options.data / "colors/red.colors"
        faults = watch("film", Served(options.program, source, "--colors", colors), options)
        faults += watch("scenario", Served(options.program, options.data / "scenarios/obstacles.yaml", "--perception", "geometric"), options)
    print(*faults, sep="\n")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
