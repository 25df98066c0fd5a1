#include "perception/judgement/occluding_edge.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

namespace ballservo {
namespace {

constexpr int looks = 72;
constexpr double most_strays = 0.15;  // of the looks, on the other side of the chord than their colour says
constexpr double least_hidden = 0.3;
// Where the edge is looked for beyond the outline (radii), and how far from the chord: its ends are known to
// half a look, which moves it by so much.
constexpr double from_radii = 0.15, step_radii = 0.07;
constexpr int steps_along = 8;
constexpr double shift_px = 3, shift_radii = 0.06, most_shift_px = 12;
constexpr double least_peak = 12;  // grey levels, summed over the channels
// How far the edge stands out from its neighbourhood: at both ends together, and at either.
constexpr double least_product = 12, least_ratio = 1.5;

Eigen::Vector2d direction_of(double look) {
  const double angle = 2 * M_PI * look / looks;
  return {std::cos(angle), std::sin(angle)};
}

// The looks around the outline behind which its rest is hidden: [first, first + count), around the turn.
struct HiddenArc {
  int first = 0, count = 0;
};

std::optional<HiddenArc> hidden_arc(const ColoredPixels& colored, const OutlineEllipse& outline) {
  int own_before[looks + 1] = {};  // sums
  for (int i = 0; i < looks; ++i) {
    int own = 0;
    for (const double radii : {0.8, 0.87, 0.94}) {
      const Eigen::Vector2d at = outline.center_px + radii * outline.radius_px * direction_of(i + 0.5);
      const int u = static_cast<int>(std::lround(at.x())), v = static_cast<int>(std::lround(at.y()));
      own += colored.knows(u, v) && colored.at(u, v) ? 1 : 0;
    }
    own_before[i + 1] = own_before[i] + (own >= 2 ? 1 : 0);
  }
  const int all_own = own_before[looks];
  const auto own_in = [&](const HiddenArc& arc) {
    const int end = arc.first + arc.count;
    const int before_end = end <= looks ? own_before[end] : all_own + own_before[end - looks];
    return before_end - own_before[arc.first];
  };
  HiddenArc best;
  int fewest = looks;
  for (int first = 0; first < looks; ++first) {
    for (int count = static_cast<int>(least_hidden * looks); count < looks; ++count) {
      const int inside = own_in({first, count});
      const int strays = inside + (looks - count) - (all_own - inside);
      if (strays < fewest) fewest = strays, best = {first, count};
    }
  }
  if (fewest > most_strays * looks) return std::nullopt;
  return best;
}

// Beyond one end of a chord: by how much more the picture's colours differ across the line on which it goes
// on than across its neighbours; 0 where they hardly differ.
double stands_out(const cv::Mat& bgr, const Eigen::Vector2d& end, const Eigen::Vector2d& outward,
                  double radius_px) {
  const Eigen::Vector2d across(-outward.y(), outward.x());
  const int reach = static_cast<int>(std::min(most_shift_px, shift_px + shift_radii * radius_px));
  double sorted[4 * static_cast<int>(most_shift_px) + 1];
  int places = 0;
  double peak = 0;
  for (int shift = -2 * reach; shift <= 2 * reach; ++shift) {
    Eigen::Vector3d sum(0, 0, 0);
    for (int i = 0; i < steps_along; ++i) {
      const Eigen::Vector2d at = end + (from_radii + i * step_radii) * radius_px * outward + shift * across;
      for (const double side : {-2, -1, 1, 2}) {
        const Eigen::Vector2d beside = at + side * across;
        const int u = static_cast<int>(std::lround(beside.x())),
                  v = static_cast<int>(std::lround(beside.y()));
        if (u < 0 || v < 0 || u >= bgr.cols || v >= bgr.rows) return 0;
        const cv::Vec3b& color = bgr.at<cv::Vec3b>(v, u);
        sum += (side < 0 ? 0.5 : -0.5) * Eigen::Vector3d(color[0], color[1], color[2]);
      }
    }
    const double difference = sum.lpNorm<1>() / steps_along;
    sorted[places++] = difference;
    if (std::abs(shift) <= reach) peak = std::max(peak, difference);
  }
  double& usual = sorted[places / 2];
  std::nth_element(sorted, &usual, sorted + places);
  return peak >= least_peak ? peak / std::max(1.0, usual) : 0;
}

}  // namespace

bool is_behind_straight_edge(const cv::Mat& bgr, const ColoredPixels& colored,
                             const OutlineEllipse& outline) {
  const auto hidden = hidden_arc(colored, outline);
  if (!hidden) return false;
  const Eigen::Vector2d from = outline.center_px + outline.radius_px * direction_of(hidden->first),
                        to = outline.center_px +
                             outline.radius_px * direction_of(hidden->first + hidden->count);
  const Eigen::Vector2d along = (to - from).normalized();
  const double before = stands_out(bgr, from, -along, outline.radius_px),
               after = stands_out(bgr, to, along, outline.radius_px);
  return std::min(before, after) >= least_ratio && before * after >= least_product;
}

}  // namespace ballservo
