"""What all pages are made of: clean texts, numbers as text, figures as SVG."""
import itertools
import json
import math
import random
import unittest

from pages import HOSTILE, PageTest, check, titles

from ballservo.report import page

NAN, INF = math.nan, math.inf


def html_of(*drawings):
    parts = "".join(f"<figure>{drawing.markup}</figure>" for drawing in drawings)
    check(f"<html>{parts}</html>")
    return parts


def paths(drawing):
    return str(drawing.markup).count("<path")


class Texts(PageTest):
    def test_what_cannot_be_printed_is_replaced(self):
        self.assertEqual(page.clean("a\0b\x1b[31m\r\x7f\x85\ufffe\ud800"), "a\ufffdb\ufffd[31m" + 5 * "\ufffd")
        kept = "R = 0.07 m, 28\u00b0, \u2264 1 px, \U0001f534\tnext\nline"
        self.assertEqual(page.clean({"a\0": [kept, 1.5, None]}), {"a\ufffd": [kept, 1.5, None]})

    def test_files_that_are_not_utf_8_are_read_all_the_same(self):
        folder = self.folder()
        (folder / "table.csv").write_bytes(b"name,x_m\n\xff\xc0\xbc,1.5\n\"a\nb\",\n")
        rows = page.read_rows(folder / "table.csv")
        self.assertEqual(rows[0]["name"], "\ufffd\ufffd\ufffd")
        self.assertEqual(str(page.numbers(rows, "x_m")), "[1.5 nan]")
        (folder / "facts.json").write_bytes(json.dumps({"name": "\x01"}).encode())
        self.assertEqual(page.read_json(folder / "facts.json"), {"name": "\ufffd"})

    def test_numbers_have_their_decimals_and_no_negative_zero(self):
        self.assertEqual(page.text_of(0.00123, 2, "mm", 1e3), "1.23 mm")
        self.assertEqual(page.text_of(-1e-9, 2), "0.00")
        for unknown in (None, "", NAN, INF):
            self.assertEqual(page.text_of(unknown, 2, "mm"), "-")
            self.assertEqual(page.figure_text(unknown), "-")
        self.assertEqual([page.figure_text(x) for x in (0, 1e-5, 0.0049, 0.012, 1.234, -12.34, 123.4)],
                         ["0.000", "under 0.0001", "0.0049", "0.012", "1.23", "-12.3", "123"])

    def test_lengths_are_enlarged_by_round_numbers(self):
        self.assertEqual([page.enlargement([length], 50) for length in (0.1, 0.3, 7, 60, 0, 1e-12)][:5],
                         [500, 100, 5, 0.5, 1])
        for _ in range(200):
            length, longest = 10 ** random.Random(7).uniform(-6, 3), 10 ** random.Random(8).uniform(-1, 3)
            self.assertLessEqual(length * page.enlargement([length], longest), longest * (1 + 1e-9))


class Figures(unittest.TestCase):
    def line(self, x, y, log="", **options):
        plot = page.axes("title", "x", "y", log=log, **options)
        page.curve(plot, x, y, "s")
        page.legend(plot)
        return page.Drawing(plot)

    def test_a_gap_breaks_the_line_and_does_not_move_the_axes(self):
        whole, broken = self.line([0, 1, 2, 3, 4], [0, 1, 0, 1, 0]), self.line([0, 1, 2, 3, 4], [0, 1, NAN, 1, 0])
        starts = [str(drawing.markup).count("M ") for drawing in (whole, broken)]
        self.assertEqual(starts[1], starts[0] + 1)
        html_of(self.line([0, 1, 1e9], [0, 5, NAN]))

    def test_stands_any_series(self):
        columns = [[], [1], [0, 0, 0], [NAN, NAN], [INF, -INF, 1], [1e308, -1e308], [1e-300, 1e300], [-1, 0, 1e-12],
                   [1e15, 1e15 + 1]]
        for values, log in itertools.product(columns, ("", "xy")):
            html_of(self.line(values, values, log))

    def test_texts_are_never_markup(self):
        plot = page.axes(HOSTILE, HOSTILE, HOSTILE)
        page.curve(plot, [0, 1], [0, 1], HOSTILE.replace("\x01", ""))
        page.goal_line(plot, 0.5, "<b>$x")
        page.legend(plot)
        plot.set(title=page.clean(HOSTILE), xlabel=page.clean(HOSTILE), ylabel=page.clean(HOSTILE))
        markup = html_of(page.Drawing(plot))
        self.assertNotIn("<script", markup)
        self.assertEqual(markup.count("$x_1$</text>"), 4)  # title, axes, legend

    def test_the_same_numbers_give_the_same_bytes_and_names_of_their_own(self):
        one, two, other = self.line([0, 1], [0, 1]), self.line([0, 1], [0, 1]), self.line([0, 1], [1, 0])
        self.assertEqual(one.markup, two.markup)
        html_of(one, other)

    def test_follows_the_pages_colours(self):
        markup = str(self.line([0, 1], [0, 1]).markup)
        self.assertIn("currentColor", markup)
        self.assertNotIn(page.INK, markup)

    def test_a_hundred_thousand_points_stay_small(self):
        x = range(100000)
        self.assertLess(len(self.line(x, [math.sin(1e-4 * k) for k in x]).markup), 60000)

    def test_what_is_wider_than_a_phone_is_marked(self):
        self.assertEqual([self.line([0, 1], [0, 1], width=width).wide for width in (480, 640)], [False, True])

    def test_every_decade_of_a_logarithmic_axis_has_its_number(self):
        markup = str(self.line([0.5, 2000], [1, 1], "x").markup)
        for number in ("1", "10", "100", "1000"):
            self.assertIn(f">{number}</text>", markup)

    def test_a_map_has_one_scale_for_both_axes_whatever_its_ranges(self):
        for low, high in ((0.0, 1e-3), (-1e6, 1.0), (5, 1e6)):
            plot = page.map_axes("map", (low, low + high), (1, 0))
            self.assertEqual(plot.get_aspect(), 1)
            html_of(page.Drawing(plot))

    def test_heat_maps_leave_out_what_is_not_known(self):
        for values in ([1, 2, NAN, 4, 5, 6], [NAN] * 6, [0] * 6, [INF, 1, 2, 3, 4, 5]):
            html_of(page.Drawing(page.heat_map("heat", "mm", (640, 480), 3, values)))
        self.assertEqual(titles(str(page.Drawing(page.heat_map("heat", "mm", (64, 48), 3, [0] * 6)).markup)), ["heat"])


if __name__ == "__main__":
    unittest.main()
