// Connected components of a chroma picture, at several strictnesses (paper, "Calibrage", 2b).
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

namespace ballservo {

/// How the modes are taken apart.
struct ComponentOptions {
  double chroma_radius = 6;    ///< how far apart one surface's chromas lie, in (u*, v*); above 0
  double min_chroma = 6;       ///< least distance from neutral that counts as colour; 0 or more
  double enough_pixels = 100;  ///< that a colour needs to be one; see `mode_labels`
};

/// The picture's own grey, (u*, v*): its fullest chroma among those near the axis, since the light is seldom
/// the white of sRGB. (0, 0) where hardly anything is grey.
cv::Vec2f neutral_chroma(const cv::Mat& modes);

/// A connected component.
struct Component {
  int label = 0, area = 0;
  int left = 0, top = 0, right = 0, bottom = 0;  ///< its box, inclusive
};

/// Takes the modes (CV_32FC2, continuous) apart in several ways and shows each to `visit`: every pixel's
/// label (-1: none), row by row. Neighbours of four are joined when both are far enough from neutral and
/// their modes are close enough, for several meanings of both; or when they climb to the same mode of the
/// picture's chroma histogram; or when both have the hue of one of its modes, in strengths of some part of
/// it.
void for_each_segmentation(const cv::Mat& modes, const cv::Mat3f& lab, const ComponentOptions& options,
                           const std::function<void(const std::vector<int>& labels)>& visit);

/// The components of such labels, in raster order of their first pixels.
std::vector<Component> components_of(const std::vector<int>& labels, int cols, int rows);

/// The component without its holes: CV_8U, 0 or 255, its box with a margin of one pixel all around.
cv::Mat filled_mask(const std::vector<int>& labels, int cols, const Component& component);

}  // namespace ballservo
