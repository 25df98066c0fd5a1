#include "perception/circle_vote.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

// Triples whose circumcentre is worse conditioned than this (sine of the smallest angle between chords) tell
// nothing.
constexpr double min_sine = 0.05;
constexpr int max_cells_a_side = 1024;

}  // namespace

std::optional<Eigen::Vector2d> circumcenter(const Eigen::Vector2d& p1, const Eigen::Vector2d& p2,
                                            const Eigen::Vector2d& p3) {
  // The paper's formula about p1 as origin, where its terms in d1 vanish and nothing cancels.
  const Eigen::Vector2d a = p2 - p1, b = p3 - p1;
  const double cross = a.x() * b.y() - a.y() * b.x();
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), cc = (p3 - p2).squaredNorm();
  if (!(std::abs(cross) > min_sine * std::sqrt(std::max({aa * bb, aa * cc, bb * cc})))) return std::nullopt;
  return p1 + Eigen::Vector2d(aa * b.y() - bb * a.y(), bb * a.x() - aa * b.x()) / (2 * cross);
}

std::optional<CircleEstimate> CircleVoter::estimate(const std::vector<Eigen::Vector2f>& points_px,
                                                    RandomEngine& engine) {
  const int count = static_cast<int>(points_px.size());
  if (count < 8) return std::nullopt;
  Eigen::Vector2f low = points_px[0], high = points_px[0];
  for (const Eigen::Vector2f& p : points_px) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  // Of a half-hidden ball the centre may lie outside the box of what is seen, but not by more than its size.
  const double size = static_cast<double>((high - low).maxCoeff());
  if (!(size > 0) || !std::isfinite(size)) return std::nullopt;
  const double margin = 0.75 * size;
  histogram_.origin_px = low.cast<double>() - Eigen::Vector2d(margin, margin);
  const Eigen::Vector2d extent = (high - low).cast<double>() + Eigen::Vector2d(2 * margin, 2 * margin);
  histogram_.cell_px = std::max(1.0, extent.maxCoeff() / max_cells_a_side);
  histogram_.columns = static_cast<int>(extent.x() / histogram_.cell_px) + 1;
  histogram_.rows = static_cast<int>(extent.y() / histogram_.cell_px) + 1;
  histogram_.counts.assign(
      static_cast<std::size_t>(histogram_.columns) * static_cast<std::size_t>(histogram_.rows), 0);
  votes_.clear();

  CircleEstimate result;
  result.points = count;
  const int cap = std::min(options_.max_votes, std::max(300, options_.max_votes_per_point * count));
  int peak_column = 0, peak_row = 0;
  while (result.votes < cap && !result.stopped) {
    ++result.votes;
    const auto draw = [&] {
      return points_px[uniform_index(engine, static_cast<std::uint32_t>(count))].cast<double>().eval();
    };
    const Eigen::Vector2d p1 = draw(), p2 = draw(), p3 = draw();
    const auto center = circumcenter(p1, p2, p3);
    if (!center) continue;
    const Eigen::Vector2d cell =
        (*center - histogram_.origin_px) / histogram_.cell_px + Eigen::Vector2d(0.5, 0.5);
    if (!(cell.minCoeff() >= 0) || cell.x() >= histogram_.columns || cell.y() >= histogram_.rows) continue;
    if ((*center - p1).norm() < options_.min_radius_px) continue;
    const int column = static_cast<int>(cell.x()), row = static_cast<int>(cell.y());
    std::uint16_t& votes =
        histogram_.counts[static_cast<std::size_t>(row) * static_cast<std::size_t>(histogram_.columns) +
                          static_cast<std::size_t>(column)];
    votes_.push_back(center->cast<float>());
    if (++votes > result.center_peak) {
      result.center_peak = votes;
      peak_column = column;
      peak_row = row;
      result.stopped = votes >= options_.stop_at;
    }
  }
  if (result.center_peak == 0) return std::nullopt;

  // The mean of the votes in and next to the fullest cell places the centre between cells.
  const Eigen::Vector2d peak =
      histogram_.origin_px + histogram_.cell_px * Eigen::Vector2d(peak_column, peak_row);
  Eigen::Vector2d sum(0, 0);
  int near = 0;
  for (const Eigen::Vector2f& vote : votes_) {
    if ((vote.cast<double>() - peak).cwiseAbs().maxCoeff() > 1.5 * histogram_.cell_px) continue;
    sum += vote.cast<double>();
    ++near;
  }
  result.center_px = sum / near;

  // The deterministic vote for the radius.
  double farthest = 0;
  for (const Eigen::Vector2f& p : points_px)
    farthest = std::max(farthest, (p.cast<double>() - result.center_px).norm());
  radii_.assign(static_cast<std::size_t>(farthest) + 2, 0);
  for (const Eigen::Vector2f& p : points_px)
    ++radii_[static_cast<std::size_t>((p.cast<double>() - result.center_px).norm())];
  const auto peak_radius = std::max_element(radii_.begin(), radii_.end());
  result.radius_peak = *peak_radius;
  const double middle = static_cast<double>(peak_radius - radii_.begin()) + 0.5;
  double radius_sum = 0;
  int radius_count = 0;
  for (const Eigen::Vector2f& p : points_px) {
    const double distance = (p.cast<double>() - result.center_px).norm();
    if (std::abs(distance - middle) > 1.5) continue;
    radius_sum += distance;
    ++radius_count;
  }
  result.radius_px = radius_sum / radius_count;
  if (!(result.radius_px >= options_.min_radius_px)) return std::nullopt;
  return result;
}

}  // namespace ballservo
