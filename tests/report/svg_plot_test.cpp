#include "app/report/svg_plot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "app/report/svg_canvas.hpp"
#include "app/report/svg_grid.hpp"
#include "app/report/ticks.hpp"
#include "tests/report/markup_check.hpp"

namespace ballservo {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

// The drawing without what its texts say: only what a viewer reads as numbers.
std::string without_texts(std::string markup) {
  for (std::size_t at = 0; (at = markup.find("<text", at)) != std::string::npos;) {
    markup.erase(at, markup.find("</text>", at) + 7 - at);
  }
  return markup;
}

void expect_sound(const Svg& svg) {
  EXPECT_EQ(test::markup_fault(svg.markup()), "");
  EXPECT_EQ(test::markup_fault(svg.standalone()), "");
  const std::string shapes = without_texts(svg.markup());
  for (const std::string_view word : {"nan", "inf", "e+", "e-0"}) {
    EXPECT_EQ(test::occurrences(shapes, word), 0) << word << "\n" << shapes;
  }
  EXPECT_EQ(test::occurrences(svg.markup(), "http"), 0);
}

PlotOptions log_options() {
  PlotOptions options;
  options.x.log = options.y.log = true;
  return options;
}

TEST(LinePlot, GapsBreakTheLine) {
  const Svg whole = line_plot({{"", {0, 1, 2, 3, 4}, {0, 1, 0, 1, 0}}}, {});
  const Svg broken = line_plot({{"", {0, 1, 2, 3, 4}, {0, 1, nan, 1, 0}}}, {});
  EXPECT_EQ(test::occurrences(whole.markup(), "<polyline"), 1);
  EXPECT_EQ(test::occurrences(broken.markup(), "<polyline"), 2);
  expect_sound(broken);
}

TEST(LinePlot, AGapDoesNotMoveTheAxes) {
  const std::vector<double> x{0, 1, 2}, y{0, 5, 10};
  const Svg plain = line_plot({{"", x, y}}, {});
  std::vector<double> longer_x = x, longer_y = y;
  longer_x.push_back(1e9);
  longer_y.push_back(nan);
  EXPECT_EQ(line_plot({{"", longer_x, longer_y}}, {}).markup(), plain.markup());
}

TEST(LinePlot, StandsAnySeries) {
  const std::vector<std::vector<double>> columns{{},
                                                 {1},
                                                 {0, 0, 0},
                                                 {nan, nan},
                                                 {inf, -inf, 1},
                                                 {1e308, -1e308},
                                                 {5, 5, 5},
                                                 {1e-300, 1e300},
                                                 {-1, 0, 1e-12},
                                                 {1e15, 1e15 + 1}};
  for (const std::vector<double>& x : columns) {
    for (const std::vector<double>& y : columns) {
      for (const SeriesStyle style :
           {SeriesStyle::line, SeriesStyle::points, SeriesStyle::line_and_points, SeriesStyle::steps}) {
        PlotSeries series{"s", x, y};
        series.style = style;
        PlotOptions options;
        options.lines = {{true, nan, "v"}, {false, inf, "h"}};
        expect_sound(line_plot({series, {"t", {1, 2}, {3, 4}}}, options));
        expect_sound(line_plot({series}, log_options()));
        options.equal_aspect = true;
        options.y_down = true;
        expect_sound(line_plot({series}, options));
      }
    }
  }
}

TEST(LinePlot, UselessFixedEndsAreReplaced) {
  PlotOptions options;
  options.x.low = 5;
  options.x.high = -5;
  options.y.low = nan;
  const Svg plain = line_plot({{"", {0, 1}, {0, 1}}}, {});
  EXPECT_EQ(line_plot({{"", {0, 1}, {0, 1}}}, options).markup(), plain.markup());
}

TEST(LinePlot, AHundredThousandPointsStaySmall) {
  std::vector<double> x, y;
  for (int i = 0; i < 100000; ++i) {
    x.push_back(i);
    y.push_back(std::sin(i * 1e-4));
  }
  EXPECT_LT(line_plot({{"", x, y}}, {}).markup().size(), 60000u);
}

TEST(HistogramPlot, StandsAnyValues) {
  for (const int bins : {-3, 0, 1, 20, 1 << 30}) {
    expect_sound(histogram_plot({}, bins, {}));
    expect_sound(histogram_plot({2, 2, 2}, bins, {}));
    expect_sound(histogram_plot({nan, inf, 1, 2, -1e308}, bins, {}));
    expect_sound(histogram_plot({1, 2, 3}, bins, log_options()));
  }
}

TEST(BarPlot, DrawsOneBarForEachFiniteValue) {
  const auto bars = [](const Svg& svg) { return test::occurrences(svg.markup(), "<rect"); };
  const int legend = 2;
  EXPECT_EQ(bars(bar_plot({"a", "b"}, {{"g", {1, 2}}, {"h", {3, nan}}}, {})), 3 + legend);
  EXPECT_EQ(bars(bar_plot({"a", "b"}, {{"g", {1, 0}}, {"h", {3, -1}}}, log_options())), 2 + legend);
  expect_sound(bar_plot({}, {}, {}));
  expect_sound(bar_plot({"a"}, {{"g", {}}}, log_options()));
}

TEST(LinePlot, LegendShowsPointsAsPoints) {
  PlotSeries cloud{"cloud", {0, 1}, {0, 1}};
  cloud.style = SeriesStyle::points;
  const Svg svg = line_plot({cloud}, {});
  EXPECT_EQ(test::occurrences(svg.markup(), "<circle"), 3);
  expect_sound(svg);
}

TEST(BarPlot, LongNamesAreBrokenIntoLinesBelowTheirBars) {
  PlotOptions options;
  options.width_px = 300;
  const auto texts = [&](const std::string& name) {
    const Svg svg = bar_plot({name, "b"}, {{"", {1, 2}}}, options);
    expect_sound(svg);
    return test::occurrences(svg.markup(), "<text");
  };
  const int short_name = texts("a_name");
  EXPECT_EQ(texts("a_name_that_is_far_too_long_for_its_place"), short_name + 2);
  EXPECT_EQ(texts(std::string(200, 'a')), short_name);  // nowhere to break it
  texts("");
  texts("___ _");
}

TEST(SvgCanvas, LeavesOutWhatIsNotFinite) {
  SvgCanvas canvas({});
  const std::string empty = canvas.svg().markup();
  const SvgStyle style;
  canvas.polyline({{nan, 0}, {inf, 1}}, style);
  canvas.polygon({{0, 0}, {1, nan}, {1, 1}}, style);
  canvas.circle({0, inf}, 1, style);
  canvas.circle({0, 0}, nan, style);
  canvas.ellipse({0, 0}, 1, -1, 0, style);
  canvas.arrow({0, 0}, {nan, 1}, style);
  canvas.arrow({0.5, 0.5}, {0.5, 0.5}, style);
  canvas.dot({nan, nan}, 3, PlotColor::series(0));
  canvas.text({nan, 0}, "x");
  EXPECT_EQ(canvas.svg().markup(), empty);
}

TEST(SvgCanvas, OneScaleForBothAxesAndYWhereItIsWanted) {
  SvgCanvasOptions options;
  options.axes = false;
  options.width_px = 200;
  options.x_high = 2;
  options.y_high = 1;
  for (const bool down : {false, true}) {
    options.y_down = down;
    SvgCanvas canvas(options);
    EXPECT_DOUBLE_EQ(canvas.scale(), 100);
    canvas.circle({0.5, 0.25}, 0.1, {});
    const std::string expected = down ? "cx=\"50\" cy=\"25\" r=\"10\"" : "cx=\"50\" cy=\"75\" r=\"10\"";
    EXPECT_NE(canvas.svg().markup().find(expected), std::string::npos) << canvas.svg().markup();
  }
}

TEST(SvgCanvas, StandsAnyRange) {
  for (const double low : {0.0, nan, -inf, 1e308, -1e308}) {
    for (const double high : {0.0, nan, inf, 1e308, 1.0}) {
      SvgCanvasOptions options;
      options.x_low = low;
      options.x_high = high;
      options.y_low = high;
      options.y_high = low;
      SvgCanvas canvas(options);
      canvas.circle({0, 0}, 1, {});
      expect_sound(canvas.svg());
    }
  }
}

TEST(Ticks, AreRoundNumbersWithinTheRange) {
  for (const auto& [low, high] : std::vector<std::pair<double, double>>{
           {0, 1}, {-3.3, 7.1}, {1e-9, 3e-9}, {1e8, 1.0003e8}, {-1e-3, 1e5}, {0.999, 1.001}}) {
    const std::vector<Tick> ticks = linear_ticks(low, high, 6);
    ASSERT_GE(ticks.size(), 2u) << low << " " << high;
    EXPECT_LE(ticks.size(), 13u);
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      EXPECT_GE(ticks[i].value, low - 1e-9 * (high - low));
      EXPECT_LE(ticks[i].value, high + 1e-9 * (high - low));
      if (i > 0) {
        EXPECT_NE(ticks[i].label, ticks[i - 1].label);
      }
      EXPECT_NEAR(std::stod(ticks[i].label), ticks[i].value, 1e-3 * (high - low));
    }
  }
  EXPECT_TRUE(linear_ticks(1, 1, 5).empty());
  EXPECT_TRUE(linear_ticks(nan, 1, 5).empty());
  EXPECT_TRUE(log_ticks(0, 1, 5).empty());
}

