#include "app/report/camera_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "app/report/heat_plot.hpp"
#include "app/report/page.hpp"
#include "app/report/svg_canvas.hpp"
#include "app/report/svg_plot.hpp"
#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/base/statistics.hpp"
#include "calibration/camera/files/camera_covariance.hpp"

namespace ballservo {
namespace {

constexpr double overlay_enlarged = 50;
constexpr double ball_diameter_m = 0.070;

/// Residuals as arrows from each corner found, all boards in one picture.
Svg residual_map(const CameraReportInput& input) {
  const ImageSize size = input.calibration->camera.size();
  double longest_px = 0;
  for (const CornerResiduals& corners : input.calibration->corners)
    for (std::size_t i = 0; i < corners.residuals_px.size(); ++i)
      if (!corners.set_aside[i]) longest_px = std::max(longest_px, corners.residuals_px[i].norm());
  const double scale = arrow_scale_for(longest_px, 0.08 * size.width_px);
  SvgCanvasOptions options;
  options.x_low = -0.5, options.x_high = size.width_px - 0.5;
  options.y_low = -0.5, options.y_high = size.height_px - 0.5;
  options.width_px = 760;
  options.y_down = true;
  options.title = fmt::format("All corners, residuals {:g} times enlarged", scale);
  options.x_label = "u (px)", options.y_label = "v (px)";
  SvgCanvas canvas(options);
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const CornerResiduals& corners = input.calibration->corners[v];
    SvgStyle line;
    line.stroke = PlotColor::series(static_cast<int>(v));
    line.width_px = 1;
    for (std::size_t i = 0; i < corners.residuals_px.size(); ++i) {
      const Eigen::Vector2d& corner = input.views[v].corners_px[i];
      canvas.dot(corner, corners.set_aside[i] ? 4 : 1.6, PlotColor::series(static_cast<int>(v)));
      if (!corners.set_aside[i]) canvas.polyline({corner, corner + scale * corners.residuals_px[i]}, line);
    }
  }
  return canvas.svg();
}

Svg residuals_by_radius(const CameraReportInput& input) {
  const CameraParameters& p = input.calibration->camera.parameters();
  PlotSeries radial{"along the radius", {}, {}, SeriesStyle::points},
      across{"across it", {}, {}, SeriesStyle::points};
  for (PlotSeries* series : {&radial, &across}) series->marker_px = 1.4, series->opacity = 0.55;
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    const CornerResiduals& corners = input.calibration->corners[v];
    for (std::size_t i = 0; i < corners.residuals_px.size(); ++i) {
      const Eigen::Vector2d from_axis = input.views[v].corners_px[i] - Eigen::Vector2d(p.cx_px, p.cy_px);
      if (corners.set_aside[i] || !(from_axis.norm() > 0)) continue;
      const Eigen::Vector2d out = from_axis.normalized(), side(-out.y(), out.x());
      radial.x.push_back(from_axis.norm()), radial.y.push_back(corners.residuals_px[i].dot(out));
      across.x.push_back(from_axis.norm()), across.y.push_back(corners.residuals_px[i].dot(side));
    }
  }
  PlotOptions options;
  options.title = "Residuals by distance from the principal point";
  options.x.label = "distance (px)", options.y.label = "residual (px)";
  options.lines.push_back({false, 0, ""});
  return line_plot({radial, across}, options);
}

std::optional<Svg> ball_heat_map(const BoardCalibration& calibration, double range_m) {
  const auto map =
      ball_sigma_map(calibration.camera, calibration.covariance.parameters, ball_diameter_m, range_m, 21, 15);
  if (!map || !map->worst_mm()) return std::nullopt;
  HeatPlot plot;
  plot.title = fmt::format("A ball at {:g} m: at worst {:.2f} mm", range_m, *map->worst_mm());
  plot.unit = "mm";
  plot.picture = calibration.camera.size();
  plot.columns = map->columns, plot.rows = map->rows;
  std::vector<double> known;
  for (const auto& sigma : map->sigma_mm) {
    plot.values.push_back(sigma.value_or(std::nan("")));
    if (sigma) known.push_back(*sigma);
  }
  // The rim would drown what the rest of the picture has to say.
  plot.high = std::min(*map->worst_mm(), 5 * upper_median(known));
  plot.width_px = 520;
  return heat_plot(plot);
}

std::string millimetres(std::optional<double> sigma_mm) {
  return sigma_mm ? fmt::format("{:.2f} mm (1 sigma)", *sigma_mm) : "-";
}

