// Balls in another light than the taught one, which no track tells: one is sought under the lights that lamps
// and cameras make.
#pragma once

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
  static constexpr std::size_t all_lights = 1000;

  explicit LightSearch(const Detector& detector);

  /// The light under which the picture shows what is most probably a ball. Nothing where no light does that
  /// is probable by the picture's greys: the surfaces of two pictures are of about the same grey on average.
  std::optional<AssumedLight> find(const cv::Mat& bgr) {
    begin();
    return go_on(bgr, trials_.size());
  }

  /// The same in turns over the pictures of one light, `lights` of them a picture: nothing before the end. Of
  /// all lights, or of the `likeliest` by the greys of each picture.
  void begin(std::size_t likeliest = all_lights);
  std::optional<AssumedLight> go_on(const cv::Mat& bgr, std::size_t lights);
  bool is_done() const { return next_trial_ == end_; }

 private:
  struct Trial {
    Eigen::Array3d off;  // coordinates of light, from what the greys say
    double power;
  };
  struct Guess {
    AssumedLight light;
    double log_odds = -1e9;
  };
  Guess look(const cv::Mat& bgr, const AssumedLight& light, const Eigen::Array3d& by_greys);
  AssumedLight refined_by(const cv::Mat& bgr, const BallObservation& ball, const AssumedLight& light) const;

  Detector detector_;          // whose beliefs are its own
  std::vector<Trial> trials_;  // the likeliest first
  std::size_t next_trial_ = 0, end_ = 0;
  Guess best_;
  std::vector<SurfaceColor> of_class_;  // in the taught light
  LogGain taught_greys_;
};

}  // namespace ballservo
