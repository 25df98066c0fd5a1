#include "perception/floor_finder.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

namespace {

// Of the bins; a Gaussian of 0.7 and one of 2.5 bins.
constexpr float chroma_kernel[] = {0.570F, 0.206F};
constexpr float light_kernel[] = {0.161F, 0.149F, 0.117F, 0.078F, 0.045F, 0.022F, 0.009F};
// Colours with less than this of the floor's pixels in their bin are not floor, and so are brightnesses.
constexpr double rare_chroma = 0.004, rare_light = 0.002;
constexpr double renewal = 0.02;      // of what is known of the floor, by each frame
constexpr double known_growth = 1.4;  // of what is known to be round, for its shadow
constexpr int light_bins_an_octave = 8;
constexpr std::size_t least_run = 2;  // pixels of a path, for an edge

}  // namespace

FloorFinder::FloorFinder(std::vector<FloorPath> paths) : paths_(std::move(paths)) {
  for (const FloorPath& path : paths_) {
    samples_.emplace_back(path.pixels.size());
    floor_.emplace_back(path.pixels.size(), 0);
    for (const cv::Point& p : path.pixels) box_ |= cv::Rect(p, cv::Size(1, 1));
  }
  edges_.resize(paths_.size());
  for (std::size_t sum = 0; sum < light_bin_.size(); ++sum) {
    const double octaves = std::log2(1.0 + static_cast<double>(sum) / 3.0);
    light_bin_[sum] = static_cast<std::uint8_t>(std::min(octaves * light_bins_an_octave, light_bins - 1.0));
  }
}

void FloorFinder::sample(const cv::Mat& bgr, const OutlineEllipse* known) {
  const double known_px = known != nullptr ? known->radius_px * known_growth : 0.0;
  for (std::size_t k = 0; k < paths_.size(); ++k) {
    for (std::size_t i = 0; i < paths_[k].pixels.size(); ++i) {
      const cv::Point& p = paths_[k].pixels[i];
      const int u = std::clamp(p.x, 1, bgr.cols - 2), v = std::clamp(p.y, 1, bgr.rows - 2);
      cv::Vec3i sums;
      for (int row = v - 1; row <= v + 1; ++row) {
        const cv::Vec3b* const at = bgr.ptr<cv::Vec3b>(row) + u;
        for (const int column : {-1, 0, 1}) sums += at[column];
      }
      const int sum = sums[0] + sums[1] + sums[2] + 27;
      const auto bin = [&](int c) { return std::min(chroma_bins - 1, (sums[c] + 9) * chroma_bins / sum); };
      Sample& sample = samples_[k][i];
      sample.chroma = static_cast<std::uint16_t>(bin(2) * chroma_bins + bin(1));
      sample.light = light_bin_[static_cast<std::size_t>((sum - 27) / 9)];
      sample.known =
          known != nullptr && std::hypot(p.x - known->center_px.x(), p.y - known->center_px.y()) < known_px;
    }
  }
}

/// Adds the pixels that are certain: at first as told, later close ones that were found to be floor.
void FloorFinder::learn(bool first) {
  double count = 0;
  const auto each = [&](const auto& visit) {
    for (std::size_t k = 0; k < paths_.size(); ++k) {
      const std::size_t certain = std::min(paths_[k].certain, samples_[k].size());
      for (std::size_t i = 0; i < certain; ++i) {
        if (!samples_[k][i].known && (first || i < edges_[k].end)) visit(samples_[k][i]);
      }
    }
  };
  each([&count](const Sample&) { ++count; });
  if (count == 0) return;
  const auto share = static_cast<float>((first ? 1.0 : renewal) / count);
  const auto kept = static_cast<float>(first ? 0.0 : 1.0 - renewal);
  for (float& value : counted_.chroma) value *= kept;
  for (float& value : counted_.light) value *= kept;
  each([&](const Sample& s) {
    counted_.chroma[s.chroma] += share;
    counted_.light[s.light] += share;
  });
  smooth();
}

void FloorFinder::smooth() {
  smoothed_.chroma.fill(0);
  for (int r = 0; r < chroma_bins; ++r) {
    for (int g = 0; g < chroma_bins; ++g) {
      const float value = counted_.chroma[static_cast<std::size_t>(r * chroma_bins + g)];
      if (value == 0) continue;
      for (int y = std::max(0, r - 1); y <= std::min(chroma_bins - 1, r + 1); ++y) {
        for (int x = std::max(0, g - 1); x <= std::min(chroma_bins - 1, g + 1); ++x) {
          smoothed_.chroma[static_cast<std::size_t>(y * chroma_bins + x)] +=
              value * chroma_kernel[std::abs(y - r)] * chroma_kernel[std::abs(x - g)];
        }
      }
    }
  }
  smoothed_.light.fill(0);
  constexpr int reach = static_cast<int>(std::size(light_kernel)) - 1;
  for (int l = 0; l < light_bins; ++l) {
    for (int x = std::max(0, l - reach); x <= std::min(light_bins - 1, l + reach); ++x) {
      smoothed_.light[static_cast<std::size_t>(x)] +=
          counted_.light[static_cast<std::size_t>(l)] * light_kernel[std::abs(x - l)];
    }
  }
}

/// Each pixel by its own looks, then by the majority of its neighbours.
void FloorFinder::judge() {
  for (auto& path : samples_) {
    for (Sample& s : path) {
      s.floor = s.known || (static_cast<double>(smoothed_.chroma[s.chroma]) >= rare_chroma &&
                            static_cast<double>(smoothed_.light[s.light]) >= rare_light);
    }
  }
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    for (std::size_t i = 0; i < samples_[k].size(); ++i) {
      int floor = 0, all = 0;
      for (std::size_t n = k == 0 ? 0 : k - 1; n <= std::min(k + 1, samples_.size() - 1); ++n) {
        for (std::size_t j = i == 0 ? 0 : i - 1; j <= i + 1 && j < samples_[n].size(); ++j) {
          ++all;
          floor += samples_[n][j].floor ? 1 : 0;
        }
      }
      floor_[k][i] = 2 * floor >= all ? 1 : 0;
    }
  }
}

/// The first run that is not floor, and the first after it that is.
void FloorFinder::trace() {
  for (std::size_t k = 0; k < floor_.size(); ++k) {
    const std::vector<char>& floor = floor_[k];
    const auto run_of = [&floor](char what, std::size_t from) {
      std::size_t run = 0;
      for (std::size_t i = from; i < floor.size(); ++i) {
        run = floor[i] == what ? run + 1 : 0;
        if (run == least_run) return i + 1 - least_run;
      }
      return floor.size();
    };
    edges_[k].end = run_of(0, 0);
    edges_[k].again = run_of(1, edges_[k].end);
  }
}

const std::vector<FloorEdge>& FloorFinder::look(const cv::Mat& bgr, const OutlineEllipse* known) {
  const bool inside = (box_ & cv::Rect({0, 0}, bgr.size())) == box_ && bgr.cols > 2 && bgr.rows > 2;
  if (paths_.empty() || bgr.type() != CV_8UC3 || !inside) return nothing_;
  sample(bgr, known);
  if (!started_) learn(true);
  started_ = true;
  judge();
  trace();
  const bool any =
      std::any_of(edges_.begin(), edges_.end(), [](const FloorEdge& edge) { return edge.end > 0; });
  if (!any) return nothing_;
  learn(false);
  return edges_;
}

}  // namespace ballservo