void add_figures(Page& page, const CameraReportInput& input) {
  const BoardCalibration& result = *input.calibration;
  const auto names = parameter_names(result.camera.parameters().model);
  const Eigen::VectorXd values = parameter_vector(result.camera.parameters());
  page.key_values(
      {{"RMS over the corners", fmt::format("{:.3f} px", result.rms_px)},
       {"RMS on boards held out", pixels_text(result.held_out_rms_px)},
       {"noise of a corner's coordinate", fmt::format("{:.3f} px", result.covariance.noise_px)},
       {"part of the RMS that depends on the place in the picture",
        result.structure_px ? fmt::format("{:.3f} px", *result.structure_px) : "too few boards to tell"},
       {"part of the picture in which corners lie", fmt::format("{:.0f} %", 100 * result.coverage)},
       {"correlation of the focal length with the boards' distance",
        fmt::format("{:.3f}", result.covariance.focal_distance_correlation)},
       {"error at a 70 mm ball at 1 m from the calibration alone, worst place",
        millimetres(result.ball_sigma_mm)},
       {"the same where boards were, typically", millimetres(result.covered_ball_sigma_mm)}});
  PageTable table{{"parameter", "value", "sigma"},
                  {},
                  "lens model " + std::string(lens_model_name(result.camera.parameters().model)),
                  {}};
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    table.rows.push_back({names[i], fmt::format("{:.6g}", values(at)),
                          fmt::format("{:.2g}", std::sqrt(result.covariance.parameters(at, at)))});
  }
  page.table(table);
  if (result.trials.size() < 2) return;
  PageTable trials{{"lens model", "RMS", "on boards held out", ""}, {}, "Models tried", {}};
  for (const ModelTrial& trial : result.trials)
    trials.rows.push_back({std::string(lens_model_name(trial.model)), pixels_text(trial.rms_px),
                           pixels_text(trial.held_out_rms_px),
                           trial.model == result.camera.parameters().model ? "chosen"
                           : trial.usable                                  ? ""
                                          : "not usable over the whole picture"});
  page.table(trials);
}

void add_boards(Page& page, const CameraReportInput& input) {
  page.heading("The boards");
  page.paragraph(
      fmt::format("Corners as found (green, joined in their order by blue lines; red where one was set aside "
                  "as wrong), the first one ringed; red "
                  "lines are the "
                  "residuals, {:g} times enlarged. Residuals that all point one way in a part of a board "
                  "mean a bent board, "
                  "that grow outwards in all boards a lens model that does not suffice.",
                  overlay_enlarged));
  std::vector<PageFigure> figures;
  for (std::size_t v = 0; v < input.views.size(); ++v) {
    figures.push_back(photo(input.overlays[v], fmt::format("{}: RMS {:.3f} px", input.views[v].name,
                                                           input.calibration->corners[v].rms_px())));
  }
  page.figures(figures);
}

}  // namespace

cv::Mat board_overlay(const cv::Mat& picture, const BoardView& view, const CornerResiduals& corners) {
  constexpr int shift = 4, one_px = 1 << shift;
  cv::Mat image = picture.clone();
  const auto at = [](const Eigen::Vector2d& p) {
    return cv::Point(static_cast<int>(std::lround(p.x() * one_px)),
                     static_cast<int>(std::lround(p.y() * one_px)));
  };
  const int thick = std::max(1, image.cols / 640);
  for (std::size_t i = 0; i < view.size(); ++i) {
    const Eigen::Vector2d& corner = view.corners_px[i];
    if (i > 0)
      cv::line(image, at(view.corners_px[i - 1]), at(corner), cv::Scalar(200, 160, 0), thick, cv::LINE_AA,
               shift);
    cv::circle(image, at(corner), 4 * thick * one_px,
               corners.set_aside[i] ? cv::Scalar(0, 0, 255) : cv::Scalar(0, 220, 0), thick, cv::LINE_AA,
               shift);
    // A corner far off would need an arrow beyond any picture.
    const Eigen::Vector2d tip =
        corner + (overlay_enlarged * corners.residuals_px[i]).cwiseMax(-2000).cwiseMin(2000);
    cv::line(image, at(corner), at(tip), cv::Scalar(0, 0, 255), thick, cv::LINE_AA, shift);
  }
  cv::circle(image, at(view.corners_px.front()), 8 * thick * one_px, cv::Scalar(0, 220, 220), 2 * thick,
             cv::LINE_AA, shift);
  return image;
}

