"""The paper's claims, one by one, held against what was measured.

The setting of the paper's own figures is the condition `base` (a whole ball of 7 cm, 60 px across at 1 m); what is hidden
is the sweep of `occlusion`. A claim whose condition the plan lacks is not measured."""
import math
from types import SimpleNamespace

import numpy as np

from .comparison_results import SIGNIFICANT, median
from .page import figure_text, number, numbers

OF_TIMES = "the machine's times"  # these claims are on the page alone
MOST_NAMED = 6


def claims(data):
    """Nothing where they were not looked at."""
    m = data.facts["paper_measurements"]
    if not m:
        return []
    m = {**m, **m["timing"]}
    return [one_millimetre(data), votes(data, m),
            quality("Q_c of a round region is typically 4 times that of another", m["quality_ball"], m["quality_other"], 4),
            quality("Q_c is 2 times larger even where a ball touches a region of its own colour", m["quality_touching"],
                    m["quality_other"], 2),
            one_step(data), drift(data), half_hidden(data), four_classes(m),
            time_ratio("2 ms for a 0.7 Mpix frame with one ball", "detection", m["detect_us"], 2000, m["read_us"]),
            time_ratio("0.5 ms for the circle's estimation", "votes of one region", m["vote_us"], 500, m["read_us"]),
            time_ratio("6 ms a frame for classification and connected components", "both", m["segment_us"], 6000,
                       m["read_us"]),
            boundary(m)]


def claim(says, shown_by, verdict="not measured", measured=""):
    return SimpleNamespace(says=says, measured=measured, verdict=verdict, shown_by=shown_by)


def judged(holds, nearly, condition, otherwise="does not hold"):
    return "holds" if holds else f"holds if {condition}" if nearly else otherwise


def one_millimetre(data):
    says = "the position deviates typically by at most 1 mm: a whole ball of 7 cm at 1 m, 640x480"
    shown_by = "Where the errors lie: base"
    paper, sphere = (data.rows.get(("base", method)) for method in ("paper_one_step", "sphere_one_step"))
    if not paper:
        return claim(says, shown_by)
    columns = ("depth_rms_mm", "lateral_spread_mm", "position_median_mm")
    measured = "paper_one_step: depth RMS {} mm, sideways spread {} mm, 3-D median {} mm".format(
        *(figure_text(paper[name]) for name in columns))
    if sphere:
        measured += "; sphere_one_step: {}, {}, {} mm".format(*(figure_text(sphere[name]) for name in columns))
    sideways, depth = number(paper["lateral_spread_mm"]) <= 1, number(paper["depth_rms_mm"]) <= 1
    verdict = "does not hold"
    if sideways:
        verdict = "holds" if depth else "holds if the deviation is sideways; not in depth, with the paper's own fit"
    if not depth and sphere and number(sphere["depth_rms_mm"]) <= 1:
        verdict += "; the exact fit does it in depth too"
    return claim(says, shown_by, verdict, measured)


def votes(data, m):
    says, shown_by = "about 300 votes are typical", "frames.csv: votes"
    usual = number(m["votes"])
    if not math.isfinite(usual):
        return claim(says, shown_by)
    medians = [median(data.frame_values(name, "votes")) for name in data.names]
    medians = [value for value in medians if np.isfinite(value)]
    measured = (f"whole balls, drawn as the paper draws: median {usual:.0f}, most {number(m['votes_largest']):.0f}")
    if medians:
        measured += ("; the detector (which draws half of them from neighbours): medians by condition "
                     f"{min(medians):.0f} to {max(medians):.0f}")
    return claim(says, shown_by, judged(150 <= usual <= 600, max([usual, *medians]) >= 150, "part of the ball is hidden or "
                 "disturbed; a whole one needs fewer", "does not hold: fewer are needed"), measured)


def quality(says, ball, other, wanted):
    ratio = number(ball) / (number(other) or math.nan)
    if not math.isfinite(ratio):
        return claim(says, "this row")
    return claim(says, "this row", judged(ratio >= wanted, ratio >= 0.5 * wanted, f"{ratio:.1f} times will do"),
                 f"median Q_c {figure_text(ball)} against {figure_text(other)}: {ratio:.1f} times")


def one_step(data):
    says, shown_by = "exactly one iteration suffices", "paper_one_step against paper_converged"
    pair = ("paper_one_step", "paper_converged")
    totals = data.totals(pair) if pair in data.step_pairs else None
    if not totals or totals.frames == 0:
        return claim(says, shown_by)
    better, where = len(totals.better), data.in_words(totals.better)
    often = f", a quarter or more at {data.in_words(totals.often_broken)}" if totals.often_broken else ""
    measured = (f"accuracy: converging brings the ball nearer to the truth in {better} of {totals.told} conditions"
                f"{f' ({where})' if better else ''}, and in {len(totals.undecided)} more no test decides. Agreement: the "
                f"centres lie {figure_text(totals.center_median_px)} px apart in the median condition, "
                f"{figure_text(totals.center_max_px)} px in the worst frame; {totals.breaks} of {totals.frames} frames "
                f"break{often}")
    if better:
        return claim(says, shown_by, f"holds but at {where}" if 4 * better <= totals.told else "does not hold", measured)
    verdict = "holds for accuracy" + (", as far as these frames tell" if totals.undecided else "")
    if totals.breaks:
        verdict += (f"; {100 * totals.breaks / totals.frames:.1f} % of the frames break (over {data.facts['break_px']:g} px "
                    "from the converged fit), which costs no accuracy that a test tells")
    return claim(says, shown_by, verdict, measured)


