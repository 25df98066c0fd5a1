#include "app/report/camera_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "app/experiment/run_log.hpp"
#include "app/io/interrupt.hpp"
#include "app/report/overlay.hpp"
#include "app/report/picture.hpp"
#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/base/statistics.hpp"
#include "calibration/camera/files/camera_covariance.hpp"

namespace ballservo {
namespace {

using nlohmann::ordered_json;

constexpr int page_width_px = 800;
constexpr double overlay_enlarged = 50;
constexpr double ball_diameter_m = 0.070;

ordered_json parameters_json(const BoardCalibration& result) {
  const auto names = parameter_names(result.camera.parameters().model);
  const Eigen::VectorXd values = parameter_vector(result.camera.parameters());
  ordered_json list = ordered_json::array();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    list.push_back({{"name", names[i]},
                    {"value", values(at)},
                    {"sigma", std::sqrt(result.covariance.parameters(at, at))}});
  }
  return list;
}

ordered_json trials_json(const BoardCalibration& result) {
  ordered_json list = ordered_json::array();
  for (const LensCandidate& trial : result.trials)
    list.push_back({{"model", lens_model_name(trial.model())},
                    {"rms_px", trial.adjustment.rms_px},
                    {"held_out_rms_px", trial.held_out_rms_px()},
                    {"remark", trial.model() == result.camera.parameters().model ? "chosen"
                               : trial.usable                                    ? ""
                                              : "not usable over the whole picture"}});
  return list;
}

/// The 1-sigma error at a ball at three distances, over the picture.
ordered_json ball_maps(const BoardCalibration& calibration) {
  constexpr int columns = 21, rows = 15;
  ordered_json list = ordered_json::array();
  for (const double range_m : {0.5, 1.0, 2.0}) {
    const auto map = ball_sigma_map(calibration.camera, calibration.covariance.parameters, ball_diameter_m,
                                    range_m, columns, rows);
    if (!map || !map->worst_mm()) continue;
    ordered_json sigma = ordered_json::array();
    for (const auto& value : map->sigma_mm) sigma.push_back(value.value_or(not_known));
    list.push_back({{"range_m", range_m}, {"columns", map->columns}, {"sigma_mm", sigma}});
  }
  return list;
}

/// Each board with its corners, and its overlay as a picture that is not too large for a page.
ordered_json boards_json(const CameraCalibration& calibration, double max_pixels,
                         const OutputFolder& folder) {
  ordered_json list = ordered_json::array();
  for (std::size_t v = 0; v < calibration.views.size(); ++v) {
    throw_if_interrupted();
    const BoardView& view = calibration.views[v];
    const CornerResiduals& corners = calibration.result.corners[v];
    cv::Mat overlay = board_overlay(calibration.used[v]->picture(max_pixels), view, corners);
    folder.write(fmt::format("board_{:02}.png", v + 1), picture_bytes(overlay, ".png"));
    const double shrink = static_cast<double>(page_width_px) / overlay.cols;
    if (shrink < 1) cv::resize(overlay, overlay, {}, shrink, shrink, cv::INTER_AREA);
    const std::string name = fmt::format("board_{:02}_page.jpg", v + 1);
    folder.write(name, picture_bytes(overlay, ".jpg"));
    list.push_back({{"name", view.name},
                    {"file", name},
                    {"rms_px", corners.rms_px()},
                    {"corners_px", points_json(view.corners_px)},
                    {"residuals_px", points_json(corners.residuals_px)},
                    {"set_aside", std::vector<int>(corners.set_aside.begin(), corners.set_aside.end())}});
  }
  return list;
}

}  // namespace

cv::Mat board_overlay(const cv::Mat& picture, const BoardView& view, const CornerResiduals& corners) {
  const cv::Scalar red(0, 0, 255), green(0, 220, 0);
  cv::Mat image = picture.clone();
  const int thick = std::max(1, image.cols / 640);
  for (std::size_t i = 0; i < view.size(); ++i) {
    const Eigen::Vector2d& corner = view.corners_px[i];
    if (i > 0) draw_polyline(image, {view.corners_px[i - 1], corner}, false, {200, 160, 0}, thick);
    draw_circle(image, corner, 4 * thick, corners.set_aside[i] ? red : green, thick);
    // A corner far off would need an arrow beyond any picture.
    const Eigen::Vector2d tip =
        corner + (overlay_enlarged * corners.residuals_px[i]).cwiseMax(-2000).cwiseMin(2000);
    draw_polyline(image, {corner, tip}, false, red, thick);
  }
  draw_circle(image, view.corners_px.front(), 8 * thick, {0, 220, 220}, 2 * thick);
  return image;
}

