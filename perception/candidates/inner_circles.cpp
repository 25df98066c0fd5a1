#include "perception/candidates/inner_circles.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "perception/outline/ball_position.hpp"
#include "perception/outline/edge_points.hpp"

namespace ballservo {
namespace {

// Of a smaller circle, edges before its own colour do not tell (see outline_support).
constexpr double min_radius_px = 12;
constexpr int least_edges = 6;      // inside the region, and on a circle
constexpr int peaks = 8;            // of the votes, whose circles are compared
constexpr int scouted = 6;          // of those, the best, held against the picture
constexpr float cells_a_size = 80;  // along the region's larger side
constexpr std::size_t max_boundary_points = 96;
// So much longer an outline is taken to be, that few points do not make a small circle.
constexpr float few_px = 10;
constexpr float min_cosine = 0.94f;  // between an edge's direction across and a circle's radius there
}  // namespace

InnerCircles::InnerCircles() {
  proposals_.reserve(peaks + 1);
  points_.reserve(512);
  found_.outline.points.reserve(most_outline_sectors);
}

const InnerCircle* InnerCircles::find(const cv::Mat& bgr, const Camera& camera,
                                      const std::vector<BoundaryPoint>& boundary,
                                      const std::vector<InnerEdge>& edges) {
  if (static_cast<int>(edges.size()) < least_edges) return nullptr;
  points_.clear();
  for (const InnerEdge& edge : edges) points_.push_back({edge.position_px, edge.across, true});
  // The boundary is known more densely than what lies inside, and must not outvote it.
  const std::size_t stride = boundary.size() / max_boundary_points + 1;
  for (std::size_t i = 0; i < boundary.size(); i += stride)
    points_.push_back({boundary[i].position_px, boundary[i].normal, false});
  if (!vote()) return nullptr;
  propose();
  int left = scouted;
  for (Proposal& proposal : proposals_) {
    if (left-- == 0 || proposal.score <= 0) break;
    fit_circle(proposal);
    if (is_supported(bgr, camera, proposal)) return &found_;
  }
  return nullptr;
}

// Calls f with each point seen from a centre, and its distance (px), whose direction across is a circle's.
template <class F>
void InnerCircles::for_each_agreeing(const Eigen::Vector2f& center_px, const F& f) const {
  for (const Point& point : points_) {
    const Eigen::Vector2f from_center_px = point.position_px - center_px;
    const float distance_px = from_center_px.norm(), along_px = point.across.dot(from_center_px);
    const bool agrees = (point.either_way ? std::abs(along_px) : along_px) >= min_cosine * distance_px;
    if (agrees && distance_px <= max_radius_px_) f(from_center_px, distance_px);
  }
}

bool InnerCircles::vote() {
  Eigen::Vector2f low = points_[0].position_px, high = low;
  for (const Point& point : points_) {
    low = low.cwiseMin(point.position_px);
    high = high.cwiseMax(point.position_px);
  }
  const Eigen::Vector2f extent = high - low;
  const float size = extent.maxCoeff();
  max_radius_px_ = 0.6f * size;
  if (!(static_cast<double>(max_radius_px_) >= min_radius_px)) return false;
  cell_px_ = std::max(2.0f, size / cells_a_size);
  // A cell of margin all around, for the peaks' neighbours.
  origin_px_ = low - Eigen::Vector2f::Constant(cell_px_);
  columns_ = static_cast<int>(extent.x() / cell_px_) + 3;
  rows_ = static_cast<int>(extent.y() / cell_px_) + 3;
  votes_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0);
  for (const Point& point : points_) {
    vote_along(point.position_px, -point.across);
    if (point.either_way) vote_along(point.position_px, point.across);
  }
  return true;
}

void InnerCircles::vote_along(const Eigen::Vector2f& from, const Eigen::Vector2f& direction) {
  if (direction.isZero()) return;
  const auto first = static_cast<int>(min_radius_px / static_cast<double>(cell_px_));
  const auto last = static_cast<int>(max_radius_px_ / cell_px_);
  const Eigen::Vector2f start = (from - origin_px_) / cell_px_;
  for (int i = first; i <= last; ++i) {
    const Eigen::Vector2f cell = start + static_cast<float>(i) * direction;
    if (!(cell.x() >= 1 && cell.y() >= 1 && cell.x() < static_cast<float>(columns_ - 1) &&
          cell.y() < static_cast<float>(rows_ - 1)))
      break;
    ++votes_[static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(columns_) +
             static_cast<std::size_t>(cell.x())];
  }
}

// Sums of 3x3 cells.
void InnerCircles::smooth_votes() {
  smooth_.assign(votes_.size(), 0);
  const std::ptrdiff_t row = columns_;
  for (int v = 1; v + 1 < rows_; ++v) {
    const std::uint16_t* const from =
        &votes_[static_cast<std::size_t>(v) * static_cast<std::size_t>(columns_)];
    std::uint16_t* const to = &smooth_[static_cast<std::size_t>(v) * static_cast<std::size_t>(columns_)];
    for (int u = 1; u + 1 < columns_; ++u) {
      int sum = 0;
      for (std::ptrdiff_t dv = -row; dv <= row; dv += row) {
        for (std::ptrdiff_t du = -1; du <= 1; ++du) sum += from[u + du + dv];
      }
      to[u] = static_cast<std::uint16_t>(sum);
    }
  }
}

