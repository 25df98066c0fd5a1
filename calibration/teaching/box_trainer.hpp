// Teaching a colour from live material: the user holds the ball where a box is drawn (as Pixy's teach
// button).
#pragma once

#include <string>
#include <vector>

#include "calibration/teaching/learn_colors.hpp"

namespace ballservo {

/// So many frames with the ball in the box are learnt from: a second of most cameras.
inline constexpr std::size_t frames_wanted = 30;

/// Frame by frame: finds the round coloured thing near the box, follows it, and keeps its pixels.
class BoxTrainer {
 public:
  /// `box`: in pixels of the frames. Throws InputError for a name that is no class name or a box that is no
  /// box.
  BoxTrainer(std::string name, const PointedBall& box, const RegionSearchOptions& search = {});

  /// Looks at the next frame (CV_8UC3, all of one size); whether a ball was in the box. Throws InputError
  /// where the box lies outside the picture.
  bool look(const cv::Mat& bgr, int frame);
  bool enough() const { return balls_.size() >= frames_wanted; }

  /// A frame to show, with where the box was.
  struct Shown {
    int frame = 0;
    cv::Mat bgr;
    PointedBall box, ball;
  };
  /// The first and the last frame with a ball in the box.
  const std::vector<Shown>& shown() const { return shown_; }
  int looked_at() const { return looked_at_; }

  /// The class, from the colour that most of the balls had; its circles count as of picture 0. Throws Refusal
  /// where too few frames had a ball in the box, or where they had things of different colours.
  LearntColors finish(const std::vector<ColorPicture>& background = {}) const;

 private:
  std::string name_;
  PointedBall box_, place_;
  RegionSearchOptions search_;
  std::vector<BallCandidate> balls_;  // `picture` is the frame
  CellCounts off_ball_, all_;
  std::vector<Shown> shown_;
  cv::Size size_;
  int looked_at_ = 0, missed_ = 0;
};

}  // namespace ballservo
