// What a detector may be told.
#pragma once

#include <cstdint>
#include <vector>

#include "calibration/color/color_table.hpp"
#include "perception/outline/ball_fitter.hpp"

namespace ballservo {

/// How the camera's grey levels follow the light: stated, or told by noise and by how the balls' edges look.
enum class ResponseChoice { by_picture, linear, srgb };

struct DetectorOptions {
  BallFit fit = BallFit::sphere;
  ResponseChoice response = ResponseChoice::by_picture;
  /// The pictures come from where colours are stored at half the resolution of brightness: a video, a JPEG
  /// file. Otherwise the edges of balls tell whether they once did.
  bool coarse_chroma = false;
  /// The radius of each class's balls; class k is entry k - 1. Empty or 0: not known, no position in 3-D.
  std::vector<BallRadius> radii;
  /// Where no camera was given: how far outlines may depart from circles (see one_gauss_newton_step).
  double oval_fraction = 0;
  std::uint64_t seed = 0;
  static constexpr int most_threads = 64;
  int threads = 1;  ///< that share the rows of a picture (classification); the same result with any number

  /// 0 where it is not known.
  BallRadius radius_of(ClassIndex color_class) const;
  /// Throws InputError naming every value that makes no sense.
  void validate() const;
};

}  // namespace ballservo
