#include "app/offline/comparison_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "app/offline/comparison_statistics.hpp"
#include "app/report/page.hpp"
#include "app/report/svg_plot.hpp"

namespace ballservo {
namespace {

std::string figure(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}

// Enough decimals to tell small values from zero.
std::string small_figure(double value) {
  if (!std::isfinite(value)) return "-";
  if (value != 0 && std::abs(value) < 5e-5) return "under 0.0001";
  return std::abs(value) >= 1 ? fmt::format("{:.2f}", value) : fmt::format("{:.4f}", value);
}

std::string in_words(const ComparisonCondition& condition) {
  const auto outline = project_sphere(condition.camera, {0, 0, condition.depth_m}, condition.radius_m());
  std::string text =
      fmt::format("{} ball of {:g} mm, {:.0f} px across, Z = {:g} m, f = {:.0f} px", condition.ball_color,
                  1000 * condition.diameter_m, outline ? 2 * outline->radius_px : 0.0, condition.depth_m,
                  condition.camera.focal_px());
  if (condition.off_axis_rad > 0)
    text += fmt::format(", {:.0f} deg off the axis", condition.off_axis_rad * 57.2957795);
  if (condition.occlusion > 0) text += fmt::format(", {:.0f} % hidden", 100 * condition.occlusion);
  text +=
      fmt::format(", noise sigma {:g}, blur {:g} px", condition.sensor.read_noise, condition.sensor.blur_px);
  return text;
}

// The first frame around the ball, enlarged, with the true outline drawn thinly.
cv::Mat example_picture(const ConditionResult& condition) {
  const BallTruth& truth = condition.frames.front().truth;
  cv::Mat picture = condition.example;
  if (!truth.outline) return picture;
  const double reach = 2.2 * truth.outline->radius_px;
  const cv::Rect wanted(static_cast<int>(truth.outline->center_px.x() - reach),
                        static_cast<int>(truth.outline->center_px.y() - reach), static_cast<int>(2 * reach),
                        static_cast<int>(2 * reach));
  const cv::Rect shown = wanted & cv::Rect({0, 0}, picture.size());
  if (shown.empty()) return picture;
  cv::Mat enlarged;
  cv::resize(picture(shown), enlarged, {220, 220 * shown.height / shown.width}, 0, 0, cv::INTER_NEAREST);
  return enlarged;
}

Svg error_plot(const Comparison& comparison) {
  std::vector<std::string> names;
  std::vector<BarGroup> groups;
  for (const ConditionResult& condition : comparison.conditions) names.push_back(condition.name);
  for (std::size_t m = 0; m < comparison.methods.size(); ++m) {
    BarGroup group{std::string(fit_method_name(comparison.methods[m])), {}};
    for (const ConditionResult& condition : comparison.conditions) {
      group.values.push_back(method_statistics(condition, m).position_median_mm);
    }
    groups.push_back(std::move(group));
  }
  PlotOptions options;
  options.title = "Error of the ball's centre in 3-D, median";
  options.y = {"error (mm), logarithmic", true, {}, {}};
  options.width_px = std::clamp(110 * static_cast<int>(names.size()), 640, 1040);
  options.height_px = 380;
  return bar_plot(names, groups, options);
}

// The part of the frames (%) in which the two fits lie at most so far apart.
Svg difference_plot(const Comparison& comparison, const MethodPair& pair) {
  std::vector<PlotSeries> series;
  for (const ConditionResult& condition : comparison.conditions) {
    std::vector<double> differences = pair_differences(comparison, condition, pair).center_px;
    std::sort(differences.begin(), differences.end());
    PlotSeries curve;
    curve.name = condition.name;
    curve.style = SeriesStyle::steps;
    for (std::size_t k = 0; k < differences.size(); ++k) {
      // Below a ten-thousandth of a pixel two fits are the same for any purpose.
      curve.x.push_back(std::max(differences[k], 1e-4));
      curve.y.push_back(100.0 * static_cast<double>(k + 1) / static_cast<double>(differences.size()));
    }
    series.push_back(std::move(curve));
  }
  PlotOptions options;
  options.title = fmt::format("{} against {}", fit_method_name(pair.a), fit_method_name(pair.b));
  options.x = {"distance between the two centres (px), logarithmic", true, 1e-4, {}};
  options.y = {"frames at most so far apart (%)", false, 0.0, 100.0};
  options.lines = {{true, 0.05, "0.05 px"}};
  options.height_px = 380;
  return line_plot(series, options);
}

void add_verdict(Page& page, const Comparison& comparison) {
  for (const MethodPair& pair : one_step_pairs(comparison.methods)) {
    PairDifferences all;
    for (const ConditionResult& condition : comparison.conditions)
      all.add(pair_differences(comparison, condition, pair));
    const PairStatistics s = all.statistics();
    if (s.frames == 0) continue;
    page.note(fmt::format(
        "{} against {}: over all {} frames the two centres lie {} px apart in the median, {} px at most; "
        "that is {} mm in "
        "3-D in the median, {} mm at most.",
        fit_method_name(pair.a), fit_method_name(pair.b), s.frames, small_figure(s.center_median_px),
        small_figure(s.center_max_px), small_figure(s.position_median_mm), small_figure(s.position_max_mm)));
  }
}

PageTable error_table(const Comparison& comparison) {
  PageTable table;
  table.heading = {"condition",     "method",        "found",       "centre RMS px", "radius bias px",
                   "radius RMS px", "3-D median mm", "3-D 90 % mm", "depth bias mm", "sideways bias mm"};
  table.number_columns = {false, false, true, true, true, true, true, true, true, true};
  for (const ConditionResult& condition : comparison.conditions) {
    for (std::size_t m = 0; m < comparison.methods.size(); ++m) {
      const MethodStatistics s = method_statistics(condition, m);
      table.rows.push_back({m == 0 ? condition.name : "", std::string(fit_method_name(comparison.methods[m])),
                            fmt::format("{} of {}", s.found, s.frames), figure(s.center_rms_px, 3),
                            figure(s.radius_bias_px, 3), figure(s.radius_rms_px, 3),
                            figure(s.position_median_mm, 2), figure(s.position_p90_mm, 2),
                            figure(s.depth_bias_mm, 2), figure(s.lateral_bias_mm, 2)});
    }
  }
  return table;
}

PageTable pair_table(const Comparison& comparison) {
  PageTable table;
  table.heading = {"condition",     "one step",         "converged",     "frames",        "centre median px",
                   "centre max px", "radius median px", "radius max px", "3-D median mm", "3-D max mm"};
  table.number_columns = {false, false, false, true, true, true, true, true, true, true};
  for (const ConditionResult& condition : comparison.conditions) {
    bool first = true;
    for (const MethodPair& pair : one_step_pairs(comparison.methods)) {
      const PairStatistics s = pair_differences(comparison, condition, pair).statistics();
      table.rows.push_back({first ? condition.name : "", std::string(fit_method_name(pair.a)),
                            std::string(fit_method_name(pair.b)), std::to_string(s.frames),
                            small_figure(s.center_median_px), small_figure(s.center_max_px),
                            small_figure(s.radius_median_px), small_figure(s.radius_max_px),
                            small_figure(s.position_median_mm), small_figure(s.position_max_mm)});
      first = false;
    }
  }
  return table;
}

}  // namespace

std::string comparison_report_html(const Comparison& comparison, const ComparisonPlan& plan,
                                   const std::string& plan_name) {
  Page page("Is one step enough?", "Every estimator of the ball on the same pixels: " + plan_name);
  page.paragraph(
      "On line, the ball's outline is refined by exactly one Gauss-Newton step. Here the same residuals on "
      "the same points "
      "with the same weights are also handed to Ceres, a general solver that goes on until nothing improves. "
      "Where the two "
      "agree, one step is enough, and what error is left comes from the pixels and the model, not from "
      "stopping early.");
  add_verdict(page, comparison);

  page.heading("What was shown");
  page.paragraph(
      "Each frame is rendered with exact truth: a shaded ball in front of a background, a light and clutter "
      "of its own. "
      "The ball's colour was learnt from three rendered pictures, as a user would.");
  std::vector<PageFigure> examples;
  for (std::size_t c = 0; c < comparison.conditions.size() && c < 24; ++c) {
    const std::string caption = comparison.conditions[c].name + ": " + in_words(plan.conditions[c]);
    examples.push_back(photo(example_picture(comparison.conditions[c]), caption, PictureFormat::png));
  }
  page.figures(examples, true);

  page.heading("How far from the truth");
  page.figure(drawing(error_plot(comparison),
                      "Shorter is better; one grid line to the next is a factor. At 1 m and f = 857 px, an "
                      "error of one pixel "
                      "in the radius is 33 mm in depth."));
  page.bullets(
      {"vote: the circle that random triples of boundary pixels agree on, before any refinement.",
       "paper: a circle fitted to the strongest gradient pixels of a ring, and the paper's formula for its "
       "position, which is exact on the optical axis only.",
       "sphere: edge points to a fraction of a pixel, and the exact cone of rays that touch a ball, right "
       "wherever the ball stands.",
       "one_step is what runs on line; converged is Ceres on the same points."});
  page.table(error_table(comparison));
  page.paragraph(
      "Found: an answer whose centre lies within half the ball's radius of the truth. Bias: the mean error "
      "with its sign; a "
      "radius that is read too large puts the ball too near (negative depth bias). Sideways: away from the "
      "optical axis.");

  const std::vector<MethodPair> pairs = one_step_pairs(comparison.methods);
  if (!pairs.empty()) {
    page.heading("How far one step is from the converged fit");
    std::vector<PageFigure> figures;
    for (const MethodPair& pair : pairs) {
      figures.push_back(
          drawing(difference_plot(comparison, pair),
                  "A curve that rises early means that one step and the converged fit agree in nearly every "
                  "frame. Differences below 0.0001 px are drawn there."));
    }
    page.figures(figures);
    page.table(pair_table(comparison));
    page.paragraph(
        "When is one step enough? A Gauss-Newton step is exact where the residual is linear. Moving the "
        "circle's centre by "
        "d bends its distance to a point by about d squared over twice the radius, so a start that is a "
        "pixel off leaves "
        "about 1/60 px for a ball of 60 px; a worse start, a smaller ball, or points on one side only leave "
        "more.");
  }

  page.begin_details("The plan, as it was read");
  page.code(plan.resolved_json);
  page.end_details();
  page.paragraph("The figures of every frame are in fits.csv beside this page, times in timing.csv.");
  return page.html();
}

}  // namespace ballservo
