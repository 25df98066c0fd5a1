#include "calibration/teaching/circle_seeds.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ballservo {
namespace {

constexpr int radii_per_octave = 4;
constexpr std::size_t most_per_octave = 45;  // true balls are among the first 20 of theirs, hidden ones 40
constexpr float least_gradient = 1,
                full_gradient = 4;  // Lab a pixel; from the latter on, half a vote and more

struct Seed {
  Outline outline;
  double votes = 0;  // of its circumference
};

void sort_by_votes(std::vector<Seed>& seeds) {
  std::stable_sort(seeds.begin(), seeds.end(),
                   [](const Seed& a, const Seed& b) { return a.votes > b.votes; });
}

/// Where the colour changes, along which unit vector of either sign, and how surely.
struct Gradient {
  cv::Vec2f place, direction;
  float weight = 0;
};

/// The main axis of the colour's changes (Di Zenzo, 1986).
Gradient gradient_at(const cv::Mat3f& lab, int x, int y) {
  const cv::Vec3f along_x = (lab(y, x + 1) - lab(y, x - 1)) * 0.5F,
                  along_y = (lab(y + 1, x) - lab(y - 1, x)) * 0.5F;
  const float xx = along_x.dot(along_x), xy = along_x.dot(along_y), yy = along_y.dot(along_y);
  const float spread = std::sqrt((xx - yy) * (xx - yy) + 4 * xy * xy), strongest = (xx + yy + spread) / 2;
  if (strongest < least_gradient * least_gradient) return {};
  cv::Vec2f axis = xx > yy ? cv::Vec2f(strongest - yy, xy) : cv::Vec2f(xy, strongest - xx);
  const auto length = static_cast<float>(cv::norm(axis));
  if (!(length > 0)) return {};
  const float magnitude = std::sqrt(strongest);
  return {cv::Vec2f(static_cast<float>(x), static_cast<float>(y)), axis / length,
          magnitude / (magnitude + full_gradient) * spread / (xx + yy)};
}

std::vector<Gradient> gradients_of(const cv::Mat3f& lab) {
  std::vector<Gradient> gradients;
  for (int y = 1; y + 1 < lab.rows; ++y) {
    for (int x = 1; x + 1 < lab.cols; ++x) {
      const Gradient gradient = gradient_at(lab, x, y);
      if (gradient.weight > 0) gradients.push_back(gradient);
    }
  }
  return gradients;
}

/// The circles of one radius for which more speaks than for those next to them.
std::vector<Seed> peaks_of(const std::vector<Gradient>& gradients, const cv::Size& size, float radius_px) {
  cv::Mat1f votes = cv::Mat1f::zeros(size), largest;
  for (const Gradient& gradient : gradients) {
    for (const float away : {-radius_px, radius_px}) {
      const int u = static_cast<int>(gradient.place[0] + away * gradient.direction[0] + 0.5F),
                v = static_cast<int>(gradient.place[1] + away * gradient.direction[1] + 0.5F);
      if (u >= 0 && v >= 0 && u < votes.cols && v < votes.rows) votes(v, u) += gradient.weight;
    }
  }
  cv::GaussianBlur(votes, votes, {}, 1.2);
  cv::dilate(votes, largest, cv::Mat1b::ones(5, 5));
  std::vector<Seed> peaks;
  for (int y = 0; y < votes.rows; ++y) {
    for (int x = 0; x < votes.cols; ++x) {
      if (votes(y, x) > 0 && votes(y, x) >= largest(y, x))
        peaks.push_back({{{x, y}, radius_px}, votes(y, x) / (2 * M_PI * radius_px)});
    }
  }
  return peaks;
}

/// The circles of some radii, in pixels of `lab`.
std::vector<Seed> seeds_of(const cv::Mat3f& lab, const std::array<float, radii_per_octave>& radii) {
  const std::vector<Gradient> gradients = gradients_of(lab);
  std::array<std::vector<Seed>, radii_per_octave> of_radius;
  tbb::parallel_for(std::size_t{0}, radii.size(),
                    [&](std::size_t i) { of_radius[i] = peaks_of(gradients, lab.size(), radii[i]); });
  std::vector<Seed> peaks;
  for (const std::vector<Seed>& some : of_radius) peaks.insert(peaks.end(), some.begin(), some.end());
  sort_by_votes(peaks);
  std::vector<Seed> seeds;
  for (const Seed& peak : peaks) {
    const auto alike = [&](const Seed& other) {
      const double larger = std::max(peak.outline.radius_px, other.outline.radius_px),
                   smaller = std::min(peak.outline.radius_px, other.outline.radius_px);
      return (peak.outline.center_px - other.outline.center_px).norm() < 0.3 * other.outline.radius_px &&
             larger < 1.35 * smaller;
    };
    if (std::any_of(seeds.begin(), seeds.end(), alike)) continue;
    seeds.push_back(peak);
    if (seeds.size() == most_per_octave) break;
  }
  return seeds;
}

}  // namespace

std::vector<Outline> circle_seeds(const cv::Mat3f& lab, double min_radius_px) {
  std::array<float, radii_per_octave> radii;
  for (std::size_t i = 0; i < radii.size(); ++i)
    radii[i] = static_cast<float>(0.9 * min_radius_px *
                                  std::pow(2, (static_cast<double>(i) + 0.5) / radii_per_octave));
  cv::Mat3f level;
  cv::GaussianBlur(lab, level, {}, 0.8);
  std::vector<Seed> seeds;
  for (double scale = 1; 2 * radii.front() < std::min(level.rows, level.cols); scale *= 2) {
    for (Seed& seed : seeds_of(level, radii)) {
      seed.outline.center_px =
          (seed.outline.center_px + Eigen::Vector2d(0.5, 0.5)) * scale - Eigen::Vector2d(0.5, 0.5);
      seed.outline.radius_px *= scale;
      seeds.push_back(seed);
    }
    cv::Mat3f half;
    cv::resize(level, half, {}, 0.5, 0.5, cv::INTER_AREA);
    level = half;
  }
  sort_by_votes(seeds);
  std::vector<Outline> outlines;
  for (const Seed& seed : seeds) outlines.push_back(seed.outline);
  return outlines;
}

}  // namespace ballservo
