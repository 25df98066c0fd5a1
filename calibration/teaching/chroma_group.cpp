#include "calibration/teaching/chroma_group.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace ballservo {
namespace {

constexpr int side = ChromaHistogram::side;
constexpr double kept_fraction = 0.98, core_fraction = 0.70;
constexpr double smoothing_cells = 1.0;
constexpr int closing_radius_cells = 3;
constexpr double reach_low = 0.85,
                 reach_high = 1.18;     // a, b of a light of 0.61 to 1.64 times the strength: cube roots
constexpr double reach_hue_rad = 0.07;  // 4 degrees: another white balance
constexpr float reach_weight = 0.25f;   // what was not seen counts less than what was

/// The density above which cells together hold `fraction` of the whole.
float level_holding(const cv::Mat1f& density, double fraction) {
  std::vector<float> values;
  std::copy_if(density.begin(), density.end(), std::back_inserter(values), [](float v) { return v > 0; });
  std::sort(values.begin(), values.end(), std::greater<>());
  double total = 0, sum = 0;
  for (const float value : values) total += value;
  for (const float value : values) {
    sum += value;
    if (sum >= fraction * total) return value;
  }
  return 0;
}

cv::Mat1b fullest_component(const cv::Mat1b& cells, const cv::Mat1f& density) {
  cv::Mat1i labels;
  const int count = cv::connectedComponents(cells, labels, 8, CV_32S);
  std::vector<double> mass(static_cast<std::size_t>(count), 0);
  for (int i = 0; i < side * side; ++i) mass[labels(i / side, i % side)] += density(i / side, i % side);
  mass[0] = -1;
  const auto best = static_cast<int>(std::max_element(mass.begin(), mass.end()) - mass.begin());
  return labels == best;
}

}  // namespace

ChromaHistogram chroma_histogram(const ColorSamples& samples) {
  ChromaHistogram result;
  for (const ColorSamples::Pixel& pixel : samples.pixels) ++result.counts[pixel.chroma_cell];
  return result;
}

ChromaGroup chroma_group(const ChromaHistogram& histogram) {
  ChromaGroup group;
  cv::Mat1f density(side, side);
  for (int i = 0; i < side * side; ++i) density(i / side, i % side) = static_cast<float>(histogram.counts[i]);
  const double total = cv::sum(density)[0];
  group.cells = cv::Mat1b::zeros(side, side);
  group.core = group.cells.clone();
  group.density = cv::Mat1f::zeros(side, side);
  if (total <= 0) return group;
  cv::GaussianBlur(density, density, {}, smoothing_cells, smoothing_cells, cv::BORDER_CONSTANT);
  density /= cv::sum(density)[0];

  constexpr int width = 2 * closing_radius_cells + 1;
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {width, width});
  cv::Mat1b cells = density >= level_holding(density, kept_fraction);
  cv::morphologyEx(cells, cells, cv::MORPH_CLOSE, disc);
  cells = fullest_component(cells, density);
  group.core = (density >= level_holding(density, core_fraction)) & cells;

  // No cell reaches further than this: `cells` elsewhere need not be looked for.
  double longest = 0;
  for (int i = 0; i < side * side; ++i) {
    if (cells(i / side, i % side))
      longest = std::max(longest, std::hypot(i % side + 1 - side / 2, i / side + 1 - side / 2));
  }
  const int reach = 2 + static_cast<int>(longest * reach_high * (1 / reach_low - 1 + reach_hue_rad));
  cv::Mat1b near;
  cv::dilate(cells, near, cv::Mat1b::ones(2 * reach + 1, 2 * reach + 1), {-1, -1}, 1, cv::BORDER_CONSTANT,
             cv::Scalar(0));

  // A closed hole holds next to nothing: let it count as the reach does.
  const auto floor = static_cast<float>(0.01 / std::max(1, cv::countNonZero(cells)));
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      if (!near(row, column)) continue;
      const double a = column + 0.5 - side / 2, b = row + 0.5 - side / 2;
      float best = cells(row, column) ? std::max(density(row, column), floor) : 0.0f;
      const double chroma = std::hypot(a, b);
      const int steps = 1 + static_cast<int>(std::ceil(2 * chroma * (reach_high - reach_low)));
      const int turns = static_cast<int>(std::ceil(2 * chroma * reach_hue_rad));
      for (int turn = -turns; turn <= turns; ++turn) {
        const double angle = turns > 0 ? reach_hue_rad * turn / turns : 0.0;
        const double turned_a = std::cos(angle) * a - std::sin(angle) * b;
        const double turned_b = std::sin(angle) * a + std::cos(angle) * b;
        for (int i = 0; i <= steps; ++i) {
          const double stretch = reach_low + (reach_high - reach_low) * i / steps;
          const int from_column = static_cast<int>(std::floor(turned_a / stretch + side / 2));
          const int from_row = static_cast<int>(std::floor(turned_b / stretch + side / 2));
          if (from_column < 0 || from_row < 0 || from_column >= side || from_row >= side) continue;
          if (!cells(from_row, from_column)) continue;
          best = std::max(best, reach_weight * std::max(density(from_row, from_column), floor));
        }
      }
      group.density(row, column) = best;
    }
  }
  group.cells = group.density > 0;
  return group;
}

}  // namespace ballservo