std::string pixels_text(double value_px) {
  return std::isfinite(value_px) ? fmt::format("{:.3f} px", value_px) : "unknown";
}

std::vector<std::string> calibration_advice(const BoardCalibration& calibration) {
  std::vector<std::string> advice;
  constexpr double wide_enough = 0.7, tight_correlation = 0.99, good_ball_mm = 1;
  constexpr std::size_t enough_boards = 10;
  if (calibration.corners.size() < enough_boards)
    advice.push_back(fmt::format("Take more pictures: {} boards were used, {} or more settle a lens.",
                                 calibration.corners.size(), enough_boards));
  if (calibration.covariance.focal_distance_correlation > tight_correlation)
    advice.push_back(
        "Tilt the board more (20 to 40 degrees, to different sides) and vary its distance: these pictures "
        "hardly "
        "tell a longer lens from a farther board.");
  const double covered_mm = calibration.covered_ball_sigma_mm.value_or(0);
  if (covered_mm > good_ball_mm)
    advice.push_back(fmt::format(
        "Even where boards were, this calibration alone typically places a ball at 1 m to {:.1f} mm only; "
        "four times as many "
        "pictures halve that.",
        covered_mm));
  if (calibration.ball_sigma_mm && *calibration.ball_sigma_mm > good_ball_mm &&
      *calibration.ball_sigma_mm > 2 * covered_mm)
    advice.push_back(
        fmt::format("Towards the picture's rim the lens is extrapolated: there a ball at 1 m is uncertain by "
                    "up to {:.1f} mm. "
                    "Let the board reach into every corner of the picture in some pictures; parts of a "
                    "chessboard count too.",
                    *calibration.ball_sigma_mm));
  else if (calibration.coverage < wide_enough)
    advice.push_back(
        "Bring the board to the parts of the picture where no corner lies (see the map of all corners): what "
        "the "
        "lens does there is extrapolated.");
  if (std::isfinite(calibration.held_out_rms_px) && calibration.held_out_rms_px > 1.3 * calibration.rms_px)
    advice.push_back(
        "Boards that were held out fit clearly worse than those used: the pictures are too few for this lens "
        "model.");
  if (advice.empty())
    advice.push_back(calibration.warnings.empty() ? "Nothing: this calibration can be used as it is."
                                                  : "See to the warnings.");
  return advice;
}

std::string camera_report_html(const CameraReportInput& input) {
  const BoardCalibration& result = *input.calibration;
  const ImageSize size = result.camera.size();
  Page page("Camera calibration", fmt::format("{} of {} pictures of {} x {} pixels", input.views.size(),
                                              input.looked_at, size.width_px, size.height_px));
  if (result.ball_sigma_mm)
    page.note(
        fmt::format("A 70 mm ball at 1 m is placed to {:.2f} mm (1 sigma, where it is worst in the picture) "
                    "as far as this "
                    "calibration is concerned.",
                    *result.ball_sigma_mm));
  add_figures(page, input);
  if (!result.warnings.empty()) {
    page.heading("Warnings");
    page.bullets(result.warnings);
  }
  page.heading("What to do next");
  page.bullets(calibration_advice(result));
  page.heading("Where the corners lie, and what is left over");
  page.figures(
      {drawing(residual_map(input),
               "Every board has its colour. Each line leads from a corner found towards where the camera "
               "expects it."),
       drawing(residuals_by_radius(input),
               "A cloud around zero at every distance: the lens model suffices. A bend along the radius: "
               "it does not.")});
  std::vector<PageFigure> maps;
  for (const double range_m : {0.5, 1.0, 2.0})
    if (const auto map = ball_heat_map(result, range_m))
      maps.push_back(
          drawing(*map, fmt::format("1-sigma error of a 70 mm ball's centre at {:g} m that the uncertainty "
                                    "of this camera's parameters causes, by the ball's place in the "
                                    "picture; "
                                    "yellow is the scale's end and all above it.",
                                    range_m)));
  if (!maps.empty()) {
    page.heading("In millimetres at the ball");
    page.figures(maps);
  }
  add_boards(page, input);
  if (!input.remarks.empty()) page.bullets(input.remarks);
  if (!input.rejected.empty()) {
    page.heading("Pictures not used");
    PageTable table{{"picture", "reason"}, {}, "", {false, false}};
    for (const auto& [name, reason] : input.rejected) table.rows.push_back({name, reason});
    page.table(table);
  }
  return page.html();
}

}  // namespace ballservo
