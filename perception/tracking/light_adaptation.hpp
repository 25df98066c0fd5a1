// The classes follow the light, from confirmed balls only: colours are looked up in the taught table at those
// that the taught light would have shown.
//
// What keeps it from learning a wrong thing: only changes in time count. A ball's colour when it is first
// believed says nothing of the light, however far from the taught colours it lies; what it changes from then
// on does. And light is everywhere: a change counts only as far as the whole picture changed alike. So a
// thing that is merely looked at moves nothing, and one that takes or covers a ball's place moves nothing
// either.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

#include "calibration/camera/sphere_outline.hpp"
#include "perception/ball_observation.hpp"
#include "perception/segmentation/color_lookup.hpp"

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

/// A light, and how the camera shows it, against what was taught: level_taught / 255 =
/// (level / 255 / factor of its channel)^power.
struct AssumedLight {
  LogGain gain = LogGain::Zero();
  double power = 1;  ///< above or below: one of the two cameras shows light in proportion, the other as sRGB
  bool is_taught() const { return power == 1 && (gain == 0).all(); }
};

/// How the taught table is to be looked up in that light: what the taught light would have shown, clipped as
/// the camera clips it.
LightCells cells_in(const AssumedLight& light);

/// The nearest gain that a light may have against the taught one: an eighth to eight times its level (ln 8),
/// a temperature as from 2500 to 9000 K, in linear light, and hardly a tint (green against magenta), which no
/// lamp of a temperature has.
LogGain confined(const LogGain& gain);

/// Of which channels something is known.
using Known = Eigen::Array<bool, 3, 1>;

/// The colour of a surface as channels, with those that say something.
struct SurfaceColor {
  LogGain log_bgr = LogGain::Zero();     ///< ln of grey levels
  Known known = Known::Constant(false);  ///< neither clipped nor lost in the dark

  /// Between which `log_bgr` lies: the same in known channels; one that is clipped or lost in the dark has
  /// one bound.
  LogGain least() const, most() const;
};

/// The middle half (between the quartiles) of what each channel shows inside the outline, clear of its rim: a
/// highlight or a thing in front of less than a quarter of it changes little. Nothing known where much of the
/// outline lies outside the picture.
SurfaceColor middle_color(const cv::Mat& bgr, const OutlineEllipse& outline);
/// The same of the pixels that a class was learnt from.
SurfaceColor middle_color(const ColorClass& color_class);

/// Puts values into the channels of `change` that are not known: those of a change of level and temperature
/// alone.
LogGain completed(const LogGain& change, const Known& known);

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

/// Log channels: a light that differs by less from the taught one is taken for it.
inline constexpr double significant_gain = 0.1;

/// What is remembered of a ball between pictures.
struct BallLight {
  SurfaceColor reference;  ///< its colour under the taught light, by what was believed of the light at first
  SurfaceColor last;       ///< as it was last seen
};

/// Takes no memory from the heap after construction.
class LightAdaptation {
 public:
  /// How the taught table is to be looked up in the light as it is now.
  const LightCells& cells() const { return cells_; }
  const LogGain& gain() const { return belief_.gain; }

  /// From now on the light is followed from this one, as from the taught one otherwise.
  void assume(const AssumedLight& light);
  const AssumedLight& assumed() const { return assumed_; }

  // For each picture, in this order:
  void begin(const cv::Mat& bgr);
  /// Whether the light was assumed, or the picture has changed, since a ball was last learnt from, more
  /// towards the taught light than not: without a ball to ask, that table is worth a look too.
  bool may_be_taught_light() const;
  /// For a confirmed ball that is missing: if the whole picture changed since a ball was last learnt from,
  /// colours are looked up for that light and the picture is worth another look; `settle_change` then says
  /// whether the ball was there.
  bool assume_change();
  void settle_change(bool found);
  /// Learns from a confirmed ball that was seen.
  void learn(const cv::Mat& bgr, const BallObservation& ball, BallLight& light);
  void finish(double time_s);

 private:
  void believe(const LogGain& gain);
  LogGain sudden_change(const SurfaceColor& now, const SurfaceColor& last) const;
  void jump(const LogGain& change);
  LogGain table_gain();
  void serve_light();

  // What is believed of the light, against the taught one.
  struct Belief {
    LogGain gain = LogGain::Zero();
    LogGain start = LogGain::Zero();           // when balls came in view, or jumped
    LogGain picture_change = LogGain::Zero();  // what the pictures have changed since
  };
  // What the balls of this picture say.
  struct Votes {
    LogGain sum = LogGain::Zero();
    int balls = 0;
  };

  AssumedLight assumed_;  // what all gains are against
  LightCells cells_ = LightCells::as_taught();
  Belief belief_;
  LogGain before_jump_ = LogGain::Zero();
  PictureSamples picture_, previous_, then_;  // this one, the one before, the last with a ball to learn from
  Votes votes_;
  bool significant_ = false;  // whether the light differs enough from the taught one
  bool jumped_ = false;       // the light of this picture is another at once
  double time_s_ = 0, learnt_s_ = 0;
};

}  // namespace ballservo
