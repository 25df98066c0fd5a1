#include "perception/candidates/inner_edges.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace ballservo {
namespace {

// Sum over the channels of how two pixels differ.
int difference(const std::uint8_t* a, const std::uint8_t* b) {
  return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
}

constexpr int max_looks = 6000;         // pixels looked at; of a larger region every few lines alone
constexpr std::size_t max_edges = 256;  // the strongest
constexpr int min_step = 14;            // sum over the channels of the grey levels across an edge
// An edge is so many times as strong as the median of all looks (texture, noise).
constexpr double over_median = 3;
constexpr int shade_px = 3;
constexpr int clear_px = 2;  // inside the region's boundary, whose own edge is known

bool is_inside(const ColoredPixels& colored, int u, int v) {
  return colored.at(u - clear_px, v) && colored.at(u + clear_px, v) && colored.at(u, v - clear_px) &&
         colored.at(u, v + clear_px);
}

// Sobel's gradient of the channels, each with the sign that it has to the others, summed.
Eigen::Vector2f gradient(const cv::Mat& bgr, int u, int v) {
  const std::uint8_t *above = bgr.ptr(v - 1) + 3 * u, *here = bgr.ptr(v) + 3 * u,
                     *below = bgr.ptr(v + 1) + 3 * u;
  Eigen::Vector2f strongest(0, 0);
  for (int c = 0; c < 3; ++c) {
    const int right = above[c + 3] + 2 * here[c + 3] + below[c + 3],
              left = above[c - 3] + 2 * here[c - 3] + below[c - 3];
    const int down = below[c - 3] + 2 * below[c] + below[c + 3],
              up = above[c - 3] + 2 * above[c] + above[c + 3];
    const Eigen::Vector2f g(static_cast<float>(right - left), static_cast<float>(down - up));
    if (g.squaredNorm() > strongest.squaredNorm()) strongest = g;
  }
  return strongest;
}

}  // namespace

InnerEdges::InnerEdges() { peaks_.reserve(max_looks); }

void InnerEdges::find(const cv::Mat& bgr, const ColoredPixels& colored, const RayTable& rays,
                      const cv::Rect& box, int region_pixels, std::vector<InnerEdge>& edges) {
  edges.clear();
  peaks_.clear();
  histogram_.fill(0);
  const cv::Rect known(colored.window, colored.pixels.size());
  const cv::Rect inside = box & cv::Rect(known.x + clear_px, known.y + clear_px, known.width - 2 * clear_px,
                                         known.height - 2 * clear_px);
  if (inside.width < 3 || inside.height < 3) return;
  const int stride = std::max(4, (2 * region_pixels + max_looks - 1) / max_looks);
  for (int v = inside.y + stride / 2; v < inside.br().y; v += stride)
    look_along(bgr, colored, {inside.x, v}, {1, 0}, inside.width);
  for (int u = inside.x + stride / 2; u < inside.br().x; u += stride)
    look_along(bgr, colored, {u, inside.y}, {0, 1}, inside.height);
  keep_strong();
  for (const Peak& peak : peaks_) {
    const Eigen::Vector2f across = gradient(bgr, peak.u_px, peak.v_px);
    const auto position = rays.undistorted_px(peak.u_px, peak.v_px);
    if (position && !across.isZero()) edges.push_back({*position, across.normalized()});
  }
}

// Where along a line of pixels the steps between the two beside a pixel are largest.
void InnerEdges::look_along(const cv::Mat& bgr, const ColoredPixels& colored, cv::Point first,
                            cv::Point along, int length) {
  steps_.assign(static_cast<std::size_t>(length), 0);
  const std::ptrdiff_t next = along.x * 3 + along.y * static_cast<std::ptrdiff_t>(bgr.step);
  const std::uint8_t* pixel = bgr.ptr(first.y) + 3 * first.x;
  const cv::Point known = first - colored.window;
  const std::uint64_t* row = colored.pixels.row(known.y);
  const std::ptrdiff_t next_row = along.y * colored.pixels.row_words();
  auto column = static_cast<unsigned>(known.x);
  const auto next_column = static_cast<unsigned>(along.x);
  for (int& step : steps_) {
    if (row[column / BitPicture::word_bits] >> (column % BitPicture::word_bits) & 1) {
      step = difference(pixel + next, pixel - next);
      ++histogram_[static_cast<std::size_t>(std::min(step, 255))];
    }
    pixel += next;
    row += next_row;
    column += next_column;
  }
  // An edge is over after three pixels; shade goes on.
  for (int i = shade_px; i + shade_px < length; ++i) {
    const int* const step = &steps_[static_cast<std::size_t>(i)];
    if (*step < min_step || *step <= step[-1] || *step < step[1]) continue;
    if (*step < step[-shade_px] + step[shade_px]) continue;
    const int u = first.x + i * along.x, v = first.y + i * along.y;
    if (peaks_.size() < peaks_.capacity() && is_inside(colored, u, v)) peaks_.push_back({u, v, *step});
  }
}

void InnerEdges::keep_strong() {
  int looks = 0;
  for (const int count : histogram_) looks += count;
  int median = 0;
  for (int below = histogram_[0]; 2 * below < looks;) below += histogram_[static_cast<std::size_t>(++median)];
  const int least = static_cast<int>(std::lround(over_median * median));
  peaks_.erase(std::remove_if(peaks_.begin(), peaks_.end(), [&](const Peak& p) { return p.step < least; }),
               peaks_.end());
  if (peaks_.size() <= max_edges) return;
  // Equals in raster order, so that the choice is the same everywhere.
  std::nth_element(
      peaks_.begin(), peaks_.begin() + static_cast<std::ptrdiff_t>(max_edges), peaks_.end(),
      [](const Peak& a, const Peak& b) {
        return a.step != b.step ? a.step > b.step : a.v_px != b.v_px ? a.v_px < b.v_px : a.u_px < b.u_px;
      });
  peaks_.resize(max_edges);
}

}  // namespace ballservo
