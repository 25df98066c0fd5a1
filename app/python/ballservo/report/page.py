"""What the pages share: files as numbers and clean texts, figures as SVG, pictures as data URIs, and the template."""
import base64
import csv
import importlib
import inspect
import io
import json
import math
import re
import warnings
import zlib
from pathlib import Path
from types import SimpleNamespace

import jinja2
import matplotlib
import numpy as np
from markupsafe import Markup, escape
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import ScaledTranslation
from PIL import Image

PAGES = ("run", "sweep", "grid", "comparison", "camera", "difference", "colors", "demo")

# Okabe and Ito's palette ("Color universal design", 2008): told apart by colour-blind readers too.
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#888888")
INK = "#1d2126"  # becomes the page's text colour, which follows the reader's light or dark system
MAP_COLORS = "viridis"
PHONE_PX = 520  # a wider drawing is scrolled on a phone, not shrunk
LEAST_HEIGHT_PX = 190

matplotlib.rcdefaults()
matplotlib.rcParams.update({
    "svg.fonttype": "none", "svg.hashsalt": "ballservo", "text.parse_math": False, "font.size": 11,
    "axes.prop_cycle": matplotlib.cycler(color=COLORS), "axes.titlesize": 12, "axes.titleweight": "bold",
    "axes.titley": 1.0, "axes.grid": True, "axes.axisbelow": True, "axes.spines.top": False, "axes.spines.right": False,
    "grid.color": INK, "grid.alpha": 0.15, "legend.frameon": False, "legend.fontsize": 10, "lines.linewidth": 1.7,
    "text.color": INK, "axes.edgecolor": INK, "axes.labelcolor": INK, "xtick.color": INK, "ytick.color": INK,
    "figure.facecolor": "none", "axes.facecolor": "none", "figure.constrained_layout.use": True,
    "figure.figsize": (20, 20)})
warnings.simplefilter("ignore")

# What neither XML nor a terminal should be handed: control characters, halves of surrogate pairs.
UNPRINTABLE = re.compile("[^\t\n\x20-\x7e\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def clean(value):
    """The same texts, lists and dictionaries with unprintable characters replaced."""
    if isinstance(value, str):
        return UNPRINTABLE.sub("\ufffd", value)
    if isinstance(value, list):
        return [clean(item) for item in value]
    if isinstance(value, dict):
        return {clean(key): clean(item) for key, item in value.items()}
    return value


def read_text(path):
    return Path(path).read_bytes().decode("utf-8", "replace")


def read_json(path):
    """A JSON file's object."""
    try:
        value = json.loads(read_text(path))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path.name}: found no JSON ({error})") from None
    if not isinstance(value, dict):
        raise ValueError(f"{path.name}: found no object")
    return clean(value)


def read_rows(path):
    """A CSV file's rows as dictionaries of text."""
    try:
        table = csv.DictReader(io.StringIO(read_text(path)))
        if not table.fieldnames:
            raise ValueError(f"{path.name}: found an empty file")
        return [clean(row) for row in table]
    except csv.Error:
        raise ValueError(f"{path.name}: found no CSV") from None


def number(text):
    """A number, NaN where a cell or a JSON value is empty."""
    return math.nan if text in (None, "") else float(text)


def numbers(rows, column):
    return np.array([number(row[column]) for row in rows])


def text_of(value, decimals=2, unit="", scale=1.0):
    """"1.23 mm", or "-" where nothing is known."""
    value = number(value) * scale
    if not math.isfinite(value):
        return "-"
    return f"{round(value, decimals) + 0.0:.{decimals}f} {unit}".rstrip()  # a rounded zero has no sign


def percent(share, decimals=1):
    return text_of(share, decimals, "%", 100)


def counted(count, one, many=None):
    return f"{count} {one if count == 1 else many or one + 's'}"


