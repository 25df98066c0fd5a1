#include "calibration/teaching/mean_shift.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "calibration/base/statistics.hpp"
#include "calibration/color/color_space.hpp"

namespace ballservo {
namespace {

constexpr int spatial_radius_px = 5;  // half side of the window
constexpr int max_iterations = 8;
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

cv::Mat chroma_image(const cv::Mat& bgr) {
  cv::Mat result(bgr.size(), CV_32FC2);
  for (int y = 0; y < bgr.rows; ++y) {
    const cv::Vec3b* in = bgr.ptr<cv::Vec3b>(y);
    cv::Vec2f* out = result.ptr<cv::Vec2f>(y);
    for (int x = 0; x < bgr.cols; ++x) {
      const Eigen::Vector3d luv = luv_from_bgr(in[x][0], in[x][1], in[x][2]);
      out[x] = {static_cast<float>(luv[1]), static_cast<float>(luv[2])};
    }
  }
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

cv::Mat mean_shift_filter(const cv::Mat& chroma, double radius) {
  cv::Mat result(chroma.size(), CV_32FC2);
  const int reach = spatial_radius_px;
  const float limit = static_cast<float>(radius * radius);
  for (int y = 0; y < chroma.rows; ++y) {
    for (int x = 0; x < chroma.cols; ++x) {
      cv::Vec2f mode = chroma.at<cv::Vec2f>(y, x);
      float mode_x = static_cast<float>(x), mode_y = static_cast<float>(y);
      for (int iteration = 0; iteration < max_iterations; ++iteration) {
        const ChromaMetric metric(mode[0], mode[1]);
        const int at_x = static_cast<int>(std::lround(mode_x)), at_y = static_cast<int>(std::lround(mode_y));
        const int left = std::max(0, at_x - reach), right = std::min(chroma.cols - 1, at_x + reach);
        float sum_u = 0, sum_v = 0, sum_x = 0, sum_y = 0, count = 0;
        for (int py = std::max(0, at_y - reach); py <= std::min(chroma.rows - 1, at_y + reach); ++py) {
          const cv::Vec2f* row = chroma.ptr<cv::Vec2f>(py);
          float row_count = 0;
          for (int px = left; px <= right; ++px) {
            const float inside =
                metric.squared(row[px][0] - mode[0], row[px][1] - mode[1]) <= limit ? 1.0f : 0.0f;
            sum_u += inside * row[px][0];
            sum_v += inside * row[px][1];
            sum_x += inside * static_cast<float>(px);
            row_count += inside;
          }
          sum_y += row_count * static_cast<float>(py);
          count += row_count;
        }
        if (count == 0) break;  // the mean moved between groups that are all out of reach
        const cv::Vec2f moved(sum_u / count, sum_v / count);
        const float shift = metric.squared(moved[0] - mode[0], moved[1] - mode[1]);
        const float step = std::abs(sum_x / count - mode_x) + std::abs(sum_y / count - mode_y);
        mode = moved;
        mode_x = sum_x / count;
        mode_y = sum_y / count;
        if (shift < 0.01f * limit && step < 1) break;
      }
      result.at<cv::Vec2f>(y, x) = mode;
    }
  }
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
