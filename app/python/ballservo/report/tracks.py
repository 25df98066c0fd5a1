"""The page of a file of tracks, as `track` writes it: where the balls went, and how well each was seen."""
from types import SimpleNamespace

import numpy as np
from matplotlib.patches import Ellipse

from . import NothingToDraw
from .page import (COLORS, INK, Drawing, axes, clean, counted, curve, drawable, legend, map_axes, numbers, percent,
                   read_rows, text_of)

WORDS = ("source", "track_id", "class", "state")
NUMBERS = ("frame", "time_s", "quality", "cx_px", "cy_px", "r_px", "x_m", "y_m", "z_m",
           "sxx_m2", "sxy_m2", "sxz_m2", "syy_m2", "syz_m2", "szz_m2")
# How the way to a row is drawn, by the row's state.
STATES = {"confirmed": {}, "tentative": {"alpha": 0.45}, "coasting": {"linestyle": ":"}}
HOW_DRAWN = "Dots: where tracks begin. Faint: tentative. Dotted: coasting, which is predicted."
MOST_SEQUENCES, MOST_LISTED = 6, 100
MOST_TRACKS = len(COLORS) - 1  # with colours of their own; the last is for all others
MOST_ROWS, MOST_ELLIPSES, MOST_LANES = 3000, 12, 30  # as drawn, of a track; tracks in the figure of the states
MOST_LETTERS = 24
HIGHEST, WIDEST = 1.25, 5  # of a map: height over width, width over height
SPEED_OVER_S = 0.5
LONGEST_STEP = 3  # of a line, in usual steps from row to row


def page(file):
    rows = read_tracks(file)
    parts = sequences_of(rows)
    sequences = [Sequence(rows[part], f", sequence {k}" if len(parts) > 1 else "")
                 for k, part in enumerate(parts[:MOST_LISTED], 1)]
    return dict(
        title=f"Tracks: {clean(file.name)}", described=[described(s) for s in sequences[:MOST_SEQUENCES]],
        subtitle=f"{counted(len(rows.frame), 'row')}, {counted(len(parts), 'sequence')}",
        overview=[(s.name, s.share, len(s.tracks), len(s.rows.frame)) for s in sequences],
        undrawn=max(0, len(parts) - MOST_SEQUENCES), unlisted=len(parts) - len(sequences))


def described(sequence):
    s = sequence
    places = [from_above(s), distance(s), height(s)] if s.in_3d else [radius(s)]
    listed = sorted(s.tracks[:MOST_LISTED], key=lambda track: track.time_s[0])
    return dict(name=s.name, share=s.share, facts=key_figures(s), figures=[way(s), *places, quality(s), states(s)],
                tracks=[track_row(track) for track in listed], unlisted=len(s.tracks) - len(listed),
                thinned=any(len(track.frame) > MOST_ROWS for track in s.tracks[:MOST_TRACKS]))


class Rows(SimpleNamespace):
    """Columns as arrays; by index, slice or mask a part of the rows."""

    def __getitem__(self, part):
        return Rows(**{name: values[part] for name, values in vars(self).items()})

    @property
    def place_m(self):
        return np.column_stack([self.x_m, self.y_m, self.z_m])

    @property
    def covariance_m2(self):
        xx, xy, xz, yy, yz, zz = (getattr(self, f"s{pair}_m2") for pair in ("xx", "xy", "xz", "yy", "yz", "zz"))
        return np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), -1, 0)


def read_tracks(file):
    table = read_rows(file)
    if not table:
        raise NothingToDraw("no row to draw: a header alone, as where no ball was seen")
    missing = [name for name in WORDS + NUMBERS if name not in table[0]]
    if missing:
        more = f" and {len(missing) - 3} more" if len(missing) > 3 else ""
        raise ValueError(f"no table of tracks: no column {', '.join(missing[:3])}{more}")
    rows = Rows(**{name.replace("class", "color"): np.array([row[name] or "" for row in table], dtype=object)
                   for name in WORDS})
    for name in NUMBERS:
        try:
            setattr(rows, name, drawable(numbers(table, name)))
        except ValueError as error:
            raise ValueError(f"{name}: {error}") from None
    if "detected" in rows.state:
        raise ValueError("rows of detect, which have no track: what track wrote is drawn")
    for state in sorted(set(rows.state) - set(STATES)):
        raise ValueError(f"state {state}, which is none of {', '.join(STATES)}")
    rows.seen = rows.state != "coasting"
    return rows


