"""What every test of the pages uses: the program, run once for each kind of result, and checks of any page."""
import atexit
import functools
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ["BALLSERVO_PROGRAM"]
SCRATCH = Path(tempfile.mkdtemp(prefix="ballservo_pages_"))
atexit.register(shutil.rmtree, SCRATCH, True)

sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "app/python"))
from ballservo.report.__main__ import draw, main  # noqa: E402, F401

EXAMPLES = "usr/share/doc/opencv-doc/examples/data"
HOSTILE = "\"><script>alert(1)</script>&'\x01 http$x_1$"


def program(*words, code=0, **environment):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True, cwd=SCRATCH,
                          env={**os.environ, **environment})
    assert done.returncode == code, f"{words}: {done.returncode}, not {code}\n{done.stdout}{done.stderr}"
    return done


PIXEL = b"what a browser would show"  # pages take pictures as they are


class PageTest(unittest.TestCase):
    def folder(self):
        folder = Path(tempfile.mkdtemp(dir=SCRATCH))
        self.addCleanup(shutil.rmtree, folder)
        return folder

    def copy(self, folder):
        return Path(shutil.copytree(folder, self.folder() / "copy"))

    def edit(self, folder, name, change):
        """Changes a JSON file of the folder: `change` takes what it holds."""
        held = json.loads((folder / name).read_text())
        change(held)
        (folder / name).write_text(json.dumps(held))


def drawn(folder):
    """The page of a folder, drawn in this process and checked."""
    draw(folder)
    html = (folder / "report.html").read_text(encoding="utf-8")
    check(html)
    return html


@functools.cache
def page_of(folder):
    """The page of a folder that no test changes, drawn and checked once."""
    return drawn(folder)


def check(html):
    """Well-formed as XML too, without scripts, loading nothing, without names that lead nowhere or shapes at NaN."""
    page = xml.etree.ElementTree.fromstring(html.replace("<!DOCTYPE html>", ""))
    without_pictures = re.sub(r"data:image/(png|jpeg);base64,[A-Za-z0-9+/\s]*=*", "", html)
    attributes = " ".join(re.findall(r"<[^>]*>", without_pictures))
    for loader in ("http:", "https:", "@import", "<script", "<link", "<iframe", "url(h", "//"):
        assert loader not in attributes, loader
    names = re.findall(r' id="([^"]*)"', html)
    assert len(names) == len(set(names)), "a name stands twice"
    for name in re.findall(r'(?:url\(#|href="#)([^")]*)', html):
        assert name in names, name
    for shape in re.findall(r' d="([^"]*)"', html):
        assert "nan" not in shape and "inf" not in shape, shape
    for picture in page.iter("img"):
        assert picture.get("src").startswith("data:image/")
    assert "\x01" not in html
    return page


def titles(html):
    return re.findall(r'aria-label="([^"]*)"', html)
