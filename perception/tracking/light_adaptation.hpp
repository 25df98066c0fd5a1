// The classes follow the light, from confirmed balls only: colours are looked up in the taught table at those
// that the taught light would have shown.
//
// What keeps it from learning a wrong thing: only changes in time count. A ball's colour when it is first
// believed says nothing of the light, however far from the taught colours it lies; what it changes from then
// on does. And light is everywhere: a change counts only as far as the whole picture changed alike. So a
// thing that is merely looked at moves nothing, and one that takes or covers a ball's place moves nothing
// either.
#pragma once

#include "perception/ball_observation.hpp"
#include "perception/segmentation/color_lookup.hpp"
#include "perception/tracking/light_gain.hpp"

namespace ballservo {

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

  // For each picture, in this order:
  void begin(const cv::Mat& bgr);
  /// Whether the picture has changed, since a ball was last learnt from, more towards the taught light than
  /// not: without a ball to ask, that table is worth a look too.
  bool may_be_taught_light() const;
  /// For a confirmed ball that is missing: if the whole picture changed since a ball was last learnt from,
  /// colours are looked up for that light and the picture is worth another look; `settle_change` then says
  /// whether the ball was there.
  bool assume_change();
  void settle_change(bool found);
  /// Learns from a confirmed ball that was seen.
  void learn(const cv::Mat& bgr, const BallObservation& ball, BallLight& light);
  /// A ball was found under the taught light.
  void return_to_taught();
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
