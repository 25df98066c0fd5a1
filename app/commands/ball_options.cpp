#include "app/commands/ball_options.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "app/commands/command.hpp"
#include "app/commands/work_options.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "calibration/color/color_file.hpp"

namespace ballservo {
namespace {

// Where no camera is known, how much of an oval a ball is (sigma, radii): the former places half-hidden balls
// in photographs best, the latter keeps a fast hand's ball.
constexpr double oval_by_lens = 0.012, oval_by_motion = 0.04;

/// VALUE[+-SIGMA]; without SIGMA it is `usual_share` of the value.
std::pair<std::optional<double>, std::optional<double>> parse_with_sigma(const std::string& text,
                                                                         double usual_share) {
  const std::size_t separator = text.find("+-");
  const auto value = parse_number(text.substr(0, separator));
  if (separator != std::string::npos) return {value, parse_number(text.substr(separator + 2))};
  return {value, usual_share * value.value_or(0)};
}

// METRES[+-SIGMA]
BallRadius parse_diameter(const std::string& text, FaultList& faults) {
  const auto [diameter_m, sigma_m] = parse_with_sigma(text, 0);
  const bool good = diameter_m && *diameter_m >= 1e-3 && *diameter_m < 10 && sigma_m && *sigma_m >= 0 &&
                    *sigma_m < *diameter_m;
  if (good) return {*diameter_m / 2, *sigma_m / 2};
  faults.add("--diameter", "'" + text + "'",
             "the ball's diameter in metres, from 0.001 and below 10, with its sigma where known: 0.07 or "
             "0.07+-0.0003");
  return {};
}

/// DEG[+-SIGMA] in radians. Makers give angles of the diagonal, or rounded; a lens bends them.
std::pair<double, double> parse_fov(const std::string& text) {
  constexpr double usual_doubt = 0.1;
  const auto [deg, sigma_deg] = parse_with_sigma(text, usual_doubt);
  if (!deg || !(*deg >= 1 && *deg <= 150) || !sigma_deg || !(*sigma_deg >= 0 && *sigma_deg <= *deg / 3))
    throw InputError("--fov", "'" + text + "'",
                     "an angle of 1 to 150 degrees, with a sigma of at most a third of it: 60 or 60+-3");
  return {*deg * M_PI / 180, *sigma_deg * M_PI / 180};
}

double focal_px(double width_px, double fov_rad) { return width_px / 2 / std::tan(fov_rad / 2); }

Camera camera_of_fov(ImageSize size, double fov_rad) {
  CameraParameters parameters = long_lens_camera(size).parameters();
  parameters.fx_px = parameters.fy_px = focal_px(size.width_px, fov_rad);
  return Camera(parameters, "picture");
}

/// How uncertain balls are that such a camera places. It is the same for pictures of every size.
CameraUncertainty uncertainty_of_fov(double fov_rad, double sigma_rad) {
  constexpr double center_doubt = 0.02;  // of the picture's width
  const Camera camera = camera_of_fov({640, 480}, fov_rad);
  const double focal_sigma_px = (focal_px(640, fov_rad - sigma_rad) - focal_px(640, fov_rad + sigma_rad)) / 2;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  covariance.topLeftCorner<2, 2>().setConstant(focal_sigma_px * focal_sigma_px);
  covariance(2, 2) = covariance(3, 3) = std::pow(center_doubt * 640, 2);
  return CameraUncertainty(camera, covariance);
}

}  // namespace

void add_ball_options(CLI::App& command, BallOptions& options) {
  const auto not_empty = [](const std::string& text) {
    return std::string(text.empty() ? "found an empty value" : "");
  };
  add_typed_option(command, "--colors", options.colors, "FILE",
                   "The colours file that `calibrate colors` wrote")
      ->required(options.taught);
  add_typed_option(
      command, "--camera", options.camera, "FILE",
      "The camera's file (ViSP XML; ROS, OpenCV or Kalibr YAML; FILE:NAME where it holds several; "
      "FILE@WxH for its pictures scaled to that size)")
      ->check(not_empty);
  add_typed_option(
      command, "--fov", options.fov, "DEG[+-SIGMA]",
      "Without --camera: the angle that a picture's width spans, with its sigma (default a tenth): "
      "directions and ranges are approximate")
      ->check(not_empty);
  add_typed_option(
      command, "--diameter", options.diameter, "METRES",
      "The balls' diameter, METRES[+-SIGMA] or NAME=METRES,...: with --camera it gives positions in 3-D")
      ->check(not_empty);
  command
      .add_option("--fit", options.fit,
                  "sphere: the exact outline of a ball; paper: a circle and the paper's formula")
      ->check(CLI::IsMember({"sphere", "paper"}))
      ->capture_default_str();
  command
      .add_option("--response", options.response,
                  "How grey levels follow the light: linear, srgb (as of pictures made to be looked at), or "
                  "auto: told by noise and the balls' edges")
      ->check(CLI::IsMember({"auto", "linear", "srgb"}))
      ->capture_default_str();
}

std::vector<BallRadius> parse_diameters(const std::string& text, const ColorTable& colors, bool all_known) {
  if (text.empty()) return {};
  FaultList faults;
  std::vector<BallRadius> radii(colors.classes.size());
  if (text.find('=') == std::string::npos) {
    std::fill(radii.begin(), radii.end(), parse_diameter(text, faults));
  } else {
    std::vector<bool> named(radii.size(), false);
    for (const std::string& part : split(text, ',')) {
      const std::size_t equals = part.find('=');
      const std::string name = part.substr(0, equals);
      const auto color_class = colors.find(name);
      if (equals == std::string::npos) {
        faults.add("--diameter", "'" + part + "'", "NAME=METRES for every entry");
      } else if (!color_class && !all_known) {
        parse_diameter(part.substr(equals + 1), faults);
      } else if (!color_class) {
        faults.add("--diameter", "the class '" + name + "'",
                   fmt::format("a class of the colours file: {}", fmt::join(colors.class_names(), ", ")));
      } else if (named[static_cast<std::size_t>(*color_class) - 1]) {
        faults.add("--diameter", "the class '" + name + "' twice", "each class once");
      } else {
        named[static_cast<std::size_t>(*color_class) - 1] = true;
        radii[static_cast<std::size_t>(*color_class) - 1] = parse_diameter(part.substr(equals + 1), faults);
      }
    }
  }
  faults.throw_if_any();
  return radii;
}

KnownCamera read_known_camera(const std::string& file) {
  const Camera camera = read_camera(file);
  return {camera, read_camera_covariance(file, camera)};
}

DetectorFactory::DetectorFactory(const BallOptions& options, const CommonOptions& common) {
  FaultList faults;
  faults.collect([&] {
    colors_ = options.color_table;
    if (!colors_)
      colors_ = std::make_shared<const ColorTable>(
          options.colors.empty() && !options.taught ? ColorTable() : read_color_file(options.colors));
  });
  faults.collect([&] {
    if (!options.has_camera()) return;
    const KnownCamera known =
        options.known_camera ? *options.known_camera : read_known_camera(options.camera);
    admit_camera(options.camera, known.camera.size(), common, 1);
    rays_ = std::make_shared<const RayTable>(known.camera);
    if (known.covariance) camera_uncertainty_.emplace(known.camera, *known.covariance);
  });
  faults.collect([&] {
    if (options.fov.empty()) return;
    if (options.has_camera()) throw InputError("--fov", "beside --camera", "one of them");
    const auto [fov_rad, sigma_rad] = parse_fov(options.fov);
    fov_rad_ = fov_rad;
    camera_uncertainty_.emplace(uncertainty_of_fov(fov_rad, sigma_rad));
    doubt_ = fmt::format(
        "the camera is known by its field of view alone: directions and ranges are approximate, ranges to "
        "{:.0f} % (1 sigma). "
        "`calibrate camera` makes them exact",
        100 * (focal_px(1, fov_rad - sigma_rad) / focal_px(1, fov_rad + sigma_rad) - 1) / 2);
  });
  faults.collect([&] {
    if (colors_) options_.radii = parse_diameters(options.diameter, *colors_, options.taught);
  });
  faults.throw_if_any();
  const bool camera = rays_ || fov_rad_;
  const bool may_be_calibrated = !options.taught;  // in the page
  if (camera == options.diameter.empty() && (camera || !may_be_calibrated))
    spdlog::warn("{} without {}: no positions in 3-D",
                 !camera    ? "--diameter"
                 : fov_rad_ ? "--fov"
                            : "--camera",
                 camera ? "--diameter" : "--camera");
  if (!doubt_.empty() && !(options.taught && options.diameter.empty())) spdlog::warn("{}", doubt_);
  for (const BallRadius& radius : options_.radii) {
    if (radius.radius_m == 0 || (radius.radius_m > 0.005 && radius.radius_m < 0.5)) continue;
    spdlog::warn("--diameter: a ball {} m across? It is given in metres", 2 * radius.radius_m);
    break;
  }
  for (std::size_t k = 0; camera && !options.diameter.empty() && k < options_.radii.size(); ++k) {
    if (options_.radii[k].radius_m == 0)
      spdlog::warn("--diameter gives none of class {}: no positions of it in 3-D", colors_->classes[k].name);
  }
  if (!camera) options_.radii.clear();
  diameter_ = options.diameter;
  options_.fit = options.fit == "paper" ? BallFit::paper : BallFit::sphere;
  options_.response = options.response == "linear" ? ResponseChoice::linear
                      : options.response == "srgb" ? ResponseChoice::srgb
                                                   : ResponseChoice::by_picture;
  options_.seed = common.seed;
  options_.threads = std::clamp(common.threads, 1, DetectorOptions::most_threads);
}

void DetectorFactory::set_colors(std::shared_ptr<const ColorTable> colors) {
  if (rays_ || fov_rad_) options_.radii = parse_diameters(diameter_, *colors, false);
  colors_ = std::move(colors);
}

void DetectorFactory::set_diameter(const std::string& diameter) {
  const std::vector<BallRadius> radii = parse_diameters(diameter, *colors_, false);
  if (rays_ || fov_rad_) options_.radii = radii;
  diameter_ = diameter;
}

void DetectorFactory::set_camera(const KnownCamera& known) {
  options_.radii = parse_diameters(diameter_, *colors_, false);
  rays_ = std::make_shared<const RayTable>(known.camera);
  camera_uncertainty_.reset();
  if (known.covariance) camera_uncertainty_.emplace(known.camera, *known.covariance);
  fov_rad_.reset();
  doubt_.clear();
}

Detector DetectorFactory::make(ImageSize size, const std::string& place, PictureKind kind) const {
  DetectorOptions options = options_;
  options.coarse_chroma = kind.coarse_chroma;
  if (rays_) {
    check_camera_fits(rays_->camera(), size, "--camera", place);
    return Detector(rays_, colors_, options);
  }
  if (!fov_rad_) options.oval_fraction = kind.still ? oval_by_lens : oval_by_motion;
  return Detector(
      std::make_shared<const RayTable>(fov_rad_ ? camera_of_fov(size, *fov_rad_) : long_lens_camera(size)),
      colors_, options);
}

BallObservation DetectorFactory::with_total_covariance(BallObservation ball) const {
  if (!ball.position || !camera_uncertainty_) return ball;
  const double radius_m = options_.radii[static_cast<std::size_t>(ball.color_class) - 1].radius_m;
  const auto of_camera = camera_uncertainty_->ball_covariance(ball.position->p_C, radius_m);
  if (of_camera) ball.position->covariance_m2 += *of_camera;
  return ball;
}

}  // namespace ballservo
