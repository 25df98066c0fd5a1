// Mean shift over position and chroma (paper, "Calibrage", 2a), blind to luminance.
#pragma once

#include <opencv2/core.hpp>

namespace ballservo {

/// How far mean shift looks.
struct MeanShiftOptions {
  int spatial_radius_px = 5;  ///< half side of the window; 1 to 50
  double chroma_radius = 6;   ///< of (u*, v*); above 0. It grows with the picture's noise, see `chroma_noise`
  double noise_factor = 3;    ///< chroma radius in noise sigmas; 0 or more
  double shading_stretch = 3;  ///< distances along the ray through grey count this many times less; 1 or more
  int max_iterations = 8;      ///< 1 or more
  double max_working_pixels = 1e6;  ///< larger pictures are worked on at a reduced scale; 1e4 or more

  /// Throws InputError with every value out of range.
  void validate() const;
};

/// How far apart two chromas are for one that stands at `u`, `v`: shading and highlights move a surface's
/// (u*, v*) along the ray through grey, so differences along it weigh less than differences of hue; near
/// grey, where there is no hue, all directions are alike.
class ChromaMetric {
 public:
  ChromaMetric(float u, float v, double shading_stretch);
  float squared(float du, float dv) const {
    const float along = du * ray_u_ + dv * ray_v_;
    return du * du + dv * dv - along * along;
  }

 private:
  float ray_u_, ray_v_;
};

/// (u*, v*) of every pixel, CV_32FC2, of a CV_8UC3 picture in BGR.
cv::Mat chroma_image(const cv::Mat& bgr);

/// The noise's standard deviation in a picture of `chroma_image`, from the median difference of neighbours.
double chroma_noise(const cv::Mat& chroma);

/// The radius that `options` give in this picture: the larger of the plain radius and noise_factor sigmas
/// (but at most four plain radii).
double chroma_radius(const cv::Mat& chroma, const MeanShiftOptions& options);

/// Every pixel's mode: the flat kernel's window (Comaniciu and Meer, PAMI 2002) moves to the mean of the
/// pixels within `radius` of its chroma until it stands still. Returns the modes' chromas, CV_32FC2.
cv::Mat mean_shift_filter(const cv::Mat& chroma, double radius, const MeanShiftOptions& options);

/// Mean shift in chroma alone: which mode of the picture's (u*, v*) histogram, smoothed by a Gaussian of
/// `bandwidth`, each pixel climbs to; CV_32S, equal numbers for equal modes. A cell counts at most `enough`
/// pixels, so that a large wall does not swallow the mode of a small ball beside it.
cv::Mat mode_labels(const cv::Mat& chroma, double bandwidth, double enough);

}  // namespace ballservo