def drift(data):
    says = "with outliers or clutter more iterations do harm"
    shown_by = "tests.csv: paper_steps_10_reselect against paper_one_step"
    tests = {name: data.tests.get((name, "paper_steps_10_reselect", "paper_one_step")) for name in data.names}
    tests = {name: test for name, test in tests.items() if test and int(test["frames"]) > 0}
    if not tests:
        return claim(says, shown_by)
    told = [name for name, test in tests.items() if number(test["wilcoxon_p"]) < SIGNIFICANT]
    worse = [name for name in told if number(tests[name]["difference_median_mm"]) > 0]
    better = [name for name in told if name not in worse]

    def where(names):
        return f"in {len(names)} ({data.in_words(names)})" if names else "nowhere"
    measured = (f"ten steps, the ring chosen anew at each, against one, in {len(tests)} conditions (Wilcoxon, p below 0.01: by "
                f"chance alone in {0.01 * len(tests):.1f} of them): nearer to the truth {where(better)}, further from it "
                f"{where(worse)}, no difference that a test tells in the others")
    if not worse:
        return claim(says, shown_by, "does not hold: no test tells that they do", measured)
    if 2 * len(worse) > len(tests):
        return claim(says, shown_by, "holds", measured)
    more = f" and {len(worse) - MOST_NAMED} more" if len(worse) > MOST_NAMED else ""
    return claim(says, shown_by, f"told in {len(worse)} of {len(tests)} conditions only, at "
                 f"{data.in_words(worse[:MOST_NAMED])}{more}; in {len(better)} they help, and in the others no test decides",
                 measured)


def half_hidden(data):
    says, shown_by = "worse beyond 50 % occlusion", "3-D error against hidden part of the disc"
    sweep = next((sweep for sweep in data.sweeps() if sweep.key == "occlusion"), None)
    if not sweep or "paper_one_step" not in data.methods:
        return claim(says, shown_by)
    rows = [data.rows[name, "paper_one_step"] for name in sweep.names]
    # A ball that is not found errs without bound: the medians are of all frames.
    errors = [number(row["charged_median_mm"] or "inf") for row in rows]
    whole = next((error for hidden, error in zip(sweep.values, errors) if hidden == 0), math.nan)
    below = max((error for hidden, error in zip(sweep.values, errors) if hidden <= 0.5), default=0)
    beyond = max((error for hidden, error in zip(sweep.values, errors) if hidden > 0.5), default=0)
    seen, lost = (sum(int(row[name]) for hidden, row in zip(sweep.values, rows) if hidden > 0.5)
                  for name in ("frames", "failed"))
    if seen == 0 or below == 0:
        return claim(says, shown_by)

    def mm(error):
        return "without bound (most frames are lost)" if math.isinf(error) else f"{figure_text(error)} mm"
    verdict = "does not hold"
    if not beyond <= 1.2 * below:
        verdict = "holds, but it gets worse long before that" if below > 2 * whole else "holds"
    return claim(says, shown_by, verdict,
                 f"paper_one_step, medians of all frames: {mm(whole)} whole, up to {mm(below)} until half is hidden, up to "
                 f"{mm(beyond)} beyond, where {lost} of {seen} frames are lost")


def four_classes(m):
    says, counts = "four colour classes are the practical limit", m["class_counts"]
    if len(counts) < 2:
        return claim(says, "this row")
    measured = "; ".join(
        f"{count} classes: {100 * number(right):.1f} % of the balls' pixels told right, {100 * number(wrong):.1f} % wrong"
        for count, right, wrong in zip(counts, m["class_right"], m["class_wrong"]))
    wrong = number(m["class_wrong"][-1])
    return claim(says, "this row", judged(wrong > 0.05, wrong > 0.01, "a pixel in a hundred must not be told wrong",
                 f"does not hold: {counts[-1]} are told apart in this light"), measured)


def time_ratio(says, what, us, paper_us, read_us):
    us, read_us = number(us), number(read_us)
    if not (us > 0 and read_us > 0):
        return claim(says, OF_TIMES)
    verdict = judged(us <= paper_us, us <= 2 * paper_us, "the machine is not shared", "does not hold here")
    return claim(says, OF_TIMES, verdict, f"{what} {us / 1000:.2f} ms: {us / read_us:.1f} times reading the frame once "
                 f"({read_us / 1000:.2f} ms)")


def boundary(m):
    says = "regions have far fewer boundary pixels than the picture has luminance edges"
    edge, boundary_px = number(m["edge_px"]), number(m["boundary_px"])
    if not edge > 0:
        return claim(says, "this row")
    verdict = judged(edge > 2 * boundary_px, edge > boundary_px, "fewer will do")
    times = edge / boundary_px if boundary_px else math.inf
    return claim(says, "this row", verdict, f"{boundary_px:.0f} boundary pixels of the ball's colour (four other things of it "
                 f"in view) against {edge:.0f} edge pixels (Canny): {times:.1f} times fewer")
