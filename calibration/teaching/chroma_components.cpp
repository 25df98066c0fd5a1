#include "calibration/teaching/chroma_components.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "calibration/teaching/chroma_picture.hpp"

namespace ballservo {
namespace {

constexpr std::array<double, 2> link_factors = {0.5, 1.5};         // of the chroma radius
constexpr std::array<double, 3> chroma_factors = {1.0, 2.0, 5.0};  // of the least chroma
constexpr std::array<double, 2> bandwidth_factors = {0.5, 1.5};    // of the chroma radius
constexpr std::array<double, 2> strength_factors = {0.3, 0.6};     // of a hue's own strength
constexpr double hue_reach_rad = 0.4;                              // 23 degrees to either side
constexpr std::array<float, 3> color_steps = {1, 2, 4};  // Lab, from pixel to pixel of a smooth surface
constexpr std::size_t most_hues = 10;  // the fullest modes come first; what follows is clutter
constexpr int grey_reach = 15;         // how far from sRGB's grey axis the light may push a grey thing

/// Sets of pixels that grow together, by path halving.
class PixelSets {
 public:
  explicit PixelSets(int count) : parent_(static_cast<std::size_t>(count)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(int i, int j) {
    i = find(i);
    j = find(j);
    if (i != j) parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<int> parent_;
};

/// Joins neighbours (of four) that are both `eligible` and `alike`; every pixel's set, or -1.
template <class Eligible, class Alike>
std::vector<int> connect(int cols, int rows, Eligible eligible, Alike alike) {
  PixelSets sets(cols * rows);
  std::vector<int> labels(static_cast<std::size_t>(cols * rows), -1);
  for (int y = 0, i = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x, ++i) {
      if (!eligible(i)) continue;
      labels[i] = i;
      if (x + 1 < cols && eligible(i + 1) && alike(i, i + 1)) sets.join(i, i + 1);
      if (y + 1 < rows && eligible(i + cols) && alike(i, i + cols)) sets.join(i, i + cols);
    }
  }
  for (int& label : labels) {
    if (label >= 0) label = sets.find(label);
  }
  return labels;
}

/// The mean chromas of the picture's modes that are far enough from grey, the fullest first.
std::vector<cv::Vec2f> strong_hues(const cv::Mat& centered, const ComponentOptions& options) {
  const cv::Mat labels = mode_labels(centered, 0.5 * options.chroma_radius, options.enough_pixels);
  std::map<int, std::pair<cv::Vec2d, double>> sums;
  for (std::size_t i = 0; i < centered.total(); ++i) {
    auto& [sum, count] = sums[labels.ptr<int>()[i]];
    sum += cv::Vec2d(centered.ptr<cv::Vec2f>()[i]);
    count += 1;
  }
  std::vector<std::pair<double, cv::Vec2f>> found;
  for (const auto& [label, mode] : sums) {
    const cv::Vec2f mean(mode.first / mode.second);
    if (mode.second >= 0.5 * options.enough_pixels &&
        mean.dot(mean) >= options.min_chroma * options.min_chroma)
      found.emplace_back(mode.second, mean);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  if (found.size() > most_hues) found.resize(most_hues);
  std::vector<cv::Vec2f> hues;
  for (const auto& [count, mean] : found) hues.push_back(mean);
  return hues;
}

}  // namespace

cv::Vec2f neutral_chroma(const cv::Mat& modes) {
  constexpr int side = 2 * grey_reach + 1;
  cv::Mat histogram = cv::Mat::zeros(side, side, CV_32F);
  float total = 0;
  for (int y = 0; y < modes.rows; ++y) {
    const cv::Vec2f* row = modes.ptr<cv::Vec2f>(y);
    for (int x = 0; x < modes.cols; ++x) {
      if (row[x].dot(row[x]) > static_cast<float>(grey_reach * grey_reach)) continue;
      histogram.at<float>(static_cast<int>(std::lround(row[x][1])) + grey_reach,
                          static_cast<int>(std::lround(row[x][0])) + grey_reach) += 1;
      total += 1;
    }
  }
  if (total < 0.1f * static_cast<float>(modes.total())) return {0, 0};
  cv::GaussianBlur(histogram, histogram, {}, 1.5, 1.5, cv::BORDER_CONSTANT);
  cv::Point peak;
  cv::minMaxLoc(histogram, nullptr, nullptr, nullptr, &peak);
  return {static_cast<float>(peak.x - grey_reach), static_cast<float>(peak.y - grey_reach)};
}

void for_each_segmentation(const cv::Mat& modes, const cv::Mat3f& lab, const ComponentOptions& options,
                           const std::function<void(const std::vector<int>& labels)>& visit) {
  const int cols = modes.cols, rows = modes.rows;
  const cv::Vec2f neutral = neutral_chroma(modes);
  const cv::Mat centered = modes - cv::Scalar(neutral[0], neutral[1]);
  const auto* chroma = centered.ptr<cv::Vec2f>();
  for (const double chroma_factor : chroma_factors) {
    const auto least = static_cast<float>(chroma_factor * options.min_chroma);
    const auto colored = [&](int i) { return chroma[i].dot(chroma[i]) >= least * least; };
    for (const double link_factor : link_factors) {
      const auto link = static_cast<float>(link_factor * options.chroma_radius);
      visit(connect(cols, rows, colored, [&](int i, int j) {
        return ChromaMetric(chroma[i][0], chroma[i][1])
                   .squared(chroma[j][0] - chroma[i][0], chroma[j][1] - chroma[i][1]) <= link * link;
      }));
    }
  }
  const cv::Vec3f* color = lab.ptr<cv::Vec3f>();
  for (const float step : color_steps) {
    visit(connect(
        cols, rows, [](int) { return true; },
        [&](int i, int j) {
          const cv::Vec3f d = color[i] - color[j];
          return d.dot(d) <= step * step;
        }));
  }
  for (const double bandwidth_factor : bandwidth_factors) {
    const cv::Mat labels =
        mode_labels(modes, bandwidth_factor * options.chroma_radius, options.enough_pixels);
    const auto* mode = labels.ptr<int>();
    visit(connect(
        cols, rows, [](int) { return true; }, [mode](int i, int j) { return mode[i] == mode[j]; }));
  }
  // A marbled ball is of one hue in several strengths, and blur mixes its rim with grey: along the ray
  // through grey, from a part of the hue's strength on.
  for (const cv::Vec2f& hue : strong_hues(centered, options)) {
    const auto strength = static_cast<float>(cv::norm(hue));
    const cv::Vec2f along = hue / strength, across(-along[1], along[0]);
    const auto steepest = static_cast<float>(std::tan(hue_reach_rad));
    for (const double factor : strength_factors) {
      const auto least = static_cast<float>(factor) * strength;
      const auto of_hue = [&](int i) {
        const float ahead = chroma[i].dot(along);
        return ahead >= least && std::abs(chroma[i].dot(across)) <= steepest * ahead;
      };
      visit(connect(cols, rows, of_hue, [](int, int) { return true; }));
    }
  }
}

std::vector<Component> components_of(const std::vector<int>& labels, int cols, int rows) {
  std::vector<int> slot(labels.size(), -1);
  std::vector<Component> result;
  for (int y = 0, i = 0; y < rows; ++y) {
    for (int x = 0; x < cols; ++x, ++i) {
      if (labels[i] < 0) continue;
      int& at = slot[labels[i]];
      if (at < 0) {
        at = static_cast<int>(result.size());
        result.push_back({labels[i], 0, x, y, x, y});
      }
      Component& c = result[at];
      ++c.area;
      c.left = std::min(c.left, x);
      c.right = std::max(c.right, x);
      c.bottom = y;
    }
  }
  return result;
}

cv::Mat filled_mask(const std::vector<int>& labels, int cols, const Component& c) {
  cv::Mat mask(c.bottom - c.top + 3, c.right - c.left + 3, CV_8U, cv::Scalar(255));
  for (int y = c.top; y <= c.bottom; ++y) {
    for (int x = c.left; x <= c.right; ++x) {
      if (labels[y * cols + x] == c.label) mask.at<std::uint8_t>(y - c.top + 1, x - c.left + 1) = 0;
    }
  }
  cv::floodFill(mask, {0, 0}, cv::Scalar(128));  // what can be reached from the margin lies outside
  return mask != 128;
}

}  // namespace ballservo
