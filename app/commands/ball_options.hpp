// The options that detect and track share: which colours, which camera, how large the balls are, which fit.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/camera/camera.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "perception/detector.hpp"

namespace ballservo {

struct CommonOptions;

/// A camera, and how well it is known, where that is known.
struct KnownCamera {
  Camera camera;
  std::optional<Eigen::MatrixXd> covariance;  ///< of its parameters, in the order of parameter_names
};
KnownCamera read_known_camera(const std::string& file);

struct BallOptions {
  std::string colors, camera, fov, diameter, fit = "sphere", response = "auto";
  std::shared_ptr<const ColorTable> color_table{};  ///< instead of the colours' file
  std::optional<KnownCamera> known_camera{};        ///< instead of the camera's file
  bool taught =
      true;  ///< colours are in a file; otherwise they may come later, and names of classes with them

  bool has_camera() const { return known_camera || !camera.empty(); }
};

/// Adds --colors (needed if `options.taught`), --camera, --fov, --diameter, --fit and --response.
void add_ball_options(CLI::App& command, BallOptions& options);

/// The radii of the classes from METRES[+-SIGMA] (all classes) or NAME=METRES[+-SIGMA],... ; empty for an
/// empty text. Throws InputError naming every fault: not a number, not above 0, an unknown class, a class
/// named twice. A class that is not known is none where not `all_known`.
std::vector<BallRadius> parse_diameters(const std::string& text, const ColorTable& colors,
                                        bool all_known = true);

/// What is known of the pictures that a detector is made for.
struct PictureKind {
  bool still = false;          ///< no frame of a video or camera
  bool coarse_chroma = false;  ///< see DetectorOptions
};

/// Makes detectors for pictures, of one camera or, where none is given, of any size.
class DetectorFactory {
 public:
  /// Reads and checks the files; every fault of all options at once. --seed is the source of the votes'
  /// chance; --threads share the rows of a picture (0: one does).
  DetectorFactory(const BallOptions& options, const CommonOptions& common);

  /// A detector for pictures of that size; throws InputError (`place` names the picture) where the camera's
  /// differs. Without a camera balls may be ovals: in a still by its lens, in a video by their motion, too.
  Detector make(ImageSize size, const std::string& place, PictureKind kind = {}) const;
  const ColorTable& colors() const { return *colors_; }
  const std::string& doubt() const { return doubt_; }  ///< about an approximate camera; empty: none
  /// Makes detectors of other colours from now on.
  void set_colors(std::shared_ptr<const ColorTable> colors);
  /// Of this camera from now on.
  void set_camera(const KnownCamera& known);
  /// Of balls so large from now on, as --diameter has it. Throws InputError for a diameter that is none.
  void set_diameter(const std::string& diameter);
  /// A camera is given, and nothing beside its file says how well it is known.
  bool camera_counts_as_exact() const { return rays_ && !camera_uncertainty_; }
  /// As --diameter has it; empty: not known.
  const std::string& diameter() const { return diameter_; }

  /// The same ball with the camera's own uncertainty in its position's covariance, where the parameters'
  /// covariance was found beside the camera's file.
  BallObservation with_total_covariance(BallObservation ball) const;

 private:
  std::shared_ptr<const ColorTable> colors_;
  std::shared_ptr<const RayTable> rays_;  // of the camera, if one is given
  std::optional<CameraUncertainty> camera_uncertainty_;
  std::optional<double> fov_rad_;  // of an approximate camera, across the picture's width
  DetectorOptions options_;
  std::string diameter_, doubt_;
};

}  // namespace ballservo
