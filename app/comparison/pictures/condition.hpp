// One way in which a comparison shows the ball.
#pragma once

#include <optional>
#include <string>

#include "calibration/base/options.hpp"
#include "calibration/camera/camera.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "servo/simulation/rendering/sensor.hpp"
#include "servo/simulation/world/texture.hpp"

namespace ballservo {

/// Who draws the pictures. `lab` renders a ball near the optical axis before textured walls and boxes, where
/// all else stays as it is while one thing is varied. `room` renders one anywhere near the middle, among 40
/// things of all colours, lit from any side up to 100 degrees from the camera. `painted` paints it without
/// the renderer, so that no figure leans on what only the renderer does.
enum class Painter { lab, room, painted };

/// How a painted ball looks.
struct PaintedLook {
  bool half_shade = false, highlight = false, marbled = false, contact_shadow = false;
};

/// What stands behind the ball: textured walls and boxes, or walls of one colour.
enum class ComparisonBackground { clutter, plain };

/// Which part of the ball is hidden, as the picture shows it.
enum class OcclusionSide { any, left, right, below, above };

/// Sigmas of the error of a fit's start: of the centre along each axis, of the radius.
struct StartError {
  double center_px = 0, radius_px = 0;
};

/// Every frame of a condition draws its own background, light and sub-pixel position.
struct ComparisonCondition {
  std::string name;  ///< 1 to 64 of a-z, 0-9 and _
  int frames = 20;
  Painter painter = Painter::lab;
  PaintedLook look;        ///< painted pictures only
  bool has_ball = true;    ///< room and painted: false shows only what may be taken for a ball
  bool at_border = false;  ///< room and painted: the ball's centre lies near the picture's border
  Camera camera{CameraParameters{LensModel::pinhole, {640, 480}, 857, 857, 319.5, 239.5, {}}};
  double resolution = 1;  ///< the picture's size and focal length, as a multiple of the camera's
  /// The camera's own covariance, where its file has one; `calibration_sigmas` times it is what the
  /// estimators' camera is off by, drawn anew for each frame.
  std::optional<Eigen::MatrixXd> covariance{};
  double calibration_sigmas = 0;

  std::string ball_color = "red";  ///< a colour word, see color_words()
  double diameter_m = 0.07;
  Pattern ball_pattern = Pattern::plain;
  double depth_m = 1;       ///< Z of the ball's centre
  double off_axis_rad = 0;  ///< angle of the ball's centre from the optical axis
  double occlusion = 0;     ///< fraction of the disc behind something with a straight edge, 0 to 0.8
  OcclusionSide occlusion_side = OcclusionSide::any;

  ComparisonBackground background = ComparisonBackground::clutter;
  double contrast = 1;      ///< of what is behind to the ball's colour: 0 is that colour itself
  double ring_clutter = 0;  ///< boxes right behind the ball whose edges cross its outline
  double same_color = 0;    ///< things of nearly the ball's colour elsewhere in the picture
  bool touching = false;    ///< a bar of the ball's colour touches it in the picture

  double light_level = 1;  ///< lamp and ambient light, as a multiple of the usual
  std::optional<double>
      light_angle_rad{};      ///< of the lamp from the camera's direction; by chance: 27 to 67 deg
  double motion_blur_px = 0;  ///< how far the ball moves in the picture while it is exposed
  SensorOptions sensor;

  /// The fits start from the true circle, displaced; from the votes' where there is nothing here.
  std::optional<StartError> start{};

  /// The key of the number that a one-at-a-time design varies here; empty: none.
  std::string swept;

  double radius_m() const { return diameter_m / 2; }
};

/// All but the name and the camera.
void declare(OptionVisitor& v, ComparisonCondition& condition);

/// A number of a condition, which designs vary.
struct ConditionNumber {
  double value = 0;
  NumberRange range;
  std::string label;  ///< "noise (grey levels)": for plots
  bool log = false;   ///< shown on a logarithmic axis
};
/// By its key, "noise.read"; nothing where there is none.
std::optional<ConditionNumber> find_number(ComparisonCondition condition, const std::string& key);
void set_number(ComparisonCondition& condition, const std::string& key, double value);

/// "red ball of 70 mm, 60 px across, Z = 1 m ...": what differs from the usual is said.
std::string in_words(const ComparisonCondition& condition);

}  // namespace ballservo
