"""The page of app/demo.sh: five steps, each from its own input to its own result."""
import collections
import math
import re

from .page import number, photo, read_json, read_rows, text_of

BOARDS = ("board_01.png", "board_10.png")
DETECTION_COLUMNS = {"class": "colour", "quality": "quality, 0 to 1", "cx_px": "centre, from the left (px)",
                     "cy_px": "from the top (px)", "r_px": "radius (px)"}
PAIR_COLUMNS = {"condition": "pictures", "method_a": "one fit", "method_b": "the other", "frames": "frames",
                "center_median_px": "centres apart (px)", "radius_median_px": "radii apart (px)",
                "position_median_mm": "places apart (mm)"}


def page(folder):
    camera, run = read_json(folder / "left.json"), read_json(folder / "servo/summary.json")
    detections = read_rows(folder / "detections.csv")
    return dict(
        title="A robot sees a ball, places it in 3-D and drives to it", camera=camera, run=run,
        subtitle="Five steps, each from its own input to its own result: real photographs for the camera and the colours, a "
        "simulated robot for the drive. Everything on this page was computed on this machine just now, and every file it "
        "links to lies beside it.",
        value=value, degrees=math.degrees(1), found=found_by_class(detections),
        detections=cells(detections, DETECTION_COLUMNS), detection_columns=list(DETECTION_COLUMNS.values()),
        pairs=cells(read_rows(folder / "compare/pairs.csv"), PAIR_COLUMNS), pair_columns=list(PAIR_COLUMNS.values()),
        boards=[photo(folder / "boards", name, "Corners as found; red: what is left of each, 50 times enlarged.")
                for name in BOARDS if (folder / "boards" / name).exists()],
        colors=photo(folder / "colors", "smarties_figure.png", "From the photograph to the classes."),
        balls=[photo(folder / "found", "smarties.png", "What was found, drawn into the photograph."),
               photo(folder / "stages", "smarties_stages.png", "How it was found, stage by stage.")])


def value(number_or_none, decimals, scale=1):
    text = text_of(number_or_none, decimals, scale=scale)
    return "unknown" if text == "-" else text


def found_by_class(detections):
    counts = collections.Counter(row["class"] for row in detections)
    return ", ".join(f"{count} {name}" for name, count in counts.items()) or "nothing"


def cells(rows, columns):
    def cell(text):
        return f"{number(text):.4g}" if "." in text or "e-" in text else text
    return [[cell(row[column]) if column.endswith(("px", "mm", "quality")) else in_words(row[column])
             for column in columns] for row in rows]


def in_words(name):
    """"exact fit, one step" of sphere_one_step."""
    return re.sub("^paper_", "paper's fit, ", re.sub("^sphere_", "exact fit, ", name)).replace("_", " ")