TEST(Ticks, LogTicksHoldEveryDecade) {
  const std::vector<Tick> ticks = log_ticks(0.5, 2000, 8);
  int decades = 0;
  for (const Tick& tick : ticks)
    decades += tick.label == "1" || tick.label == "10" || tick.label == "100" || tick.label == "1000";
  EXPECT_EQ(decades, 4);
}

TEST(SvgGrid, HoldsEveryDrawingOnceAndNoneOverlap) {
  PlotOptions wide, tall;
  wide.width_px = 300;
  tall.width_px = 200;
  tall.height_px = 400;
  wide.height_px = 200;
  wide.title = "the wide one";
  tall.title = "the tall one";
  const Svg a = line_plot({}, wide), b = line_plot({}, tall);
  const Svg grid = svg_grid({a, b, a}, 2, "three");
  expect_sound(grid);
  EXPECT_EQ(grid.width_px(), 2 * 300);
  EXPECT_EQ(grid.height_px(), 2 * 400);
  EXPECT_EQ(test::occurrences(grid.markup(), "the wide one"), 2);
  EXPECT_EQ(test::occurrences(grid.markup(), "the tall one"), 1);
  EXPECT_EQ(test::occurrences(grid.markup(), "<svg x=\"300\" y=\"0\" width=\"200\" height=\"400\">"), 1);
  EXPECT_EQ(test::occurrences(grid.markup(), "<svg x=\"0\" y=\"400\" width=\"300\" height=\"200\">"), 1);
  expect_sound(svg_grid({}, 3, "nothing"));
}

}  // namespace
}  // namespace ballservo
