// ballservo calibrate diff: how two calibrations of one camera disagree.
#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "app/commands/ball_options.hpp"
#include "app/commands/command.hpp"
#include "app/report/draw_pages.hpp"
#include "calibration/ball/camera_difference.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/statistics.hpp"

namespace ballservo {
namespace {

struct CalibrateDiffOptions {
  CommonOptions common;
  std::string a, b;
  CameraDifferenceOptions comparison;
  std::filesystem::path report;
};

struct ComparedCameras {
  const CalibrateDiffOptions& options;
  KnownCamera a, b;
  CameraDifference difference;
};

/// Differences that chance alone would exceed less often than this are more than the uncertainties allow.
constexpr double least_chance = 0.01;

/// Draws tell no more than a thousandth.
std::string chance_text(double chance) {
  return chance < 1e-3 ? "less than 0.1 %" : fmt::format("{:.3g} %", 100 * chance);
}

/// What the uncertainties say of the difference, in words.
std::string uncertainty_verdict(const ComparedCameras& compared) {
  const CameraDifference& d = compared.difference;
  if (!compared.a.covariance && !compared.b.covariance)
    return "How uncertain the two calibrations are is not known (no .covariance.json beside the files), so "
           "whether the difference means anything cannot be said.";
  if (!d.ball_sigma_rms_m)
    return "The calibrations are so uncertain that what it does to the ball cannot be computed.";
  if (!d.chance)
    return fmt::format(
        "Only {}'s uncertainty is known: the difference is {:.1f} times what it alone lets expect at the "
        "ball (RMS over the picture). Whether it is more than both allow cannot be said.",
        compared.a.covariance ? compared.options.a : compared.options.b, *d.sigmas_rms);
  const std::string expected = fmt::format(
      "at the ball it is {:.1f} times its sigma (RMS over the picture), and as much or more happens by "
      "chance in {} of such pairs",
      *d.sigmas_rms, chance_text(*d.chance));
  if (*d.chance >= least_chance)
    return "The difference is within what the calibrations' uncertainties allow: " + expected + ".";
  return "The difference is more than the calibrations' uncertainties allow: " + expected +
         ". Either the camera changed in between (focus, zoom, a knock), or a lens model does not fit.";
}

nlohmann::json place_json(const DifferencePlace& place) {
  const Eigen::Vector2d shift_px = place.shift_px.value_or(Eigen::Vector2d::Constant(not_known));
  const Eigen::Vector3d ball_mm = 1e3 * place.ball_m.value_or(Eigen::Vector3d::Constant(not_known));
  return {{"x_px", place.pixel_px.x()}, {"y_px", place.pixel_px.y()},
          {"dx_px", shift_px.x()},      {"dy_px", shift_px.y()},
          {"ball_dx_mm", ball_mm.x()},  {"ball_dy_mm", ball_mm.y()},
          {"ball_dz_mm", ball_mm.z()},  {"ball_sigma_mm", 1e3 * place.ball_sigma_m.value_or(not_known)}};
}

nlohmann::json difference_json(const ComparedCameras& compared) {
  const CameraDifference& d = compared.difference;
  nlohmann::json json{{"a", compared.options.a},
                      {"b", compared.options.b},
                      {"image_width_px", compared.a.camera.size().width_px},
                      {"image_height_px", compared.a.camera.size().height_px},
                      {"diameter_m", compared.options.comparison.diameter_m},
                      {"range_m", compared.options.comparison.range_m},
                      {"rotation_rad", {d.rotation_rad.x(), d.rotation_rad.y(), d.rotation_rad.z()}},
                      {"rotation_angle_rad", d.rotation_rad.norm()},
                      {"difference_median_px", d.shift_px.median},
                      {"difference_rms_px", d.shift_px.rms},
                      {"difference_max_px", d.shift_px.max},
                      {"ball_difference_median_mm", 1e3 * d.ball_m.median},
                      {"ball_difference_rms_mm", 1e3 * d.ball_m.rms},
                      {"ball_difference_max_mm", 1e3 * d.ball_m.max},
                      {"ball_sigma_rms_mm", 1e3 * d.ball_sigma_rms_m.value_or(not_known)},
                      {"ball_difference_sigmas_rms", d.sigmas_rms.value_or(not_known)},
                      {"uncertainty_known_a", compared.a.covariance.has_value()},
                      {"uncertainty_known_b", compared.b.covariance.has_value()},
                      {"chance", d.chance.value_or(not_known)},
                      {"within_uncertainties", nullptr},
                      {"places", nlohmann::json::array()}};
  if (d.chance) json["within_uncertainties"] = *d.chance >= least_chance;
  for (const DifferencePlace& place : d.places) json["places"].push_back(place_json(place));
  return json;
}

void print_difference(const ComparedCameras& compared) {
  const CameraDifference& d = compared.difference;
  const Eigen::Vector3d degrees = 180 / M_PI * d.rotation_rad;
  print_result("rotation between their frames, taken out: {:.4f} deg (about x {:.4f}, y {:.4f}, z {:.4f})\n",
               degrees.norm(), degrees.x(), degrees.y(), degrees.z());
  print_result("in the picture: median {:.4f} px, RMS {:.4f} px, at most {:.4f} px\n", d.shift_px.median,
               d.shift_px.rms, d.shift_px.max);
  print_result("a ball of {:g} mm at {:g} m: median {:.3f} mm, RMS {:.3f} mm, at most {:.3f} mm\n",
               1e3 * compared.options.comparison.diameter_m, compared.options.comparison.range_m,
               1e3 * d.ball_m.median, 1e3 * d.ball_m.rms, 1e3 * d.ball_m.max);
  print_result("{}\n", uncertainty_verdict(compared));
}

int calibrate_diff(const CalibrateDiffOptions& options) {
  FaultList faults;
  std::optional<KnownCamera> a, b;
  faults.collect([&] { a = read_known_camera(options.a); });
  faults.collect([&] { b = read_known_camera(options.b); });
  faults.throw_if_any();
  const ImageSize size_a = a->camera.size(), size_b = b->camera.size();
  if (size_a != size_b)
    throw InputError(options.b, fmt::format("a camera of {} x {} pixels", size_b.width_px, size_b.height_px),
                     fmt::format("one of {} x {}, as {}: two calibrations of one camera", size_a.width_px,
                                 size_a.height_px, options.a));
  std::optional<OutputFolder> report;
  if (!options.report.empty()) report.emplace(options.report, options.common.overwrite(options.report));

  CameraDifferenceOptions comparison = options.comparison;
  comparison.seed = options.common.seed;
  const ComparedCameras compared{
      options, *a, *b,
      compare_cameras(a->camera, a->covariance.value_or(Eigen::MatrixXd()), b->camera,
                      b->covariance.value_or(Eigen::MatrixXd()), comparison)};
  if (report) {
    nlohmann::ordered_json page = difference_json(compared);
    page["page"] = "difference";
    page["columns"] = compared.difference.columns;
    page["verdict"] = uncertainty_verdict(compared);
    write_report(*report, page, options.common.quiet);
    options.common.files->commit(report);
  }
  write_json_results(options.common, difference_json(compared));
  if (!options.common.quiet) {
    print_difference(compared);
    if (report)
      print_result("report: {}\n", std::filesystem::absolute(options.report / "report.html").string());
  }
  return exit_done;
}

}  // namespace

void add_calibrate_diff_command(CLI::App& calibrate, Action& action) {
  const auto [command, options] = add_command<CalibrateDiffOptions>(
      calibrate, action, "diff",
      "How two calibrations of one camera disagree, in pixels and in millimetres at a ball", calibrate_diff);
  command.add_option("A", options.a, "A camera file (any format; FILE:NAME where it holds several)")
      ->required();
  command.add_option("B", options.b, "Another, of the same camera")->required();
  add_number_option(command, "--diameter", options.comparison.diameter_m, NumberRange::above(0, "m"),
                    "The ball's diameter in metres (default 0.07)");
  add_number_option(command, "--range", options.comparison.range_m, NumberRange::above(0, "m"),
                    "How far away the ball is, in metres (default 1)");
  add_output_option(command, "--report", options.report, "DIR",
                    "A page with a map of the millimetres and pixels, DIR/report.html");
  add_common_options(command, options.common);
  command.footer(
      R"(A calibration cannot tell where its camera frame points: a frame turned a little, with the principal point
moved to make up for it, fits the same boards as well. So the rotation that brings the two cameras' rays
closest is taken out first; what is left is a difference that no turning explains. Where both cameras have
their .covariance.json beside them, the answer says whether the difference is within what these uncertainties
allow (for calibrations from different pictures: from the same ones their errors are common).
Exit: 0 compared, whatever the difference; 2 bad input, such as different picture sizes.
Example:
  ballservo calibrate diff monday.yaml friday.yaml --diameter 0.07 --range 1 --report difference)");
}

}  // namespace ballservo
