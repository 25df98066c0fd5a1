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

std::string class_names(const ColorTable& colors) {
  std::string names;
  for (const ColorClass& color_class : colors.classes)
    names += (names.empty() ? "" : ", ") + color_class.name;
  return names;
}

// METRES[+-SIGMA]
BallRadius parse_diameter(const std::string& text, FaultList& faults) {
  const std::size_t separator = text.find("+-");
  const auto diameter_m = parse_number(text.substr(0, separator));
  const auto sigma_m =
      separator == std::string::npos ? std::optional<double>(0) : parse_number(text.substr(separator + 2));
  const bool good =
      diameter_m && *diameter_m > 0 && *diameter_m < 10 && sigma_m && *sigma_m >= 0 && *sigma_m < *diameter_m;
  if (good) return {*diameter_m / 2, *sigma_m / 2};
  faults.add("--diameter", "'" + text + "'",
             "the ball's diameter in metres, above 0 and below 10, with its sigma where known: 0.07 or "
             "0.07+-0.0003");
  return {};
}

}  // namespace

void add_ball_options(CLI::App& command, BallOptions& options) {
  command.add_option("--colors", options.colors, "The colours file that `calibrate colors` wrote")
      ->required(options.taught)
      ->type_name("FILE");
  command
      .add_option(
          "--camera", options.camera,
          "The camera's file (ViSP XML; ROS, OpenCV or Kalibr YAML; FILE:NAME where it holds several; "
          "FILE@WxH for its pictures scaled to that size)")
      ->type_name("FILE");
  command
      .add_option(
          "--diameter", options.diameter,
          "The balls' diameter, METRES[+-SIGMA] or NAME=METRES,...: with --camera it gives positions in 3-D")
      ->type_name("METRES");
  command
      .add_option("--fit", options.fit,
                  "sphere: the exact outline of a ball; paper: a circle and the paper's formula")
      ->check(CLI::IsMember({"sphere", "paper"}))
      ->capture_default_str();
  command
      .add_option("--response", options.response,
                  "How grey levels follow the light: linear, srgb (as of pictures made to be looked at), or "
                  "auto: told by the balls' edges")
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
                   "a class of the colours file: " + class_names(colors));
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
    if (known.covariance) camera_uncertainty_.emplace(known.camera, known.covariance->covariance);
  });
  faults.collect([&] {
    if (colors_) options_.radii = parse_diameters(options.diameter, *colors_, options.taught);
  });
  faults.throw_if_any();
  if (options.has_camera() == options.diameter.empty())
    spdlog::warn("{} without {}: no positions in 3-D", options.has_camera() ? "--camera" : "--diameter",
                 options.has_camera() ? "--diameter" : "--camera");
  if (!rays_) {  // without a camera there is no 3-D, and a ball may be an oval
    options_.radii.clear();
    options_.oval_fraction = 0.04;
  } else {
    diameter_ = options.diameter;
  }
  options_.fit = options.fit == "paper" ? BallFit::paper : BallFit::sphere;
  options_.response = options.response == "linear" ? ResponseChoice::linear
                      : options.response == "srgb" ? ResponseChoice::srgb
                                                   : ResponseChoice::by_edges;
  options_.seed = common.seed;
  options_.threads = std::clamp(common.threads, 1, DetectorOptions::most_threads);
}

void DetectorFactory::set_colors(std::shared_ptr<const ColorTable> colors) {
  options_.radii = parse_diameters(diameter_, *colors, false);
  colors_ = std::move(colors);
}

Detector DetectorFactory::make(ImageSize size, const std::string& place) const {
  if (!rays_) return Detector(std::make_shared<const RayTable>(long_lens_camera(size)), colors_, options_);
  check_camera_fits(rays_->camera(), size, place);
  return Detector(rays_, colors_, options_);
}

BallObservation DetectorFactory::with_total_covariance(BallObservation ball) const {
  if (!ball.position || !camera_uncertainty_) return ball;
  const double radius_m = options_.radii[static_cast<std::size_t>(ball.color_class) - 1].radius_m;
  const auto of_camera = camera_uncertainty_->ball_covariance(ball.position->p_C, radius_m);
  if (of_camera) ball.position->covariance_m2 += *of_camera;
  return ball;
}

}  // namespace ballservo
