#include "tests/bench/accuracy_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/comparison/comparison_statistics.hpp"
#include "app/report/page.hpp"
#include "app/report/svg_grid.hpp"
#include "app/report/svg_plot.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/statistics.hpp"

namespace ballservo::bench {
namespace {

std::string figure(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}

bool has_covariance(AccuracyMethod method) {
  return method == AccuracyMethod::sphere || method == AccuracyMethod::paper;
}

std::vector<std::string> cells(const ConditionScores& scores, AccuracyMethod method) {
  const MethodSummary s = summarize(scores, method);
  const bool covariance = has_covariance(method);
  return {method == AccuracyMethod::sphere ? scores.condition->name : "",
          accuracy_method_name(method),
          s.balls > 0 ? fmt::format("{}/{}", s.found, s.balls) : fmt::format("-/{}", s.frames),
          std::to_string(s.false_balls),
          figure(s.center_median_px, 3),
          figure(s.radius_median_px, 3),
          figure(s.position_median_mm, 2),
          figure(s.position_p90_mm, 2),
          figure(s.position_rms_mm, 2),
          figure(s.bound_rms_mm, 2),
          figure(s.rms_over_bound, 1),
          covariance ? figure(s.mean_nees, 2) : "",
          covariance ? figure(100 * s.within_95, 1) : ""};
}

std::vector<std::string> headings() {
  return {"condition", "method", "found",    "false",     "centre px", "radius px", "3-D median mm",
          "90 % mm",   "RMS mm", "bound mm", "RMS/bound", "mean NEES", "% in 95 %"};
}

std::string line(const std::vector<std::string>& texts) {
  constexpr std::array<int, 13> widths{18, 15, 9, 6, 10, 10, 14, 9, 9, 9, 10, 10, 10};
  std::string text;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    text += i < 2 ? fmt::format("{:<{}}", texts[i], widths[i]) : fmt::format("{:>{}}", texts[i], widths[i]);
  }
  return text + "\n";
}

struct SweepAxis {
  std::string name, label;
  bool log = false;
};

const std::vector<SweepAxis>& sweep_axes() {
  static const std::vector<SweepAxis> axes{{"distance_m", "distance (m)", true},
                                           {"hidden", "hidden part of the outline's area"},
                                           {"blur_px", "blur, sigma (px)"},
                                           {"noise", "noise, sigma (grey levels)", true},
                                           {"angle_deg", "angle off the axis (deg), f = 500 px"}};
  return axes;
}

// Half of the errors of an estimator that attains the bound are smaller than this: they are of the depth,
// nearly all.
PlotSeries bound_curve(const std::vector<ConditionScores>& all, const std::string& sweep) {
  constexpr double median_of_normal = 0.6745;
  PlotSeries curve;
  curve.name = "Cramer-Rao bound";
  curve.dashed = true;
  curve.color = PlotColor::text();
  for (const ConditionScores& scores : all) {
    if (scores.condition->sweep != sweep) continue;
    std::vector<double> bounds_m;
    std::copy_if(scores.bounds_m.begin(), scores.bounds_m.end(), std::back_inserter(bounds_m),
                 [](double bound_m) { return std::isfinite(bound_m); });
    curve.x.push_back(scores.condition->sweep_value);
    curve.y.push_back(1000 * median_of_normal * median(bounds_m));
  }
  return curve;
}

// What `value` says of each method's frames, over a sweep.
template <class Value>
std::vector<PlotSeries> method_curves(const std::vector<ConditionScores>& all, const std::string& sweep,
                                      const Value& value) {
  std::vector<PlotSeries> series;
  for (const AccuracyMethod method : all_accuracy_methods) {
    PlotSeries curve;
    curve.name = accuracy_method_name(method);
    curve.style = SeriesStyle::line_and_points;
    for (const ConditionScores& scores : all) {
      if (scores.condition->sweep != sweep) continue;
      curve.x.push_back(scores.condition->sweep_value);
      curve.y.push_back(value(summarize(scores, method)));
    }
    series.push_back(std::move(curve));
  }
  return series;
}

constexpr int plot_width_px = 460;

Svg error_plot(const std::vector<ConditionScores>& all, const SweepAxis& axis) {
  std::vector<PlotSeries> series =
      method_curves(all, axis.name, [](const MethodSummary& s) { return s.position_median_mm; });
  series.push_back(bound_curve(all, axis.name));
  PlotOptions options;
  options.x = {axis.label, axis.log, {}, {}};
  options.y = {"3-D error where found, median (mm)", true, {}, {}};
  options.width_px = plot_width_px;
  return line_plot(series, options);
}

Svg found_plot(const std::vector<ConditionScores>& all, const SweepAxis& axis) {
  PlotOptions options;
  options.x = {axis.label, axis.log, {}, {}};
  options.y = {"found, part of the frames", false, 0.0, 1.05};
  options.width_px = plot_width_px;
  return line_plot(
      method_curves(all, axis.name, [](const MethodSummary& s) { return 1.0 * s.found / s.balls; }), options);
}

std::vector<Svg> sweep_plots(const std::vector<ConditionScores>& all) {
  std::vector<Svg> plots;
  for (const SweepAxis& axis : sweep_axes()) {
    const bool ran = std::any_of(all.begin(), all.end(), [&](const ConditionScores& scores) {
      return scores.condition->sweep == axis.name;
    });
    if (!ran) continue;
    plots.push_back(error_plot(all, axis));
    if (axis.name == "hidden") plots.push_back(found_plot(all, axis));
  }
  return plots;
}

void add_sweeps(Page& page, const std::vector<ConditionScores>& all) {
  std::vector<PageFigure> figures;
  for (const Svg& plot : sweep_plots(all)) figures.push_back(drawing(plot, ""));
  if (figures.empty()) return;
  page.heading("Error against distance, occlusion, blur, noise, angle");
  page.paragraph("The bound is drawn where half of the errors of an estimator that attains it would lie.");
  page.figures(figures);
}

void add_pictures(Page& page, const std::vector<ConditionScores>& all) {
  std::vector<PageFigure> figures;
  for (const ConditionScores& scores : all) {
    if (scores.condition->sweep.empty())
      figures.push_back(photo(scores.example, scores.condition->name + ": " + scores.condition->words));
  }
  if (!figures.empty()) {
    page.heading("The pictures");
    page.paragraph("The first frame of each condition, with what was found in it.");
    page.figures(figures);
  }
  page.heading("What went wrong");
  page.paragraph(
      "The first frames of each condition in which the ball was missed or something else taken for one.");
  for (const ConditionScores& scores : all) {
    if (scores.failures.empty()) continue;
    page.begin_details(scores.condition->name);
    std::vector<PageFigure> wrong;
    for (const auto& [index, picture] : scores.failures)
      wrong.push_back(photo(picture, fmt::format("frame {}", index)));
    page.figures(wrong);
    page.end_details();
  }
}

}  // namespace

