#include "calibration/teaching/chroma_picture.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "calibration/base/statistics.hpp"
#include "calibration/color/color_space.hpp"

namespace ballservo {
namespace {

constexpr double least_radius = 6, noise_factor = 3;  // in (u*, v*); in sigmas of the noise
constexpr float full_hue_chroma = 30;  // from here on hue means something: the metric has its full stretch

// sRGB's (u*, v*) lie in -84 to 176 and -135 to 108: cells of one unit, with a margin.
constexpr int u_low = -100, v_low = -150, u_cells = 300, v_cells = 280;

int histogram_cell(const cv::Vec2f& c) {
  const int u = std::clamp(static_cast<int>(std::lround(c[0])) - u_low, 0, u_cells - 1);
  const int v = std::clamp(static_cast<int>(std::lround(c[1])) - v_low, 0, v_cells - 1);
  return v * u_cells + u;
}

}  // namespace

ChromaMetric::ChromaMetric(float u, float v) {
  const float chroma = std::sqrt(u * u + v * v);
  const double stretch = 1 + (shading_stretch - 1) * std::min(1.0f, chroma / full_hue_chroma);
  const float weight =
      chroma > 0 ? static_cast<float>(std::sqrt(1 - 1 / (stretch * stretch))) / chroma : 0.0f;
  ray_u_ = weight * u;
  ray_v_ = weight * v;
}

cv::Mat3f lab_image(const cv::Mat& bgr) {
  cv::Mat3f result(bgr.size());
  std::transform(bgr.begin<cv::Vec3b>(), bgr.end<cv::Vec3b>(), result.begin(), [](const cv::Vec3b& c) {
    const Eigen::Vector3f lab = lab_from_bgr(c[0], c[1], c[2]).cast<float>();
    return cv::Vec3f(lab[0], lab[1], lab[2]);
  });
  return result;
}

cv::Mat chroma_image(const cv::Mat& bgr) {
  cv::Mat result(bgr.size(), CV_32FC2);
  std::transform(bgr.begin<cv::Vec3b>(), bgr.end<cv::Vec3b>(), result.begin<cv::Vec2f>(),
                 [](const cv::Vec3b& c) {
                   const Eigen::Vector3f luv = luv_from_bgr(c[0], c[1], c[2]).cast<float>();
                   return cv::Vec2f(luv[1], luv[2]);
                 });
  return result;
}

double chroma_noise(const cv::Mat& chroma) {
  std::vector<float> differences;
  differences.reserve(chroma.total() * 2);
  for (int y = 0; y < chroma.rows; ++y) {
    const cv::Vec2f* row = chroma.ptr<cv::Vec2f>(y);
    for (int x = 1; x < chroma.cols; ++x) {
      differences.push_back(std::abs(row[x][0] - row[x - 1][0]));
      differences.push_back(std::abs(row[x][1] - row[x - 1][1]));
    }
  }
  if (differences.empty()) return 0;
  return upper_median(differences) / (0.6745 * std::sqrt(2.0));  // the median of |N(0, 2 sigma^2)|
}

double chroma_radius(const cv::Mat& chroma) {
  return std::clamp(noise_factor * chroma_noise(chroma), least_radius, 4 * least_radius);
}

cv::Mat smoothed_chroma(const cv::Mat& chroma) {
  constexpr int side_px = 5;
  std::vector<cv::Mat> planes;
  cv::split(chroma, planes);
  for (cv::Mat& plane : planes) cv::medianBlur(plane, plane, side_px);
  cv::Mat result;
  cv::merge(planes, result);
  return result;
}

cv::Mat mode_labels(const cv::Mat& chroma, double bandwidth, double enough) {
  cv::Mat histogram = cv::Mat::zeros(v_cells, u_cells, CV_32F);
  auto* density = histogram.ptr<float>();
  for (int y = 0; y < chroma.rows; ++y) {
    const cv::Vec2f* row = chroma.ptr<cv::Vec2f>(y);
    for (int x = 0; x < chroma.cols; ++x) density[histogram_cell(row[x])] += 1;
  }
  histogram = cv::min(histogram, enough);
  cv::GaussianBlur(histogram, histogram, {}, bandwidth, bandwidth, cv::BORDER_CONSTANT);
  density = histogram.ptr<float>();
  // Every cell points to its highest neighbour (itself at a mode; the lowest index wins a tie); following the
  // pointers is mean shift with steps of one cell.
  std::vector<int> up(static_cast<std::size_t>(u_cells * v_cells));
  for (int v = 0, i = 0; v < v_cells; ++v) {
    for (int u = 0; u < u_cells; ++u, ++i) {
      int best = i;
      for (int nv = std::max(0, v - 1); nv <= std::min(v_cells - 1, v + 1); ++nv) {
        for (int nu = std::max(0, u - 1); nu <= std::min(u_cells - 1, u + 1); ++nu) {
          const int n = nv * u_cells + nu;
          if (density[n] > density[best] || (density[n] == density[best] && n < best)) best = n;
        }
      }
      up[i] = best;
    }
  }
  for (int& target : up) {
    while (up[target] != target) target = up[target];
  }
  cv::Mat result(chroma.size(), CV_32S);
  for (int y = 0; y < chroma.rows; ++y) {
    const cv::Vec2f* row = chroma.ptr<cv::Vec2f>(y);
    for (int x = 0; x < chroma.cols; ++x) result.at<int>(y, x) = up[histogram_cell(row[x])];
  }
  return result;
}

}  // namespace ballservo
