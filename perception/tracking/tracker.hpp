// Stage 7: balls followed from picture to picture (paper, "Suivi"): the last position settles confusions with
// objects of the same colour and shape, and bridges short occlusions.
#pragma once

#include <optional>
#include <vector>

#include "calibration/base/track_state.hpp"
#include "perception/detector.hpp"
#include "perception/tracking/ball_evidence.hpp"
#include "perception/tracking/light_adaptation.hpp"
#include "perception/tracking/light_search.hpp"
#include "perception/tracking/track_filter.hpp"

namespace ballservo {

/// Pictures between two looks at the whole picture while no ball is missing.
inline constexpr int newcomers_every = 10;

struct TrackerOptions {
  bool fixed_colors = false;       ///< looks with the taught colours alone, whatever the light does
  bool seek_light = true;          ///< while no ball is known, also under other lights than the taught one
  bool seek_light_at_once = true;  ///< in the first picture; else from the tenth on
};

/// A ball followed through the pictures.
struct Track {
  int id = 0;
  ClassIndex color_class = no_class;
  TrackState state = TrackState::tentative;
  /// Seen: this picture's own fit. Coasting: outline, cone and position as predicted, quality 0.
  BallObservation ball;
};

class Tracker {
 public:
  Tracker(Detector detector, const TrackerOptions& options = {});

  /// Follows the balls into the picture taken at `time_s`. The tracks in order of their id; a picture that is
  /// not later than the last one is ignored and gives the same tracks again.
  const std::vector<Track>& update(const cv::Mat& bgr, double time_s, DetectionStages* stages = nullptr);

  const Detector& detector() const { return detector_; }
  /// What the looks at the last picture left out.
  const LeftOut& left_out() const { return left_out_; }
  /// The light that is believed now, against the taught one, or the one that was assumed.
  LogGain light() const { return light_ ? light_->gain() : LogGain::Zero(); }
  /// The light that was assumed when the last ball was found, if it is another than the taught one.
  std::optional<AssumedLight> assumed_light() const;

 private:
  struct Followed {
    Track track;
    TrackFilter filter;
    BallEvidence evidence{};
    bool ended = false;
    double seen_s = 0, born_s = 0;
    BallLight light{};
    std::optional<std::size_t> detection{};  // its ball among those of this picture
  };
  struct Pair {
    bool tentative;
    double negative_log_likelihood;
    std::size_t followed, seen;
  };
  void choose_light();
  void set_light();
  void look_under_another_light(const cv::Mat& bgr);
  void seek_light(const cv::Mat& bgr);
  void put_off_light_search();
  bool see_sure_balls(const cv::Mat& bgr, double least_log_odds);
  void learn_colors(const cv::Mat& bgr);
  bool is_taken(std::size_t seen) const;
  bool is_shown(const Followed& followed) const;
  bool is_believed(const Followed& followed) const;
  void count_look_alikes();
  void look(const cv::Mat& bgr, DetectionStages* stages);
  void look_near_predictions(const cv::Mat& bgr);
  void look_for_streak(const cv::Mat& bgr, const Followed& followed, const OutlineEllipse& expected);
  void detect(const cv::Mat& bgr, const cv::Rect& window, double min_quality, DetectionStages* stages);
  void detect_thoroughly(const cv::Mat& bgr);
  void add_new(const BallObservation& ball);
  void gather_evidence(const cv::Mat& bgr, Followed& followed);
  bool is_seen(const Followed& followed) const;
  bool is_plausible(const Followed& followed, const BallObservation& ball) const;
  void match();
  bool may_be_missing_one(const Followed& missing, const BallObservation& ball) const;
  void continue_jumps();
  void rejoin_newcomers();
  void miss(Followed& followed, double time_s, const cv::Size& picture);
  void see(Followed& followed, const BallObservation& ball, double time_s);

  Detector detector_;
  TrackerOptions options_;
  std::optional<LightAdaptation> light_;
  std::optional<LightSearch> other_lights_;
  bool is_light_believed_ = false;  // the one that is assumed: it showed a confirmed ball
  long next_light_search_ = 0, next_search_of_all_ = 0;  // in pictures
  bool taught_light_ = false;  // looks under the taught light, though another is believed
  std::vector<Followed> followed_;
  LookAlikes look_alikes_;
  LeftOut left_out_;                   // of this picture
  std::vector<BallObservation> seen_;  // balls of this picture
  std::vector<Pair> pairs_;            // of a track and a ball that may belong together; reused
  std::vector<Track> tracks_;
  int next_id_ = 1;
  long pictures_ = 0;
  double time_s_ = -1e300, interval_s_ = 0;  // of this picture, and since the last one
};

}  // namespace ballservo