def sequences_of(rows):
    """Where one ends and the next begins: time goes back, or another source follows that is not just the next still."""
    time, still = rows.time_s, rows.frame == 0
    next_still = still[1:] & still[:-1] & (time[1:] > time[:-1])
    begins = np.flatnonzero((time[1:] < time[:-1]) | (rows.source[1:] != rows.source[:-1]) & ~next_still) + 1
    return [slice(*ends) for ends in zip([0, *begins], [*begins, len(time)])]


class Sequence:
    """Of one video, folder or camera; `tracks`: the rows of each, those seen longest first."""

    def __init__(self, rows, which=""):
        self.which = which  # in titles
        self.rows, self.in_3d = rows, bool(np.isfinite(rows.z_m).any())
        first, last = rows.source[0], rows.source[-1]
        self.name = first if first == last else f"{first} to {last}"
        _, rows.track, counts = np.unique(rows.track_id, return_inverse=True, return_counts=True)
        order = np.argsort(-np.bincount(rows.track, rows.seen), kind="stable")
        by_track = rows[np.argsort(rows.track, kind="stable")]
        ends = np.cumsum(counts)
        self.tracks = [by_track[ends[k] - counts[k]:ends[k]] for k in order]
        self.others = by_track[np.isin(by_track.track, order[MOST_TRACKS:])]

    @property
    def share(self):
        """In how many of its frames there was a ball, as far as rows tell."""
        rows, stills = self.rows, self.rows.source[0] != self.rows.source[-1]
        frame = rows.time_s if stills else rows.frame
        seen = len(np.unique(frame[rows.seen]))
        whole = len(np.unique(frame)) if stills else 1 + np.nanmax(frame, initial=-1)
        of = "pictures that have a row" if stills else "frames up to the last row"
        return f"{seen} of {whole:.15g} {of} ({percent(seen / max(whole, 1))})"

    def drawn(self):
        """Label, colour and rows of what is drawn."""
        drawn = [(label(track), color, track) for track, color in zip(self.tracks, COLORS[:-1])]
        if len(self.others.frame):
            drawn.append((f"{len(self.tracks) - MOST_TRACKS} others", COLORS[-1], self.others))
        return [(name, color, rows[::-(-len(rows.frame) // MOST_ROWS)]) for name, color, rows in drawn]


def label(track):
    text = f"{track.track_id[0]} {track.color[0]}"
    return text if len(text) <= MOST_LETTERS else text[:MOST_LETTERS - 3] + "..."


def key_figures(s):
    time = np.unique(s.rows.time_s[np.isfinite(s.rows.time_s)])
    count = {state: np.sum(s.rows.state == state) for state in STATES}
    low, middle, high = quantiles(range_m(s.rows[s.rows.seen]))
    return [("a ball in", s.share), ("tracks", len(s.tracks)), ("rows", ", ".join(f"{count[state]} {state}" for state in STATES)),
            ("time", f"{text_of(min(time, default=None), 2)} to {text_of(max(time, default=None), 2, 's')}"),
            ("rate, median", text_of(1 / np.median(np.diff(time)) if len(time) > 1 else None, 1, "Hz")),
            ("quality, median", text_of(quantiles(s.rows.quality[s.rows.seen])[1])),
            *([("distance", f"{text_of(middle, 3, 'm')} (5 % {text_of(low, 3)}, 95 % {text_of(high, 3)})")]
              if s.in_3d else [])]


def quantiles(values):
    values = values[np.isfinite(values)]
    return np.quantile(values, [0.05, 0.5, 0.95]) if len(values) else 3 * [np.nan]


def track_row(track):
    seen = track[track.seen]
    return [track.track_id[0], track.color[0], text_of(track.time_s[0]), text_of(track.time_s[-1]), len(seen.frame),
            len(track.frame) - len(seen.frame), text_of(quantiles(seen.quality)[1]), text_of(quantiles(seen.r_px)[1], 1),
            text_of(quantiles(range_m(seen))[1], 3), text_of(quantiles(speeds(seen))[1], 2)]


def speeds(rows):
    """At each row, by the straight line that fits best to the places (m) around it."""
    known = np.isfinite(rows.time_s) & np.isfinite(rows.place_m).all(axis=1)
    place, time = rows.place_m[known], rows.time_s[known]
    if len(time) == 0:
        return np.array([])
    time, place = time - time[0], place - place[0]
    ends = [np.searchsorted(time, time + sign * SPEED_OVER_S / 2, side) for sign, side in ((-1, "left"), (1, "right"))]

    def total(values):
        sums = np.concatenate([0 * values[:1], np.cumsum(values, axis=0)])
        return sums[ends[1]] - sums[ends[0]]
    count, times = total(np.ones((len(time), 1))), total(time[:, None])
    spread = total(time[:, None] ** 2) - times ** 2 / count
    slope = (total(time[:, None] * place) - times * total(place) / count) / np.where(spread > 0, spread, np.nan)
    return np.linalg.norm(slope, axis=1)[count[:, 0] > 2]


def shown(rows, *columns):
    """Ends of an axis around what is confirmed, if anything is."""
    values = np.concatenate([column[rows.state == "confirmed"] for column in columns])
    if not np.isfinite(values).any():
        values = np.concatenate(columns)
    low, high = np.nanmin(values, initial=np.inf), np.nanmax(values, initial=-np.inf)
    if not low <= high:
        return 0.0, 1.0
    margin = 0.06 * (high - low) or 0.1 * abs(high) or 0.1
    return low - margin, high + margin


def map_of(title, across, up, x_label, y_label):
    """Neither much higher than wide nor a thin strip."""
    def widened(ends, least):
        more = max(0, least - abs(ends[1] - ends[0])) / 2 * np.sign(ends[1] - ends[0])
        return ends[0] - more, ends[1] + more
    wide, high = across[1] - across[0], abs(up[1] - up[0])
    return map_axes(title, widened(across, high / HIGHEST), widened(up, wide / WIDEST), x_label, y_label, 520)


def lines(plot, sequence, x, y):
    """A line a track from x to y, functions of its rows."""
    for name, color, rows in sequence.drawn():
        across, up = x(rows), y(rows)
        for state, style in STATES.items():
            joined = follows(rows) & (rows.state[1:] == state)
            curve(plot, apart(across, joined), apart(up, joined), name if style == {} else None, color=color, **style)
        begins = np.r_[True, rows.track[1:] != rows.track[:-1]]
        plot.plot(across[begins], up[begins], ".", color=color)
    if len(sequence.tracks) > 1:
        legend(plot)


def follows(rows):
    """Whether each row but the first goes on with the track of the one before, without a gap in time."""
    same, step = rows.track[1:] == rows.track[:-1], np.diff(rows.time_s)
    return same & ~(step > LONGEST_STEP * np.nanmedian(step[same])) if same.any() else same


def apart(values, joined):
    """The points of a line, with a gap wherever one is not joined to the next."""
    last = ~np.r_[joined, False]
    kept = np.flatnonzero(~last | np.r_[False, joined])
    return np.insert(values[kept], np.flatnonzero(last[kept]) + 1, np.nan)


def way(sequence):
    rows = sequence.rows
    u = shown(rows, rows.cx_px - rows.r_px, rows.cx_px + rows.r_px)
    v = shown(rows, rows.cy_px - rows.r_px, rows.cy_px + rows.r_px)
    plot = map_of(f"The way through the picture{sequence.which}", u, v[::-1], "u (px)", "v (px)")
    lines(plot, sequence, lambda track: track.cx_px, lambda track: track.cy_px)
    return Drawing(plot, f"Centres of the outlines. {HOW_DRAWN}")


def from_above(sequence):
    rows = sequence.rows
    x, z = shown(rows, rows.x_m, 0 * rows.x_m), shown(rows, rows.z_m, 0 * rows.z_m)
    plot = map_of(f"From above{sequence.which}", x, z, "x, to the right (m)", "z, ahead (m)")
    lines(plot, sequence, lambda track: track.x_m, lambda track: track.z_m)
    for _, color, track in sequence.drawn()[:MOST_TRACKS]:
        seen = track[track.state == "confirmed"]
        for k in np.linspace(0, len(seen.frame) - 1, min(MOST_ELLIPSES, len(seen.frame))).astype(int):
            covariance = seen.covariance_m2[k][::2, ::2]
            if np.isfinite(covariance).all():
                size, axis = np.linalg.eigh(covariance)
                width, depth = 4 * np.sqrt(np.maximum(size, 0))
                plot.add_patch(Ellipse((seen.x_m[k], seen.z_m[k]), width, depth, angle=np.degrees(np.arctan2(*axis[::-1, 0])),
                                       color=color, alpha=0.5))
    plot.plot(0, 0, "^", color=INK, markersize=8)
    return Drawing(plot, f"The camera is the triangle. Ellipses: 2 sigma, of some confirmed rows. {HOW_DRAWN}")


def over_time(sequence, title, y_label, value, sigma=None):
    """A line a track, with a band of 2 sigma around it."""
    rows = sequence.rows
    plot = axes(title + sequence.which, "time (s)", y_label)
    for _, color, track in sequence.drawn()[:MOST_TRACKS] if sigma else ():
        middle, half = drawable(value(track)), 2 * drawable(sigma(track))
        ends = [apart(values, follows(track)) for values in (track.time_s, middle - half, middle + half)]
        plot.fill_between(*ends, color=color, alpha=0.2, linewidth=0)
    lines(plot, sequence, lambda track: track.time_s, value)
    plot.set(xlim=shown(rows, rows.time_s), ylim=shown(rows, value(rows)))
    return plot


def range_m(rows):
    return np.linalg.norm(rows.place_m, axis=1)


def range_sigma_m(rows):
    return np.sqrt(np.einsum("ni,nij,nj->n", rows.place_m, rows.covariance_m2, rows.place_m)) / range_m(rows)


def distance(sequence):
    plot = over_time(sequence, "Distance", "distance from the camera (m)", range_m, range_sigma_m)
    return Drawing(plot, f"The band is 2 sigma. {HOW_DRAWN}")


def height(sequence):
    plot = over_time(sequence, "Height", "-y, upwards in the picture (m)", lambda rows: -rows.y_m,
                     lambda rows: np.sqrt(rows.syy_m2))
    return Drawing(plot, f"Above the camera's axis, which is tilted as the camera is. The band is 2 sigma. {HOW_DRAWN}")


def radius(sequence):
    plot = over_time(sequence, "Radius", "radius of the outline (px)", lambda rows: rows.r_px)
    return Drawing(plot, f"It halves where the distance doubles; --camera and --diameter make metres of it. {HOW_DRAWN}")


def quality(sequence):
    plot = axes(f"Quality{sequence.which}", "time (s)", "quality")
    for name, color, rows in sequence.drawn():
        plot.plot(rows.time_s[rows.seen], rows.quality[rows.seen], ".", color=color, markersize=3, label=name)
    if len(sequence.tracks) > 1:
        legend(plot)
    plot.set(xlim=shown(sequence.rows, sequence.rows.time_s), ylim=(0, 1.03))
    return Drawing(plot, "How well outline and colour agree with a whole ball, of each row in which one was seen.")


def states(sequence):
    tracks = sorted(sequence.tracks[:MOST_LANES], key=lambda track: track.time_s[0])
    plot = axes(f"When each was seen{sequence.which}", "time (s)", "track", 480, 20 * len(tracks) + 110)
    for lane, track in enumerate(tracks):
        track = track[::-(-len(track.frame) // MOST_ROWS)]
        for state, style in STATES.items():
            time = apart(track.time_s, track.state[1:] == state)
            curve(plot, time, np.full(len(time), lane), color=COLORS[0], solid_capstyle="butt",
                  **{"linewidth": 8, **style, **({"linewidth": 2} if state == "coasting" else {})})
        plot.plot(track.time_s[0], lane, ".", color=COLORS[0])
    plot.set_yticks(range(len(tracks)), [label(track) for track in tracks])
    plot.set(xlim=shown(sequence.rows, sequence.rows.time_s), ylim=(len(tracks) - 0.5, -0.5))
    return Drawing(plot, f"Thick: confirmed, or, faint, tentative. Dotted: coasting. At most {MOST_LANES} tracks, those that "
                   "were seen longest.")