def figure_text(value):
    """Enough decimals to tell small values from zero."""
    size = abs(number(value))
    if not math.isfinite(size):
        return "-"
    if 0 < size < 5e-5:
        return "under 0.0001"
    decimals = 0 if size >= 100 else 1 if size >= 10 else 2 if size >= 1 else 3 if size >= 0.01 or size == 0 else 4
    return f"{float(value):.{decimals}f}"


def drawable(values):
    """As an array; what cannot be drawn is a gap."""
    values = np.array(values, dtype=float)
    values[~(np.abs(values) < 1e100)] = np.nan
    return values


def axes(title, x_label="", y_label="", width=480, height=320, log=""):
    """Axes of a figure of their own; `log` names those with a logarithmic scale: "x", "y", "xy". Sizes in px, shrunk to
    the widest that a figure may be (figure.figsize)."""
    shrunk = min(1, matplotlib.rcParams["figure.figsize"][0] * 72 / width)
    height = max(height * shrunk, min(height, LEAST_HEIGHT_PX))
    plot = Figure(figsize=(width * shrunk / 72, height / 72)).subplots()
    plot.set(title=title, xlabel=x_label, ylabel=y_label)
    for name in log:
        plot.set(**{f"{name}scale": "log"})
        axis = getattr(plot, f"{name}axis")
        axis.set_major_locator(LogLocator(subs=(1, 2, 5), numticks=8))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    return plot


def map_axes(title, x_range, y_range, x_label="", y_label="", width=480):
    """Axes with one scale for both directions; y grows downwards where its range does."""
    aspect = abs(y_range[1] - y_range[0]) / max(abs(x_range[1] - x_range[0]), 1e-9)
    plot = axes(title, x_label, y_label, width, min(max(aspect * (width - 60) + 70, 120), 2 * width))
    plot.set(xlim=x_range, ylim=y_range, aspect="equal")
    return plot


def legend(plot, columns=3, below=3.5):
    """The series' names so many lines below the drawing, where they hide nothing; in fewer columns where the figure is
    too narrow, which makes it higher."""
    figure, line = plot.figure, matplotlib.rcParams["font.size"] / 72
    place = plot.transAxes + ScaledTranslation(0, -below * line, figure.dpi_scale_trans)
    names = len(plot.get_legend_handles_labels()[1])
    for fitting in range(columns, 0, -1):
        drawn = plot.legend(loc="upper center", bbox_to_anchor=(0.5, 0), bbox_transform=place, ncol=fitting)
        if names == 0 or drawn.get_window_extent().width <= figure.bbox.width:
            break
    has_room = plot.get_aspect() == "auto"  # that of a map is all taken
    rows = -(-names // fitting) - -(-names // columns) * has_room
    figure.set_figheight(figure.get_figheight() + 1.2 * line * rows)


def curve(plot, x, y, name=None, **style):
    """A line; what is not finite is a gap."""
    return plot.plot(drawable(x), drawable(y), label=name, **style)


def goal_line(plot, value, text="", vertical=False):
    """A dashed line across the plot, such as a goal or a limit."""
    (plot.axvline if vertical else plot.axhline)(value, color=INK, alpha=0.6, linewidth=1, linestyle="--")
    if text:
        place = (value, 0.98) if vertical else (0.98, value)
        plot.text(*place, text, transform=plot.get_xaxis_transform() if vertical else plot.get_yaxis_transform(),
                  fontsize="small", alpha=0.8, va="top" if vertical else "bottom", ha="left" if vertical else "right")


def enlargement(lengths, longest):
    """1, 2 or 5 times a power of ten: the largest by which these lengths stay below the longest."""
    largest = np.nanmax(lengths)
    if not largest > 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(longest / largest))
    return next(power * digit for digit in (5, 2, 1) if digit == 1 or power * digit * largest <= longest)


