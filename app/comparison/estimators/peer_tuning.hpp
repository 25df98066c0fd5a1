// The best of each peer's few settings, on frames that it is not measured on.
#pragma once

#include <vector>

#include "app/comparison/estimators/method_scene.hpp"
#include "app/comparison/frame_record.hpp"

namespace ballservo {

/// A picture with what is true of it and what a peer is told.
struct TuningPicture {
  cv::Mat bgr;
  FrameTruth truth;
  MethodTask task;
};

/// For each peer among the methods the setting that finds the ball in most of the pictures and, among those,
/// errs least: the mean of centre and radius errors (px). The first of the grid where nothing finds anything.
PeerSettings tuned_peers(const std::vector<TuningPicture>& pictures, const MethodList& methods);

}  // namespace ballservo