std::string accuracy_table_heading() { return line(headings()); }

std::string accuracy_table(const ConditionScores& scores) {
  std::string text;
  for (const AccuracyMethod method : all_accuracy_methods) text += line(cells(scores, method));
  return text;
}

std::string accuracy_csv(const std::vector<ConditionScores>& all) {
  std::string csv =
      "condition,method,frames,balls,found,false,center_median_px,radius_median_px,position_median_mm,"
      "position_p90_mm,position_rms_mm,mean_nees,within_95,bound_rms_mm,rms_over_bound\n";
  for (const ConditionScores& scores : all) {
    for (const AccuracyMethod method : all_accuracy_methods) {
      const MethodSummary s = summarize(scores, method);
      csv += fmt::format("{},{},{},{},{},{}", scores.condition->name, accuracy_method_name(method), s.frames,
                         s.balls, s.found, s.false_balls);
      const bool covariance = has_covariance(method);
      for (const double value :
           {s.center_median_px, s.radius_median_px, s.position_median_mm, s.position_p90_mm,
            s.position_rms_mm, covariance ? s.mean_nees : std::nan(""),
            covariance ? s.within_95 : std::nan(""), s.bound_rms_mm, s.rms_over_bound}) {
        csv += std::isfinite(value) ? ',' + number_text(value) : ",";
      }
      csv += '\n';
    }
  }
  return csv;
}

std::string accuracy_frames_csv(const std::vector<ConditionScores>& all) {
  std::string csv =
      "condition,frame,method,found,false,center_error_px,radius_error_px,ex_m,ey_m,ez_m,nees,sigma_depth_m,"
      "quality,residual_px,blur_px,arc,bound_m\n";
  for (const ConditionScores& scores : all) {
    for (std::size_t k = 0; k < scores.frames.size(); ++k) {
      for (const AccuracyMethod method : all_accuracy_methods) {
        const FrameScore& s = scores.frames[k][static_cast<std::size_t>(method)];
        csv += fmt::format("{},{},{},{},{}", scores.condition->name, k, accuracy_method_name(method),
                           s.found ? 1 : 0, s.false_balls);
        for (const double value : {s.center_px, s.radius_px, s.error_C.x(), s.error_C.y(), s.error_C.z(),
                                   s.nees, s.sigma_depth_m, s.quality, s.residual_px, s.blur_px, s.arc}) {
          csv += s.found ? ',' + number_text(value) : ",";
        }
        csv += std::isfinite(scores.bounds_m[k]) ? ',' + number_text(scores.bounds_m[k]) : ",";
        csv += '\n';
      }
    }
  }
  return csv;
}

std::string accuracy_sweeps_svg(const std::vector<ConditionScores>& all) {
  const std::vector<Svg> plots = sweep_plots(all);
  if (plots.empty()) return "";
  return svg_grid(plots, 2, "3-D error against distance, occlusion, blur, noise, angle").standalone();
}

std::string accuracy_report_html(const std::vector<ConditionScores>& all, const std::string& command) {
  Page page("How accurate", "Ours and the peers on the same frames, a new scene each");
  page.paragraph(
      "A ball of 7 cm in pictures of 640x480. Found: centre within 0.2 r and radius within 20 %; the nearest "
      "candidate counts, for ours and the peers alike, everything else that is reported is false. Errors are "
      "over the frames in which "
      "the ball was found. The peers are told the radius to within a half (hough_gradient) or the hue "
      "(hsv_contour); their circles become positions by the paper's formula. NEES: squared Mahalanobis error "
      "of the position, 3 where the covariance is true, below 7.81 in 95 % of the frames. Bound: Cramer and "
      "Rao's, the RMS of the least error that an unbiased estimator can have in the frames in which the "
      "method "
      "found the ball, which is told neither the blur nor, along the outline, the background, the contrast "
      "of "
      "each channel and the shading of the limb.");
  page.code(command);
  PageTable table;
  table.heading = headings();
  table.number_columns.assign(table.heading.size(), true);
  table.number_columns[0] = table.number_columns[1] = false;
  for (const ConditionScores& scores : all) {
    if (!scores.condition->sweep.empty()) continue;
    for (const AccuracyMethod method : all_accuracy_methods) table.rows.push_back(cells(scores, method));
  }
  if (!table.rows.empty()) page.table(table);
  add_sweeps(page, all);
  add_pictures(page, all);
  return page.html();
}

}  // namespace ballservo::bench
