"""What a comparison's page says in words, of results whose truth is known."""
import itertools
import unittest
from types import SimpleNamespace

from pages import PageTest

from ballservo.report.comparison_results import Comparison
from ballservo.report.paper_claims import claims

ONE, CONVERGED, TEN = METHODS = ("paper_one_step", "paper_converged", "paper_steps_10_reselect")
PAIR = (ONE, CONVERGED)
MEASURED = dict.fromkeys(("votes", "votes_largest", "quality_ball", "quality_touching", "quality_other", "boundary_px",
                          "edge_px")) | {"class_counts": [], "timing": dict.fromkeys(("read_us", "segment_us", "vote_us",
                                                                                     "detect_us"))}


def setting(name, key="", value=0, breaks=0, lost=0, further=0, ten=0):
    """One step errs by 1 mm in each of 20 frames. `further`: -1 where the converged fit is the better by a test, 1 where it
    is the worse; `ten`: ten steps against one, likewise."""
    return SimpleNamespace(name=name, key=key, value=value, breaks=breaks, lost=lost, further=further, ten=ten)


def results(*settings):
    data = object.__new__(Comparison)
    data.facts = {"paper_measurements": MEASURED, "break_px": 0.05}
    data.methods, data.step_pairs, data.names = METHODS, [PAIR], [s.name for s in settings]
    data.conditions = [{"name": s.name, "words": f"{s.key}{s.value}" if s.key else s.name, "swept_key": s.key,
                        "swept_label": f"{s.key} (m)", "swept_value": s.value, "swept_log": False} for s in settings]
    data.by_name = {condition["name"]: condition for condition in data.conditions}
    data.frames = {s.name: [] for s in settings}
    data.rows = {(s.name, method): {"frames": "20", "found": str(20 - s.lost), "failed": str(s.lost),
                                    "position_median_mm": "1", "charged_median_mm": "" if s.lost > 10 else "1",
                                    "lateral_spread_mm": "1", "depth_rms_mm": "1"}
                 for s, method in itertools.product(settings, METHODS)}
    data.pairs = {(s.name, *PAIR): {"frames": "20", "breaks": str(s.breaks), "center_median_px": "0.01",
                                    "center_max_px": "0.02", "radius_max_px": "0.08", "position_median_mm": "0.5"}
                  for s in settings}
    data.tests = {(s.name, method, ONE): {"frames": "20", "difference_median_mm": str(0.1 * sign),
                                          "wilcoxon_p": "0.001" if sign else "0.5"}
                  for s in settings for method, sign in ((CONVERGED, s.further), (TEN, s.ten))}
    return data


def claim(data, says):
    return next(it for it in claims(data) if says in it.says)


class Words(PageTest):
    def test_conditions_go_by_their_values_within_a_sweep(self):
        data = results(setting("base"), setting("z_1", "z", 1), setting("z_2", "z", 2), setting("y_3", "y", 3))
        self.assertEqual(data.in_words(data.names), "base; z (m): 1, 2; y (m): 3")
        self.assertEqual(data.in_words(["z_2"]), "z (m): 2")
        self.assertEqual(data.in_words([]), "")

    def test_a_repeated_setting_is_the_largest_group_that_shows_the_same(self):
        data = results(*map(setting, "abcd"))
        self.assertEqual(data.repeated_setting(), [])
        data.conditions[3]["words"] = data.conditions[1]["words"]
        self.assertEqual(data.repeated_setting(), ["b", "d"])

    def test_totals_count_frames_and_name_where_many_break(self):
        totals = results(setting("base", breaks=1), setting("z_1", "z", 1, breaks=5),
                         setting("z_2", "z", 2, breaks=4, further=-1), setting("z_3", "z", 3, further=1)).totals(PAIR)
        self.assertEqual((totals.frames, totals.breaks, totals.told), (80, 10, 4))
        self.assertEqual(totals.often_broken, ["z_1"])  # a quarter of 20
        self.assertEqual((totals.better, totals.worse, totals.undecided), (["z_2"], ["z_3"], ["base", "z_1"]))
        self.assertEqual((totals.center_max_px, totals.radius_max_px), (0.02, 0.08))

    def test_one_iteration_names_both_criteria(self):
        says = "one iteration"
        self.assertEqual(claim(results(setting("base"), setting("other")), says).verdict,
                         "holds for accuracy, as far as these frames tell")
        self.assertTrue(claim(results(setting("base", breaks=2), setting("other")), says).verdict.startswith(
            "holds for accuracy, as far as these frames tell; 5.0 % of the frames break"))
        one_of_five = results(*map(setting, "abcd"), setting("z_2", "z", 2, further=-1))
        self.assertEqual(claim(one_of_five, says).verdict, "holds but at z (m): 2")
        self.assertEqual(claim(results(setting("a", further=-1)), says).verdict, "does not hold")

    def test_harm_of_more_iterations_says_where(self):
        says = "more iterations do harm"
        some = claim(results(setting("base", ten=1), setting("b"), setting("c", ten=-1)), says)
        self.assertTrue(some.verdict.startswith("told in 1 of 3 conditions only, at base; in 1 they help"))
        self.assertIn("nearer to the truth in 1 (c), further from it in 1 (base)", some.measured)
        self.assertTrue(claim(results(setting("a")), says).verdict.startswith("does not hold"))
        self.assertEqual(claim(results(setting("a", ten=1)), says).verdict, "holds")

    def test_lost_balls_count_against_occlusion(self):
        """Where most balls are lost the others' errors say little."""
        def hidden(lost):
            return claim(results(*(setting(f"hidden_{part}", "occlusion", part, lost=lost if part > 0.5 else 0)
                                   for part in (0, 0.5, 0.6))), "50 %")
        self.assertEqual(hidden(0).verdict, "does not hold")
        self.assertEqual(hidden(15).verdict, "holds")
        self.assertIn("15 of 20 frames are lost", hidden(15).measured)


if __name__ == "__main__":
    unittest.main()
