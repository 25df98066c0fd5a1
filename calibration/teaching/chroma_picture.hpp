// A picture's chroma, blind to luminance, and its modes (paper, "Calibrage", 2a).
#pragma once

#include <opencv2/core.hpp>

namespace ballservo {

/// Differences along the ray through grey count this many times less.
inline constexpr double shading_stretch = 3;

/// How far apart two chromas are for one that stands at `u`, `v`: shading and highlights move a surface's
/// (u*, v*) along the ray through grey, so differences along it weigh less than differences of hue; near
/// grey, where there is no hue, all directions are alike.
class ChromaMetric {
 public:
  ChromaMetric(float u, float v);
  float squared(float du, float dv) const {
    const float along = du * ray_u_ + dv * ray_v_;
    return du * du + dv * dv - along * along;
  }

 private:
  float ray_u_, ray_v_;
};

/// (L, a, b) of every pixel of a CV_8UC3 picture in BGR.
cv::Mat3f lab_image(const cv::Mat& bgr);

/// (u*, v*) of every pixel, CV_32FC2, of a CV_8UC3 picture in BGR.
cv::Mat chroma_image(const cv::Mat& bgr);

/// The noise's standard deviation in a picture of `chroma_image`, from the median difference of neighbours.
double chroma_noise(const cv::Mat& chroma);

/// How far apart chromas of one surface may lie in this picture: 6, or three sigmas of its noise, but at
/// most 24.
double chroma_radius(const cv::Mat& chroma);

/// The median of 5 x 5 pixels, in u* and in v*: takes the noise and keeps the edges.
cv::Mat smoothed_chroma(const cv::Mat& chroma);

/// Mean shift in chroma alone: which mode of the picture's (u*, v*) histogram, smoothed by a Gaussian of
/// `bandwidth`, each pixel climbs to; CV_32S, equal numbers for equal modes. A cell counts at most `enough`
/// pixels, so that a large wall does not swallow the mode of a small ball beside it.
cv::Mat mode_labels(const cv::Mat& chroma, double bandwidth, double enough);

}  // namespace ballservo
