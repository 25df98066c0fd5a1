#include "perception/candidates/inner_circles.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "perception/outline/edge_points.hpp"
#include "perception/outline/paper_refinement.hpp"

namespace ballservo {
namespace {

// Sum over the channels of how two pixels differ.
int difference(const std::uint8_t* a, const std::uint8_t* b) {
  return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
}

constexpr int max_looks = 6000;         // pixels looked at; of a larger region every few lines alone
constexpr std::size_t max_edges = 256;  // the strongest
constexpr int min_inner_step = 14;      // sum over the channels of the grey levels across an edge
// An edge is so many times as strong as the median of all looks (texture, noise).
constexpr double over_median = 3;
constexpr int shade_px = 3;
constexpr int inside_px = 2;  // inside the region's boundary, whose own edge is known

bool is_inside(const ColoredPixels& colored, int u, int v) {
  return colored.at(u - inside_px, v) && colored.at(u + inside_px, v) && colored.at(u, v - inside_px) &&
         colored.at(u, v + inside_px);
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

InnerEdges::InnerEdges() { peaks_.reserve(max_looks); }

void InnerEdges::find(const cv::Mat& bgr, const ColoredPixels& colored, const RayTable& rays,
                      const cv::Rect& box, int region_pixels, std::vector<InnerEdge>& edges) {
  edges.clear();
  peaks_.clear();
  histogram_.fill(0);
  const cv::Rect known(colored.window, colored.pixels.size());
  const cv::Rect inside = box & cv::Rect(known.x + inside_px, known.y + inside_px,
                                         known.width - 2 * inside_px, known.height - 2 * inside_px);
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
    if (*step < min_inner_step || *step <= step[-1] || *step < step[1]) continue;
    if (*step < step[-shade_px] + step[shade_px]) continue;
    const int u = first.x + i * along.x, v = first.y + i * along.y;
    if (static_cast<int>(peaks_.size()) < max_looks && is_inside(colored, u, v))
      peaks_.push_back({u, v, *step});
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
    ++row_of(votes_, static_cast<int>(cell.y()))[static_cast<int>(cell.x())];
  }
}

// Sums of 3x3 cells.
void InnerCircles::smooth_votes() {
  smooth_.assign(votes_.size(), 0);
  const std::ptrdiff_t row = columns_;
  for (int v = 1; v + 1 < rows_; ++v) {
    const std::uint16_t* const from = row_of(votes_, v);
    std::uint16_t* const to = row_of(smooth_, v);
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
    const std::uint16_t* const line = row_of(smooth_, v);
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
  constexpr double reach_px = 5, min_support = 0.6;
  const double focal_px = camera.focal_px();
  const auto cone = cone_near_circle(
      {proposal.center_px.cast<double>(), static_cast<double>(proposal.radius_px)}, focal_px);
  if (!cone || !scout_outline(bgr, camera, *cone, reach_px, min_support, found_.outline)) return false;
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
