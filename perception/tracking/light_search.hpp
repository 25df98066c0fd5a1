// Balls in another light than the taught one, which no track tells: one is sought under the lights that lamps
// and cameras make.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "perception/detector.hpp"
#include "perception/tracking/light_adaptation.hpp"

namespace ballservo {

/// For pictures in which the taught light shows no ball.
class LightSearch {
 public:
  /// Of the odds that something is a ball: what is less sure is none where the light is not known either.
  static constexpr double least_log_odds = 6;
  /// A ball's colour stands out in many lights, that of a patch of its ground in few: the odds of all lights
  /// together.
  static constexpr double least_log_odds_of_all = 7;
  static constexpr std::size_t all_lights = 1000;

  struct Found {
    AssumedLight light;
    double least_log_odds;  ///< of a ball in it
  };

  explicit LightSearch(const Detector& detector);

  /// The light under which the picture shows what is most probably a ball, of those that are probable: by the
  /// picture's greys, or as the taught one, brighter or dimmer.
  std::optional<Found> find(const cv::Mat& bgr) {
    begin();
    return go_on(bgr, trials_.size(), least_log_odds_of_all);
  }

  /// The same in turns over the pictures of one light, `lights` of them a picture: nothing before the end. Of
  /// all lights, or of the `likeliest` by the greys of each picture. One light must make the ball sure,
  /// unless all lights together may: in a track a thing of a near colour would become the ball that is away.
  void begin(std::size_t likeliest = all_lights);
  std::optional<Found> go_on(const cv::Mat& bgr, std::size_t lights,
                             double least_of_all = std::numeric_limits<double>::infinity());
  bool is_done() const { return next_trial_ == end_; }

 private:
  struct Trial {
    Eigen::Array3d off;  // coordinates of light, from what the greys say or from the taught light
    double power;
    bool of_taught;
    double log_prior;
  };
  // What may be a ball in a light, and the light that makes its colour the taught one.
  struct Guess {
    AssumedLight light, refined;
    OutlineEllipse outline;
    double log_odds;     // with those of the light
    double second_look;  // without
    bool is_same_thing(const Guess& other) const;
  };
  struct Thing {
    Guess best;
    double log_odds;  // by all lights together
  };
  Eigen::Array3d by_greys(const LogGain& greys, double power) const;
  const std::vector<Guess>& look(const cv::Mat& bgr, const AssumedLight& light, const LogGain& greys);
  void add(const Guess& guess);

  Detector detector_;          // whose beliefs are its own
  std::vector<Trial> trials_;  // the likeliest first
  std::size_t next_trial_ = 0, end_ = 0;
  std::vector<Guess> guesses_;
  std::vector<Thing> things_;
  std::vector<SurfaceColor> of_class_;  // in the taught light
  LogGain taught_greys_;
};

/// The light that several balls of the taught colours agree about; the taught one where they do not, are too
/// few, or its table serves.
LogGain light_of_balls(const cv::Mat& bgr, const std::vector<BallObservation>& balls,
                       const ColorTable& colors);

}  // namespace ballservo
