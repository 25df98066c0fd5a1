// Where the floor ends in a picture: by its looks close to the robot, along given paths.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {

/// A path of pixels over what may be floor, from the robot outwards.
struct FloorPath {
  std::vector<cv::Point> pixels;
  std::size_t certain = 0;  ///< so many of the first are floor when the run begins
};

/// Of a path: the first pixel that is not floor, and the first after it that is again; both the number of
/// pixels where all is floor.
struct FloorEdge {
  std::size_t end = 0, again = 0;
};

/// After Ulrich and Nourbakhsh, "Appearance-based obstacle detection with monocular color vision" (AAAI
/// 2000): a pixel is floor where both its colour and its brightness are frequent among pixels that are
/// certainly floor, those close to the robot when the run begins. Here colours are chromaticities, which grey
/// floors have too, brightness is logarithmic, each pixel is the mean of 3 x 3, a pixel goes with the
/// majority of its neighbours on the path and beside it, and close pixels that are found to be floor renew
/// what is known. What looks like the floor is floor to it; a floor of another colour further on is not.
class FloorFinder {
 public:
  /// Paths stand in order from one side to the other.
  explicit FloorFinder(std::vector<FloorPath> paths);

  /// The edges of a frame (8-bit BGR), one for each path; empty where nothing can be said: another format or
  /// size, or no path begins with floor. `known`: a round thing that counts as floor. Valid until the next
  /// call; allocates nothing after the first.
  const std::vector<FloorEdge>& look(const cv::Mat& bgr, const OutlineEllipse* known = nullptr);

 private:
  static constexpr int chroma_bins = 32, light_bins = 64;
  struct Sample {
    std::uint16_t chroma = 0;
    std::uint8_t light = 0;
    bool known = false, floor = false;
  };
  void sample(const cv::Mat& bgr, const OutlineEllipse* known);
  void learn(bool first);
  void smooth();
  void judge();
  void trace();

  // Parts of the floor's pixels by their colour and by their brightness.
  struct Shares {
    std::array<float, chroma_bins * chroma_bins> chroma{};
    std::array<float, light_bins> light{};
  };

  std::vector<FloorPath> paths_;
  cv::Rect box_;  // of all their pixels
  std::vector<std::vector<Sample>> samples_;
  std::vector<std::vector<char>> floor_;
  std::vector<FloorEdge> edges_, nothing_;
  bool started_ = false;
  Shares counted_, smoothed_;
  std::array<std::uint8_t, 3 * 256> light_bin_{};
};

}  // namespace ballservo
