"""The results of a comparison, as its folder holds them, and what they say of one step against the converged fit."""
from collections import namedtuple
from types import SimpleNamespace

import numpy as np

from .page import figure_text, number, numbers, read_json, read_rows

SMALL_PART, SIGNIFICANT = 0.1, 0.01
# One step and its converged fit; what runs on line stands first.
STEP_PAIRS = (("sphere_one_step", "sphere_converged"), ("paper_one_step", "paper_converged"))
Verdict = namedtuple("Verdict", "kind short_words words")  # is one step enough: a kind, "yes.", and "yes: ..."


class Comparison:
    """The tables of a comparison's folder."""

    def __init__(self, folder):
        self.facts = read_json(folder / "report.json")
        setting = read_json(folder / "comparison.json")
        self.text, self.conditions, self.methods = (setting[key] for key in ("text", "conditions", "methods"))
        self.rules = read_json(folder / "summary.json")["certificates"]
        self.by_name = {condition["name"]: condition for condition in self.conditions}
        self.names = list(self.by_name)
        self.named = [condition["name"] for condition in self.conditions if not condition["swept_key"]]
        of_one, of_two = ("condition", "method"), ("condition", "method_a", "method_b")
        self.rows, self.times, self.pairs, self.tests = (
            {tuple(row[key] for key in keys): row for row in read_rows(folder / f"{table}.csv")}
            for table, keys in (("compare", of_one), ("timing", of_one), ("pairs", of_two), ("tests", of_two)))
        self.certificates = read_rows(folder / "certificate.csv")
        self.frames = {name: [] for name in self.names}
        for row in read_rows(folder / "frames.csv"):
            self.frames[row["condition"]].append(row)
        self.places = any(np.isfinite(numbers(self.rows.values(), "position_median_mm")))
        if not self.text["rendered"]:
            self.methods = [method for method, _, _ in self.nearest()]
        self.step_pairs = [pair for pair in STEP_PAIRS if set(pair) <= set(self.methods)]

    def column(self, method, name, conditions=None):
        return numbers([self.rows[condition, method] for condition in conditions or self.names], name)

    def nearest(self):
        """The methods with their errors (medians over the conditions, mm or px) and the parts of the frames in which
        they found the ball: the nearest to the truth first, those that miss far more than others last."""
        name = "position_median_mm" if self.places else "center_rms_px"
        methods = [(method, median(self.column(method, name)),
                    self.column(method, "found").sum() / max(self.column(method, "frames").sum(), 1))
                   for method in self.methods]
        most = max((found for _, _, found in methods), default=0)
        return sorted(methods, key=lambda m: (m[2] < 0.9 * most, np.nan_to_num(m[1], nan=np.inf)))

    def pair_column(self, method, name, conditions):
        rows = {condition: row for (condition, one, _), row in self.pairs.items() if one == method}
        return numbers([rows[condition] for condition in conditions], name)

    def frame_values(self, condition, name):
        """What is known of a condition's frames."""
        values = numbers(self.frames[condition], name)
        return values[np.isfinite(values)]

    def second_look_rate(self, condition):
        """In which part of the frames the exact fit measured its edges twice."""
        passes = self.frame_values(condition, "edge_passes")
        return np.mean(passes > 1) if len(passes) else np.nan

    def sweeps(self):
        """Conditions that vary one number, two or more, in its order: their names, and the number's."""
        found = []
        for key in dict.fromkeys(condition["swept_key"] for condition in self.conditions if condition["swept_key"]):
            conditions = sorted((c for c in self.conditions if c["swept_key"] == key), key=lambda c: c["swept_value"])
            first = conditions[0]
            if len(conditions) > 1:
                found.append(SimpleNamespace(key=key, label=first["swept_label"], names=[c["name"] for c in conditions],
                                             log=first["swept_log"] and first["swept_value"] > 0,
                                             values=[c["swept_value"] for c in conditions]))
        return found

    def in_words(self, names):
        """"base; noise, sigma (grey levels): 1, 5": conditions of a sweep by their values, others by their names."""
        words, last_key = "", ""
        for condition in (self.by_name[name] for name in names):
            key = condition["swept_key"]
            same = key and key == last_key
            words += (", " if same else "; ") if words else ""
            words += "" if same or not key else f"{condition['swept_label']}: "
            words += f"{condition['swept_value']:g}" if key else condition["name"]
            last_key = key
        return words

    def repeated_setting(self):
        """The largest group of two or more conditions that show the same, each on frames of its own; or nothing."""
        groups = {}
        for condition in sorted(self.conditions, key=lambda c: c["words"]):
            groups.setdefault(condition["words"], []).append(condition["name"])
        largest = max(groups.values(), key=len)
        return largest if len(largest) > 1 else []

    def verdict(self, condition, pair):
        """Is one step enough? Stepping on moves the ball by less than a tenth of its error, or a paired test tells
        which of the two fits is nearer to the truth."""
        apart = self.pairs[(condition, *pair)]
        one, further = (self.rows[condition, method] for method in pair)
        if int(apart["frames"]) == 0:
            return Verdict("not told", "not told.", "not told: no frame in which both found the ball")
        if not one["position_median_mm"]:
            return Verdict("not told", "not told.", "not told: the centres lie "
                           f"{figure_text(apart['center_median_px'])} px apart (median), but no place in space is known")
        change = (f"stepping on moves the ball by {figure_text(apart['position_median_mm'])} mm (median) where one step "
                  f"errs by {figure_text(one['position_median_mm'])} mm")
        error = f"{change}, and the converged fit errs by {figure_text(further['position_median_mm'])} mm"
        test = self.tests.get((condition, pair[1], pair[0]))
        if number(apart["position_median_mm"]) < SMALL_PART * number(one["position_median_mm"]):
            return Verdict("enough", "yes.", f"yes: {change}")
        if not test or not number(test["wilcoxon_p"]) < SIGNIFICANT:
            return Verdict("undecided", "yes, as far as these frames tell.",
                           f"yes: {change}, and no test tells which is nearer")
        if number(test["difference_median_mm"]) < 0:
            return Verdict("further is better", "no.", f"no: {error}")
        return Verdict("further is worse", "yes, and more is worse.", f"yes, and more is worse: {error}")

    def totals(self, pair):
        """The pair over all conditions in which both found the ball in some frame."""
        shared = [name for name in self.names if int(self.pairs[(name, *pair)]["frames"]) > 0]
        rows = [self.pairs[(name, *pair)] for name in shared]
        verdicts = {name: self.verdict(name, pair).kind for name in shared}

        def those(kind):
            return [name for name in shared if verdicts[name] == kind]
        return SimpleNamespace(
            told=len(shared) - len(those("not told")), better=those("further is better"), worse=those("further is worse"),
            undecided=those("undecided"), frames=sum(int(row["frames"]) for row in rows),
            breaks=sum(int(row["breaks"]) for row in rows),
            often_broken=[name for name, row in zip(shared, rows) if 4 * int(row["breaks"]) >= int(row["frames"])],
            center_median_px=median(numbers(rows, "center_median_px")),
            center_max_px=max(numbers(rows, "center_max_px"), default=0),
            radius_max_px=max(numbers(rows, "radius_max_px"), default=0))


def median(values):
    values = values[np.isfinite(values)]
    return np.median(values) if len(values) else np.nan