// The circles around the fullest places, best first.
void InnerCircles::propose() {
  smooth_votes();
  proposals_.clear();
  const std::ptrdiff_t row = columns_;
  for (int v = 1; v + 1 < rows_; ++v) {
    const std::uint16_t* const line =
        &smooth_[static_cast<std::size_t>(v) * static_cast<std::size_t>(columns_)];
    for (int u = 1; u + 1 < columns_; ++u) {
      const std::uint16_t* const at = line + u;
      // As large as those before and larger than those behind: one of equal neighbours.
      const bool is_peak = *at >= least_edges && *at >= at[-1] && *at >= at[-row - 1] && *at >= at[-row] &&
                           *at >= at[-row + 1] && *at > at[1] && *at > at[row - 1] && *at > at[row] &&
                           *at > at[row + 1];
      if (!is_peak) continue;
      Proposal proposal;
      proposal.center_px =
          origin_px_ + cell_px_ * Eigen::Vector2f(static_cast<float>(u) + 0.5f, static_cast<float>(v) + 0.5f);
      proposal.votes = *at;
      proposals_.insert(
          std::upper_bound(proposals_.begin(), proposals_.end(), proposal,
                           [](const Proposal& a, const Proposal& b) { return a.votes > b.votes; }),
          proposal);
      if (static_cast<int>(proposals_.size()) > peaks) proposals_.pop_back();
    }
  }
  for (Proposal& proposal : proposals_) vote_radius(proposal);
  std::sort(proposals_.begin(), proposals_.end(), [](const Proposal& a, const Proposal& b) {
    return a.score != b.score ? a.score > b.score : a.votes > b.votes;
  });
}

// The radius at which most points lie whose direction across is the circle's, for the length of its outline.
void InnerCircles::vote_radius(Proposal& proposal) {
  radii_.assign(static_cast<std::size_t>(max_radius_px_ / cell_px_) + 3, 0);
  for_each_agreeing(proposal.center_px, [&](const Eigen::Vector2f&, float distance_px) {
    ++radii_[static_cast<std::size_t>(distance_px / cell_px_) + 1];
  });
  proposal.score = 0;
  for (std::size_t i = 1; i + 1 < radii_.size(); ++i) {
    const int points = radii_[i - 1] + radii_[i] + radii_[i + 1];
    const float radius_px = (static_cast<float>(i) - 0.5f) * cell_px_;
    const float score = static_cast<float>(points) / (radius_px + few_px);
    if (!(static_cast<double>(radius_px) >= min_radius_px) || points < least_edges || score <= proposal.score)
      continue;
    proposal.radius_px = radius_px;
    proposal.score = score;
    proposal.points = points;
  }
}

// The circle through the points that agree with it: |p - c|^2 = r^2 is linear in c and r^2 - |c|^2.
void InnerCircles::fit_circle(Proposal& proposal) const {
  Eigen::Matrix3f normal = Eigen::Matrix3f::Zero();
  Eigen::Vector3f right = Eigen::Vector3f::Zero();
  for_each_agreeing(proposal.center_px, [&](const Eigen::Vector2f& from_center_px, float distance_px) {
    if (std::abs(distance_px - proposal.radius_px) > 2 * cell_px_) return;
    const Eigen::Vector3f row(2 * from_center_px.x(), 2 * from_center_px.y(), 1);
    normal += row * row.transpose();
    right += row * from_center_px.squaredNorm();
  });
  const Eigen::Vector3f solution = normal.ldlt().solve(right);
  const Eigen::Vector2f move_px = solution.head<2>();
  const float radius_px = std::sqrt(std::max(0.0f, solution.z() + move_px.squaredNorm()));
  const bool is_near = move_px.norm() < 0.5f * proposal.radius_px &&
                       std::abs(radius_px - proposal.radius_px) < 0.3f * proposal.radius_px;
  if (!is_near) return;
  proposal.center_px += move_px;
  proposal.radius_px = radius_px;
}

// Held against the picture.
bool InnerCircles::is_supported(const cv::Mat& bgr, const Camera& camera, const Proposal& proposal) {
  const double focal_px = camera.focal_px();
  const auto cone = cone_near_circle(
      {proposal.center_px.cast<double>(), static_cast<double>(proposal.radius_px)}, focal_px);
  if (!cone || !scout_outline(bgr, camera, *cone, OutlineScoutOptions{}, found_.outline)) return false;
  const TangentCone& moved = found_.outline.cone;
  if (!(moved.alpha_rad * focal_px >= min_radius_px)) return false;
  CircleEstimate& circle = found_.circle;
  circle.center_px = focal_px / moved.axis.z() * moved.axis.head<2>();
  circle.radius_px = focal_px * std::tan(moved.alpha_rad);
  circle.votes = circle.center_peak = proposal.votes;
  circle.points = circle.radius_peak = proposal.points;
  return true;
}

}  // namespace ballservo
