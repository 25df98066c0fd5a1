// How a camera's grey levels follow the light that falls on its pixels, and what coding left of their
// colours.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "perception/outline/edge_model.hpp"

namespace ballservo {

/// A grey level between the whole ones, and d light / d grey level there.
struct GreyLevel {
  double level, slope;
};

/// One camera's response, the same for its three channels.
struct CameraResponse {
  std::array<float, 256> light{};  ///< of each grey level, 0 to 255
  std::array<float, 256> slope{};  ///< d light / d grey level
  /// Grey level of the light k^2 / 255.
  static constexpr int root_cells = 255;
  std::array<float, root_cells + 1> level_of_root{};
  /// Colours are stored at half the resolution of brightness, as most JPEG files and videos and all webcams
  /// do: an edge is sharp in luma (Rec. 601) alone.
  bool coarse_chroma = false;

  /// The grey level that shows this much light, below the first in a straight line.
  GreyLevel shown(double of_light) const;

  /// Grey levels that are proportional to the light, as of machine-vision cameras and most renderers.
  static const CameraResponse& linear(bool coarse_chroma = false);
  /// As of pictures made to be looked at: IEC 61966-2-1, close to the power 2.2.
  static const CameraResponse& srgb(bool coarse_chroma = false);
};

/// What a picture says of the camera.
struct ResponseEvidence {
  double srgb = 0;           ///< of edges: ln of the likelihoods' ratio of sRGB and linear response
  double coarse_chroma = 0;  ///< edges whose colours are blurred more than their brightness, less the others
  double srgb_by_noise = 0;  ///< see noise_response.hpp
};

/// What is believed of one camera, from what balls' edges and the pictures' noise say. A picture that people
/// look at is sRGB unless strong evidence is against it. The edges of one picture may leave it open, and a
/// video that was resampled as grey levels may leave it open for ever, so looks are counted.
class ResponseBelief {
 public:
  /// `coarse_chroma`: that the colours are coarse is known.
  explicit ResponseBelief(bool coarse_chroma = false)
      : coarse_chroma_(coarse_chroma ? settled_chroma : prior_chroma) {}
  /// Of one picture and its balls together.
  void add(const ResponseEvidence& evidence);
  /// Is it worth while to look at more edges?
  bool open() const;
  /// And at its noise?
  bool asks_noise() const { return !coarse_chroma() && std::abs(srgb_) < settled_response; }

  bool srgb() const { return coarse_chroma() || srgb_ > 0; }
  bool coarse_chroma() const { return coarse_chroma_ > 0; }

  /// A response that is not believed, with its probability.
  struct Alternative {
    const CameraResponse* response;
    double probability;
  };
  std::array<Alternative, 2> alternatives() const;

 private:
  // Of sRGB, and against coarse colours: what noise makes the edges of one picture say now and then.
  static constexpr double prior = 3.5, prior_chroma = -5;
  // Beyond them no picture could turn the belief at once.
  static constexpr double settled_response = 30, settled_chroma = 30;
  double srgb_ = prior, coarse_chroma_;
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