std::string pixels_text(double value_px) {
  return std::isfinite(value_px) ? fmt::format("{:.3f} px", value_px) : "unknown";
}

std::vector<std::string> calibration_lacks(const BoardCalibration& calibration) {
  std::vector<std::string> advice;
  constexpr double wide_enough = 0.7, tight_correlation = 0.99, good_ball_mm = 1;
  constexpr std::size_t enough_boards = 10;
  if (calibration.corners.size() < enough_boards)
    advice.push_back(fmt::format("Take more pictures: {} boards were used, {} or more settle a lens.",
                                 calibration.corners.size(), enough_boards));
  if (calibration.covariance.focal_distance_correlation > tight_correlation)
    advice.push_back(
        "Tilt the board more (20 to 40 degrees, to different sides) and vary its distance: these pictures "
        "hardly tell a longer lens from a farther board.");
  const double covered_mm = calibration.covered_ball_sigma_mm.value_or(0);
  if (covered_mm > good_ball_mm)
    advice.push_back(
        fmt::format("Even where boards were, this calibration alone typically places a ball at 1 m to {:.1f} "
                    "mm only; four times as many pictures halve that.",
                    covered_mm));
  if (calibration.ball_sigma_mm && *calibration.ball_sigma_mm > good_ball_mm &&
      *calibration.ball_sigma_mm > 2 * covered_mm)
    advice.push_back(
        fmt::format("Towards the picture's rim the lens is extrapolated: there a ball at 1 m is uncertain by "
                    "up to {:.1f} mm. Let the board reach into every corner of the picture in some pictures; "
                    "parts of a chessboard count too.",
                    *calibration.ball_sigma_mm));
  else if (calibration.coverage < wide_enough)
    advice.push_back(
        "Bring the board to the parts of the picture where no corner lies (see the map of all corners): what "
        "the lens does there is extrapolated.");
  if (std::isfinite(calibration.held_out_rms_px) && calibration.held_out_rms_px > 1.3 * calibration.rms_px)
    advice.push_back(
        "Boards that were held out fit clearly worse than those used: the pictures are too few for this lens "
        "model.");
  return advice;
}

std::vector<std::string> calibration_advice(const BoardCalibration& calibration) {
  std::vector<std::string> advice = calibration_lacks(calibration);
  if (advice.empty())
    advice.push_back(calibration.warnings.empty() ? "Nothing: this calibration can be used as it is."
                                                  : "See to the warnings.");
  return advice;
}

nlohmann::ordered_json camera_report(const CameraCalibration& calibration, double max_pixels,
                                     const OutputFolder& folder) {
  const auto& [pictures, used, views, result] = calibration;
  ordered_json remarks = ordered_json::array(), rejected = ordered_json::array();
  for (const BoardPicture* picture : used)
    if (!picture->remark.empty()) remarks.push_back(picture->name() + ": " + picture->remark);
  for (const BoardPicture& picture : pictures.all)
    if (!picture.rejected.empty()) rejected.push_back({picture.name(), picture.rejected});
  const CameraParameters& camera = result.camera.parameters();
  return {{"page", "camera"},
          {"looked_at", pictures.all.size()},
          {"picture_px", {camera.size.width_px, camera.size.height_px}},
          {"principal_point_px", {camera.cx_px, camera.cy_px}},
          {"model", lens_model_name(camera.model)},
          {"rms_px", result.rms_px},
          {"held_out_rms_px", result.held_out_rms_px},
          {"noise_px", result.covariance.noise_px},
          {"structure_px", result.structure_px.value_or(not_known)},
          {"coverage", result.coverage},
          {"focal_distance_correlation", result.covariance.focal_distance_correlation},
          {"ball_sigma_mm", result.ball_sigma_mm.value_or(not_known)},
          {"covered_ball_sigma_mm", result.covered_ball_sigma_mm.value_or(not_known)},
          {"parameters", parameters_json(result)},
          {"trials", trials_json(result)},
          {"warnings", result.warnings},
          {"advice", calibration_advice(result)},
          {"ball_maps", ball_maps(result)},
          {"overlay_enlarged", overlay_enlarged},
          {"boards", boards_json(calibration, max_pixels, folder)},
          {"remarks", remarks},
          {"rejected", rejected}};
}

}  // namespace ballservo
