"""The answers of a comparison in sentences: is one step enough, and can one step tell by itself?"""
import numpy as np

from .page import figure_text, number, percent

MOST_ROWS, MOST_NAMED = 24, 3


def answers(data):
    """Over all conditions, for each condition that has a name of its own, and along each sweep."""
    pairs = data.step_pairs
    rows = [(data.by_name[name]["words"] if pair == pairs[0] else "", answer(data, name, pair))
            for name in data.named[:-(-MOST_ROWS // max(len(pairs), 1))] for pair in pairs]
    return {"fits": [fit_words(pair) for pair in pairs],
            "overall": [text for text in (nearest(data), *(overall(data, pair) for pair in pairs)) if text],
            "second_look": second_look(data), "conditions": rows,
            "sweeps": [(f"{sweep.label}: {sweep.values[0]:g} to {sweep.values[-1]:g}",
                        *(along(data, sweep, pair) for pair in pairs)) for sweep in data.sweeps()],
            "repeated": repeated(data, pairs[0][0]) if pairs else ""}


def fit_words(pair):
    return "The exact fit" if pair[0].startswith("sphere") else "The paper's fit"


def overall(data, pair):
    """How one step compares with its converged fit, over all conditions."""
    totals, count = data.totals(pair), len(data.conditions)
    if totals.frames == 0:
        return ""
    text = f"{fit_words(pair)} ({pair[0]}): "
    if totals.told > 0:
        text += (f"of {count} conditions, one step is enough in "
                 f"{totals.told - len(totals.better) - len(totals.undecided)}")
        if totals.worse:
            text += f" (in {len(totals.worse)} of them converging makes it worse)"
        if totals.undecided:
            text += f"; it is as far as these frames tell in {len(totals.undecided)} more, where no test decides"
        if totals.better:
            text += f"; the converged fit is nearer to the truth at {data.in_words(totals.better)}"
        if count > totals.told:
            text += f"; {count - totals.told} tell nothing"
        text += ". "
    text += f"It breaks in {totals.breaks} of {totals.frames} frames ({percent(totals.breaks / totals.frames)})"
    if totals.often_broken:
        text += f", in a quarter or more of them at {data.in_words(totals.often_broken)}"
    return (f"{text}. In the median condition the centres in the picture lie {figure_text(totals.center_median_px)} px "
            f"apart; in the worst frames the centres {figure_text(totals.center_max_px)} px, the radii "
            f"{figure_text(totals.radius_max_px)} px.")


def nearest(data):
    """Who does best, in a sentence."""
    unit, what = ("mm", "in 3-D") if data.places else ("px", "in the picture")
    named = [f"{method} ({figure_text(error)} {unit}{'' if found == 1 else f', found in {percent(found)}'})"
             for method, error, found in data.nearest()[:MOST_NAMED] if np.isfinite(error)]
    truth = "the truth" if data.text["rendered"] else "the annotations"
    return f"Nearest to {truth} {what}: {', then '.join(named)}." if named else ""


def second_look(data):
    """What the exact fit does on line before its last step."""
    rates = np.array([data.second_look_rate(name) for name in data.names])
    rates = rates[np.isfinite(rates)]
    if not len(rates):
        return ""
    return ("The exact fit's one step is the last of one or two: where the first was longer than a pixel, or the next "
            f"would be longer than {data.facts['enough_next_step_px']:g} px, it measures the edges a second time, from "
            "where it has got to, and steps again. On line as here that happens in "
            f"{percent(np.mean(rates))} of the frames (mean over the conditions; the least {percent(min(rates))}, the most "
            f"{percent(max(rates))}). sphere_one_step is the step after the last measurement, and sphere_converged has the "
            "same points.")


def median_mm(row):
    low, high = row["position_median_low_mm"], row["position_median_high_mm"]
    interval = f" (95 % {figure_text(low)} to {figure_text(high)})" if low else ""
    return f"{figure_text(row['position_median_mm'])} mm{interval}"


def answer(data, condition, pair):
    """"The exact fit: yes. ..."."""
    one, converged = (data.rows[condition, method] for method in pair)
    apart, verdict = data.pairs[(condition, *pair)], data.verdict(condition, pair)
    text = f"{fit_words(pair)}: {verdict.short_words}"
    if verdict.kind == "not told":
        return text
    return (f"{text} One step errs by {median_mm(one)}, the converged fit by "
            f"{figure_text(converged['position_median_mm'])} mm (medians). They lie {median_mm(apart)} apart (median), in "
            f"the worst frame {figure_text(apart['position_max_mm'])} mm; one step breaks in {apart['breaks']} of "
            f"{apart['frames']} frames. Found in {one['found']} of {one['frames']} frames.")


def along(data, sweep, pair):
    """"enough throughout", "enough; not enough at 3; no test decides at 5, 8"."""
    kinds = [data.verdict(name, pair).kind for name in sweep.names]
    parts = ["enough"] if {"enough", "further is worse"} & set(kinds) else []
    for kind, words in (("further is better", "not enough at"), ("undecided", "no test decides at"),
                        ("not told", "found in no frame at")):
        values = [f"{value:g}" for value, its in zip(sweep.values, kinds) if its == kind]
        if values:
            parts.append(f"{words} {', '.join(values)}")
    if parts[0] == "enough" and not {"further is better", "undecided"} & set(kinds):
        parts[0] = "enough throughout"
    return "; ".join(parts)


def repeated(data, method):
    """How far chance alone moves a median."""
    names = data.repeated_setting()
    if not names:
        return ""
    rows = [data.rows[name, method] for name in names]
    medians = ", ".join(f"{figure_text(row['position_median_mm'])} ({row['frames']} frames)" for row in rows)
    return (f"One setting stands here {len(names)} times, each time on frames of its own: {data.in_words(names)}. The medians "
            f"of {method} there, {medians} mm, differ by chance alone: so far may those of other conditions be off, too, and "
            "a verdict with them.")


def certificate_worth(row):
    """What one more step, where the first rule asks for it, is worth."""
    if not row["threshold"]:
        return (f"{row['one_step']}: no rule could be made, for nothing broke where it would have been learnt; "
                f"{row['tested_breaks']} of the {row['tested_frames']} frames tested break, the largest distance (of centres "
                f"or radii) is {figure_text(row['largest_before_px'])} px.")
    return (f"{row['one_step']}: one more step where the first rule asks for it is taken in "
            f"{percent(number(row['second_step_rate']))} of the frames tested and leaves {row['breaks_after']} breaks of "
            f"{row['breaks_before']}; the largest distance (of centres or radii) falls from "
            f"{figure_text(row['largest_before_px'])} px to {figure_text(row['largest_after_px'])} px.")
