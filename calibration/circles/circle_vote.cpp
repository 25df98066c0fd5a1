#include "calibration/circles/circle_vote.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

// Triples whose circumcentre is worse conditioned than this (sine of the smallest angle between chords) tell
// nothing.
constexpr double min_sine = 0.05;
// Cells of the histogram along the region's larger side: as fine as a circle of a tenth of it can be seen.
constexpr double cells_a_size = 40;
constexpr int least_reach = 16;  // points that an arc needs to show its curvature
constexpr int stop_at = 16;      // votes in one cell that end the voting (paper: a threshold)
// The most votes, by the number of boundary points (heavy occlusion needs many), and in all.
constexpr int max_votes_per_point = 8, max_votes = 2000;
// Votes after which a fullest cell on its way to less than half of stop_at is not waited for.
constexpr int hopeless_after = 400;
constexpr double min_radius_px = 2.5;
constexpr double max_normal_error_rad = 0.5;  // between a point's normal, where it has one, and the circle's

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

std::optional<CircleEstimate> CircleVoter::estimate(const std::vector<BoundaryPoint>& points,
                                                    RandomEngine& engine) {
  if (points.size() < 8 || !set_up_histogram(points)) return std::nullopt;
  CircleEstimate result;
  const int count = static_cast<int>(points.size());
  result.points = count;
  const int cap = std::min(max_votes, std::max(300, max_votes_per_point * count));
  const double min_cosine = std::cos(max_normal_error_rad);
  int octaves = 0;
  while ((least_reach << (octaves + 1)) < count) ++octaves;
  Eigen::Vector2d peak(0, 0);
  while (result.votes < cap && !result.stopped) {
    ++result.votes;
    const auto [i, k, l] = draw(count, octaves, engine);
    const BoundaryPoint &a = points[i], &b = points[k], &c = points[l];
    const auto center = circumcenter(a.position_px.cast<double>(), b.position_px.cast<double>(),
                                     c.position_px.cast<double>());
    if (!center) continue;
    const auto agrees = [&](const BoundaryPoint& p) {
      const Eigen::Vector2d radius = p.position_px.cast<double>() - *center;
      return p.normal.isZero() || p.normal.cast<double>().dot(radius) >= min_cosine * radius.norm();
    };
    if (!agrees(a) || !agrees(b) || !agrees(c)) continue;
    const Eigen::Vector2d cell =
        (*center - histogram_.origin_px) / histogram_.cell_px + Eigen::Vector2d(0.5, 0.5);
    if (!(cell.minCoeff() >= 0) || cell.x() >= histogram_.columns || cell.y() >= histogram_.rows) continue;
    if ((*center - a.position_px.cast<double>()).norm() < min_radius_px) continue;
    const int column = static_cast<int>(cell.x()), row = static_cast<int>(cell.y());
    std::uint16_t& votes =
        histogram_.counts[static_cast<std::size_t>(row) * static_cast<std::size_t>(histogram_.columns) +
                          static_cast<std::size_t>(column)];
    votes_.push_back(center->cast<float>());
    if (++votes > result.center_peak) {
      result.center_peak = votes;
      peak = histogram_.origin_px + histogram_.cell_px * Eigen::Vector2d(column, row);
      result.stopped = votes >= stop_at;
    }
    const bool hopeless = result.votes > hopeless_after &&
                          2L * result.center_peak * cap < static_cast<long>(stop_at) * result.votes;
    if (hopeless) break;
  }
  if (result.center_peak == 0) return std::nullopt;
  result.center_px = mean_of_votes_near(peak);
  if (!vote_radius(points, result)) return std::nullopt;
  return result;
}

bool CircleVoter::set_up_histogram(const std::vector<BoundaryPoint>& points) {
  Eigen::Vector2f low = points[0].position_px, high = low;
  for (const BoundaryPoint& p : points) {
    low = low.cwiseMin(p.position_px);
    high = high.cwiseMax(p.position_px);
  }
  // Of a half-hidden ball the centre may lie outside the box of what is seen, but not by more than its size.
  const double size = static_cast<double>((high - low).maxCoeff());
  if (!(size > 0) || !std::isfinite(size)) return false;
  const double margin = 0.75 * size;
  histogram_.origin_px = low.cast<double>() - Eigen::Vector2d(margin, margin);
  const Eigen::Vector2d extent = (high - low).cast<double>() + Eigen::Vector2d(2 * margin, 2 * margin);
  histogram_.cell_px = std::max(1.0, size / cells_a_size);
  histogram_.columns = static_cast<int>(extent.x() / histogram_.cell_px) + 1;
  histogram_.rows = static_cast<int>(extent.y() / histogram_.cell_px) + 1;
  histogram_.counts.assign(
      static_cast<std::size_t>(histogram_.columns) * static_cast<std::size_t>(histogram_.rows), 0);
  votes_.clear();
  return true;
}

std::array<std::size_t, 3> CircleVoter::draw(int count, int octaves, RandomEngine& engine) const {
  const auto any = [&] { return uniform_index(engine, static_cast<std::uint32_t>(count)); };
  const std::uint32_t first = any();
  const std::uint32_t choice = uniform_index(engine, static_cast<std::uint32_t>(2 * octaves + 2));
  if (choice > static_cast<std::uint32_t>(octaves)) return {first, any(), any()};
  const std::uint32_t reach = static_cast<std::uint32_t>(least_reach) << choice;
  const auto near = [&] {
    const std::uint32_t around = static_cast<std::uint32_t>(4 * count);  // keeps the difference positive
    return (first + around + uniform_index(engine, 2 * reach + 1) - reach) %
           static_cast<std::uint32_t>(count);
  };
  return {first, near(), near()};
}

// The mean of the votes in and next to the fullest cell places the centre between cells.
Eigen::Vector2d CircleVoter::mean_of_votes_near(const Eigen::Vector2d& peak) const {
  Eigen::Vector2d sum(0, 0);
  int near = 0;
  for (const Eigen::Vector2f& vote : votes_) {
    if ((vote.cast<double>() - peak).cwiseAbs().maxCoeff() > 1.5 * histogram_.cell_px) continue;
    sum += vote.cast<double>();
    ++near;
  }
  return sum / near;
}

// The deterministic vote for the radius.
bool CircleVoter::vote_radius(const std::vector<BoundaryPoint>& points, CircleEstimate& circle) {
  const auto distance = [&](const BoundaryPoint& p) {
    return (p.position_px.cast<double>() - circle.center_px).norm();
  };
  double farthest = 0;
  for (const BoundaryPoint& p : points) farthest = std::max(farthest, distance(p));
  radii_.assign(static_cast<std::size_t>(farthest) + 2, 0);
  for (const BoundaryPoint& p : points) ++radii_[static_cast<std::size_t>(distance(p))];
  const auto peak_radius = std::max_element(radii_.begin(), radii_.end());
  circle.radius_peak = *peak_radius;
  const double middle = static_cast<double>(peak_radius - radii_.begin()) + 0.5;
  double sum = 0;
  int near = 0;
  for (const BoundaryPoint& p : points) {
    if (std::abs(distance(p) - middle) > 1.5) continue;
    sum += distance(p);
    ++near;
  }
  circle.radius_px = sum / near;
  return circle.radius_px >= min_radius_px;
}

}  // namespace ballservo
