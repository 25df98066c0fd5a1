#include "app/comparison/estimators/vpdot2_peer.hpp"

#include <visp3/blob/vpDot2.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ballservo {
namespace {

vpImage<unsigned char> visp_picture(const cv::Mat& grey) {
  vpImage<unsigned char> picture(static_cast<unsigned>(grey.rows), static_cast<unsigned>(grey.cols));
  for (int v = 0; v < grey.rows; ++v) std::copy_n(grey.ptr(v), grey.cols, picture[static_cast<unsigned>(v)]);
  return picture;
}

}  // namespace

std::optional<OutlineEllipse> vpdot2_blob(const cv::Mat& bgr, int hue, const Eigen::Vector2d& click_px,
                                          const VpDot2Settings& settings) {
  cv::Mat grey;
  if (settings.mask) {
    grey = hsv_mask(bgr, hue, settings.hsv);
  } else {
    cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  }
  const int u = static_cast<int>(std::lround(click_px.x())), v = static_cast<int>(std::lround(click_px.y()));
  if (u < 0 || v < 0 || u >= grey.cols || v >= grey.rows) return std::nullopt;
  if (settings.mask && grey.at<unsigned char>(v, u) == 0) return std::nullopt;
  try {
    vpDot2 dot;
    dot.setGraphics(false);
    dot.setComputeMoments(true);
    dot.setEllipsoidShapePrecision(settings.roundness);
    dot.initTracking(visp_picture(grey), vpImagePoint(v, u));
    const OutlineEllipse blob{{dot.getCog().get_u(), dot.getCog().get_v()},
                              std::sqrt(std::max(0.0, dot.getArea()) / M_PI)};
    if (!blob.center_px.allFinite() || !(blob.radius_px > 0)) return std::nullopt;
    return blob;
  } catch (const vpException&) {  // no blob that it would track
    return std::nullopt;
  }
}

}  // namespace ballservo
