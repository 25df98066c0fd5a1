"""Figures for a paper: each figure of a page at a column's width, as SVG, as PDF, and as the script that draws both."""
import inspect
import io
import re
import textwrap
from pathlib import Path

import matplotlib
from matplotlib.ticker import LogLocator

from .page import Drawing, module_of, write

COLUMN_MM, MOST_TICKS = 85, 6
STYLE = {"figure.figsize": (COLUMN_MM / 25.4, COLUMN_MM / 25.4), "font.size": 8, "axes.titlesize": 8,
         "axes.labelsize": 8, "xtick.labelsize": 7, "ytick.labelsize": 7, "legend.fontsize": 7, "lines.linewidth": 1.2,
         "lines.markersize": 4, "axes.linewidth": 0.6, "grid.linewidth": 0.5, "xtick.major.width": 0.6,
         "ytick.major.width": 0.6, "pdf.fonttype": 42, "figure.facecolor": "white", "axes.facecolor": "white"}
SCRIPT = '''{says}
# Draws {name}.svg and {name}.pdf beside it, from the results above. Change the function as you like.
from ballservo.report.figures import redraw
from ballservo.report.{module} import *


{source}

redraw({function}, __file__, {number}, {results!r})
'''


def drawings(values):
    """In whatever a page holds."""
    if isinstance(values, Drawing):
        yield values
    elif isinstance(values, (list, tuple, dict)):
        for value in values.values() if isinstance(values, dict) else values:
            yield from drawings(value)


def figures(module, results):
    """The page's drawings in a paper's style, by a name of each."""
    named = {}
    with matplotlib.rc_context(STYLE):
        for drawing in drawings(module.page(results)):
            words = re.findall("[a-z0-9]+", re.split("[:,]", drawing.title.lower())[0])
            name = "_".join(words)[:60] or "figure"
            same = sum(re.fullmatch(rf"{name}(_\d+)?", other) is not None for other in named)
            named[f"{name}_{same + 1}" if same else name] = drawing
    return named


def shown_ticks(axis):
    low, high = sorted(axis.get_view_interval())
    return [place for place in axis.get_majorticklocs() if low <= place <= high]


def pictures(drawing):
    """As SVG and as PDF."""
    plot, figure = drawing.plot, drawing.plot.figure
    with matplotlib.rc_context(STYLE):
        plot.set(title="", ylabel=textwrap.fill(plot.get_ylabel(), 28))
        figure.set_figwidth(COLUMN_MM / 25.4)
        for axis in plot.xaxis, plot.yaxis:
            if axis.get_scale() == "log" and len(shown_ticks(axis)) > MOST_TICKS:
                axis.set_major_locator(LogLocator())
        for kind, undated in (("svg", "Date"), ("pdf", "CreationDate")):
            file = io.BytesIO()
            figure.savefig(file, format=kind, metadata={undated: None})
            yield kind, file.getvalue()


def script(name, number, drawing, module, results):
    says = textwrap.wrap(" ".join(f"{drawing.title}. {drawing.caption}".split()), 116)  # nothing leaves its line
    return SCRIPT.format(says="\n".join(f"# {line}" for line in says), name=name, number=number, results=results,
                         module=Path(module.__file__).stem, source=inspect.getsource(drawing.function),
                         function=drawing.function.co_name)


def write_figures(module, results):
    """Into `figures` in the folder, or beside tracks.csv into tracks_figures."""
    folder = results.is_dir()
    place = results / "figures" if folder else results.with_name(results.stem + "_figures")
    place.mkdir(exist_ok=True)
    for number, (name, drawing) in enumerate(figures(module, results).items()):
        text = script(name, number, drawing, module, ".." if folder else f"../{results.name}")
        write({place / f"{name}.py": text, **{place / f"{name}.{kind}": data for kind, data in pictures(drawing)}})


def redraw(function, file, number, results):
    """Draws the figure of a script again, the page's numberth, by the script's function in place of the page's."""
    file = Path(file).resolve()
    results = (file.parent / results).resolve()
    module = module_of(results)
    setattr(module, function.__name__, function)
    drawing = list(figures(module, results).values())[number]
    write({file.with_suffix(f".{kind}"): data for kind, data in pictures(drawing)})
