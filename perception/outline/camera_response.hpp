// How a camera's grey levels follow the light that falls on its pixels.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "perception/outline/edge_model.hpp"

namespace ballservo {

/// One camera's response, the same for its three channels.
struct CameraResponse {
  std::array<float, 256> light{};  ///< of each grey level, 0 to 255
  std::array<float, 256> slope{};  ///< d light / d grey level

  /// Grey levels that are proportional to the light, as of machine-vision cameras and most renderers.
  static const CameraResponse& linear();
  /// As of pictures made to be looked at: IEC 61966-2-1, close to the power 2.2.
  static const CameraResponse& srgb();
};

/// Which of the two responses a camera has, from what balls' edges say. The edges of one picture may leave it
/// open, and a video that was resampled as grey levels may leave it open for ever, so looks are counted.
class ResponseBelief {
 public:
  /// `evidence` of one ball: the logarithm of the likelihoods' ratio, positive for sRGB.
  void add(double evidence);
  /// Is it worth while to look at more edges?
  bool open() const;
  /// Linear until the evidence for sRGB is clear.
  const CameraResponse& likelier() const;

 private:
  double evidence_ = 0;
  int looks_ = 0;
};

// How an edge's colours mix. The blur of a lens mixes the light of ball and background, in all channels
// alike; grey levels that are not proportional to the light mix otherwise, and each channel in a way of its
// own.

/// A pixel near the outline.
struct RingColor {
  float distance_px;  ///< outside the outline, negative inside
  cv::Vec3b bgr;
};

/// Sum of the squares (grey levels) that remain when the fitted edge, with levels and shading of its own in
/// each channel, is taken from the pixels under that response.
double squares_left(const std::vector<RingColor>& pixels, const EdgeProfileFit& edge,
                    const CameraResponse& response);

}  // namespace ballservo
