// Where a comparison's pictures come from: a plan's renderer, or a user's own files.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "app/comparison/estimators/method_scene.hpp"
#include "app/comparison/frame_record.hpp"
#include "calibration/base/random.hpp"

namespace ballservo {

/// What all frames of a condition have in common.
struct ConditionInfo {
  std::string name;
  std::string words;  ///< what is shown, for readers
  int frames = 0;
  /// What a one-at-a-time design varies here, and its value.
  std::string swept_key, swept_label;
  double swept_value = 0;
  bool swept_log = false;
};

/// One picture, ready for the methods.
struct ComparisonPicture {
  FrameTruth truth;
  cv::Mat bgr;
  DetectorSetup detector;  ///< its rays are of the camera that the methods are told
  MethodTask task;
};

class PictureSource {
 public:
  virtual ~PictureSource() = default;
  virtual const std::vector<ConditionInfo>& conditions() const = 0;
  /// Makes what all frames of the conditions marked need, on the calling thread's arena. Throws Refusal where
  /// a colour cannot be learnt.
  virtual void prepare(const std::vector<char>& needed) = 0;
  /// Frame 0.. of a prepared condition; the same whenever it is asked for. Thread-safe.
  virtual ComparisonPicture picture(std::size_t condition, int frame) const = 0;
  /// What the peers are set to there, for readers; empty where none was tuned.
  virtual std::string peer_words(std::size_t condition) const = 0;
};

/// Where fits start that are told the ball's circle: there, displaced by errors of these sigmas (px), those
/// of the centre along each axis. Nothing where the circle has no undistorted one.
std::optional<UndistortedCircle> displaced_start(const Camera& camera, const OutlineEllipse& ball,
                                                 double center_sigma_px, double radius_sigma_px,
                                                 RandomEngine& engine);

/// Runs the methods on a picture.
ComparisonRecord measure(const ComparisonPicture& picture, const MethodList& methods);

}  // namespace ballservo