def heat_map(title, unit, size_px, columns, values, high=None, width=480):
    """Values at the nodes of a grid over a picture, row by row; NaN stays without colour."""
    plot = map_axes(title, (-0.5, size_px[0] - 0.5), (size_px[1] - 0.5, -0.5), "u (px)", "v (px)", width)
    grid = np.reshape(drawable(values), (-1, columns))
    high = high or np.nanmax(grid, initial=0) or 1
    image = plot.pcolormesh(np.linspace(0, size_px[0] - 1, columns), np.linspace(0, size_px[1] - 1, len(grid)), grid,
                            cmap=MAP_COLORS, vmin=0, vmax=high, shading="nearest")
    plot.figure.colorbar(image, ax=plot, label=unit, shrink=0.8,
                         extend="max" if np.nanmax(grid, initial=0) > 1.0001 * high else "neither")
    plot.grid(False)
    return plot


class Drawing:
    """A plot as part of a page, and (figures.py) as a figure of a paper."""

    def __init__(self, plot, caption=""):
        self.plot, self.caption, self.title = plot, caption, plot.get_title()
        self.wide = plot.figure.get_figwidth() * 72 > PHONE_PX
        self.function = inspect.currentframe().f_back.f_code  # that drew it

    @property
    def markup(self):
        """Text stays text, colours follow the page, no name refers to the network."""
        text = io.StringIO()
        # The canvas itself, as savefig draws everything once more only to lay it out.
        FigureCanvasSVG(self.plot.figure).print_svg(
            text, metadata=dict.fromkeys(("Date", "Creator", "Format", "Type")))
        svg = text.getvalue()
        own = f"f{zlib.crc32(svg.encode()):x}-"  # names within a page are unique
        svg = svg[svg.index("<svg"):].replace(INK, "currentColor").replace("xlink:href", "href")
        svg = re.sub(r' xmlns(:xlink)?="[^"]*"', "", svg)
        svg = re.sub(r"(font: [^;\"]*?) '[^;\"]*", r"\1 sans-serif", svg)
        svg = re.sub(r'="([\d.]+)pt"', r'="\1"', svg)
        svg = re.sub(r' id="(?![mpC][0-9a-f_])[^"]*"', "", svg)
        svg = re.sub(r'(id="|url\(#|href="#)', rf"\g<1>{own}", svg)
        return Markup(svg.replace("<svg ", f'<svg role="img" aria-label="{escape(self.title)}" ', 1))


def photo(folder, name, caption="", widest_px=None):
    """A picture beside the page, taken into it; shrunk, as JPEG, to `widest_px`."""
    path = Path(folder) / Path(name).name
    kind, content = "png" if path.suffix == ".png" else "jpeg", io.BytesIO(path.read_bytes())
    if widest_px:
        kind, content = "jpeg", io.BytesIO()
        with Image.open(path) as picture:
            picture.thumbnail((widest_px, widest_px))
            picture.convert("RGB").save(content, "jpeg", quality=88)
    data = base64.b64encode(content.getvalue()).decode()
    markup = Markup('<img src="data:image/{};base64,{}" alt="{}"/>').format(kind, Markup(data), caption)
    return SimpleNamespace(markup=markup, caption=caption, wide=False)


def module_of(results):
    """The module that makes the page of a folder, by the page's name in report.json, or of a file of tracks."""
    if not results.is_dir():
        return importlib.import_module(".tracks", __package__)
    name = read_json(results / "report.json")["page"]
    if name not in PAGES:
        raise ValueError(f"page: found {name}; allowed: {', '.join(PAGES)}")
    return importlib.import_module(f".{name}", __package__)


def render(module, results):
    """The page: every text that is put into a template is escaped."""
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
                                     autoescape=True, trim_blocks=True, lstrip_blocks=True,
                                     undefined=jinja2.StrictUndefined)
    parts = environment.get_template("parts.html").module
    return environment.get_template("page.html").render(module.page(results), parts=parts, body=Path(module.__file__).stem + ".html")


def write(files):
    """By their paths; each is there whole or as it was."""
    for path, content in files.items():
        partial = path.with_name(path.name + ".partial")
        try:
            partial.write_bytes(content if isinstance(content, bytes) else content.encode())
            partial.replace(path)
        finally:
            partial.unlink(missing_ok=True)
