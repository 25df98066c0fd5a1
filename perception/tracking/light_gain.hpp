// How the light of a picture differs from the light under which the colours were taught.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {

/// The natural logarithm of the factor on each channel of the picture (blue, green, red), 0 for the taught
/// light. One factor a channel for all surfaces: von Kries' model (Finlayson, Drew and Funt 1994, "Spectral
/// sharpening", J. Opt. Soc. Am. A 11(5)). A camera's response curve that is a power keeps it a factor.
using LogGain = Eigen::Array3d;

/// What lights do. In log channels a change of level moves along (1, 1, 1), a change of colour temperature
/// along one fixed direction (Planck's law in Wien's form at 450, 540 and 600 nm; Finlayson and Hordley 2001,
/// "Color constancy at a pixel", J. Opt. Soc. Am. A 18(2)); what is left is a tint.
/// Coordinates of a gain along unit vectors: level, temperature (colder above 0) and tint.
Eigen::Array3d light_coordinates(const LogGain& gain);
LogGain gain_of(const Eigen::Array3d& coordinates);

/// The nearest gain that a light may have against the taught one: an eighth to eight times its level (ln 8),
/// a temperature as from 2500 to 9000 K, in linear light, and hardly a tint (green against magenta), which no
/// lamp of a temperature has.
LogGain confined(const LogGain& gain);

/// The colour of a surface as channels, with those that say something.
struct SurfaceColor {
  LogGain log_bgr = LogGain::Zero();                 ///< ln of grey levels
  std::array<bool, 3> known{{false, false, false}};  ///< neither clipped nor lost in the dark
};

/// The middle half (between the quartiles) of what each channel shows inside the outline, clear of its rim: a
/// highlight or a thing in front of less than a quarter of it changes little. Nothing known where much of the
/// outline lies outside the picture.
SurfaceColor middle_color(const cv::Mat& bgr, const OutlineEllipse& outline);

/// Puts values into the channels of `change` that are not known: those of a change of level and temperature
/// alone.
LogGain completed(const LogGain& change, const std::array<bool, 3>& known);

/// A picture looked at in so few places that it can be kept, to tell a change of light, which is everywhere,
/// from a change of things.
class PictureSamples {
 public:
  void take(const cv::Mat& bgr);
  bool empty() const { return size_.empty(); }

  /// The change of the light from then to now: the mean over the places of what lies near their median. A
  /// channel is known where enough places show it, neither clipped nor dark, at both times.
  SurfaceColor change_since(const PictureSamples& then) const;

 private:
  static constexpr int columns = 40, rows = 30;
  cv::Size size_;
  std::array<std::array<std::uint8_t, 3>, columns * rows> bgr_{};
};

}  // namespace ballservo
