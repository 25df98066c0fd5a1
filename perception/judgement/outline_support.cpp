#include "perception/judgement/outline_support.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

// The window in which a curvature is told: so far (rad) to each side.
constexpr double reach_rad = 0.35;
// Edges of clean pictures are less blurred than this; above, their shape means less and less (px).
constexpr double sharp_px = 2, smeared_px = 2.4;

bool is_own(SectorColor color) { return color == SectorColor::bounded || color == SectorColor::leaking; }

// The parabola through the offsets around a sector: its second derivative by the angle as a part of the
// radius, 0 for the outline itself and 1 for a straight line (r / cos(a) - r ~ r a^2 / 2), and how well it
// fits.
struct LocalRun {
  double bend, scatter_px;
};

std::optional<LocalRun> local_run(const EdgeOffsets& offsets, int at, int reach, double radius_px) {
  const int count = offsets.count;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double squares = 0;
  int seen = 0;
  for (int j = -reach; j <= reach; ++j) {
    const double offset = static_cast<double>(offsets[(at + j + count) % count]);
    if (std::isnan(offset)) continue;
    const double angle = 2 * M_PI * j / count;
    const Eigen::Vector3d row(1, angle, 0.5 * angle * angle);
    normal += row * row.transpose();
    right += row * offset;
    squares += offset * offset;
    ++seen;
  }
  if (seen < std::max(3, 2 * reach)) return std::nullopt;
  const Eigen::Vector3d p = normal.ldlt().solve(right);
  const double rest = squares - 2 * p.dot(right) + p.dot(normal * p);
  return LocalRun{p(2) / radius_px, std::sqrt(std::max(0.0, rest) / seen)};
}

double straight_share(const EdgeOffsets& offsets, const SectorColors& colors, double radius_px) {
  const int count = offsets.count;
  const int reach = std::max(1, static_cast<int>(std::lround(reach_rad * count / (2 * M_PI))));
  int straight = 0, round = 0;
  for (int i = 0; i < count; ++i) {
    if (!is_own(colors[i]) || std::isnan(offsets[i])) continue;
    const auto run = local_run(offsets, i, reach, radius_px);
    if (!run) continue;
    if (std::abs(run->bend) < 0.5)
      ++round;
    else if (run->bend > 0 && run->bend < 1.8 && run->scatter_px < 0.15 + 0.005 * radius_px)
      ++straight;
  }
  return straight + round > 0 ? static_cast<double>(straight) / (straight + round) : 0;
}

constexpr double least_radius_before_own_color_px = 12;
// Where a disc is looked at along a radius: each stands for a sixth of its area.
constexpr std::array<double, 6> disc_radii{0.2887, 0.5, 0.6455, 0.7638, 0.866, 0.9574};

bool is_near(const Eigen::Vector2d& position_px) { return position_px.cwiseAbs().maxCoeff() < 1e6; }
// The pixel that holds a near position.
int nearest(double position_px) { return static_cast<int>(position_px + (1e7 + 0.5)) - 10000000; }

// How many of a zone's pixels have the ball's colour.
struct Share {
  int pixels = 0, colored = 0;
  void add(bool is_colored) {
    ++pixels;
    colored += is_colored ? 1 : 0;
  }
  double fraction(double of_nothing) const {
    return pixels > 0 ? static_cast<double>(colored) / pixels : of_nothing;
  }
};

SectorColor sector_color(const Share& inside, const Share& outside) {
  if (inside.pixels == 0 || outside.pixels == 0) return SectorColor::unseen;
  if (inside.fraction(0) < 0.5) return SectorColor::covered;
  return outside.fraction(0) > 0.5 ? SectorColor::leaking : SectorColor::bounded;
}

constexpr int least_step = 12;  // grey levels, summed over the channels: above the noise of most pictures
constexpr int most_reach = 5;   // px, to either side of the outline

// Whether two pixels before and two behind some place along the line differ by a step.
bool has_step(const cv::Mat& bgr, const Eigen::Vector2d& from, const Eigen::Vector2d& to, int places) {
  cv::Vec3i colors[2 * most_reach + 4];
  for (int i = 0; i < places + 3; ++i) {
    const Eigen::Vector2d at = from + (to - from) * (static_cast<double>(i) / (places + 2));
    if (!(at.minCoeff() >= 0 && at.x() <= bgr.cols - 1 && at.y() <= bgr.rows - 1)) return false;
    colors[i] = bgr.at<cv::Vec3b>(static_cast<int>(at.y() + 0.5), static_cast<int>(at.x() + 0.5));
  }
  for (int i = 0; i < places; ++i) {
    const cv::Vec3i twice = colors[i] + colors[i + 1] - colors[i + 2] - colors[i + 3];
    if (std::abs(twice[0]) + std::abs(twice[1]) + std::abs(twice[2]) >= 2 * least_step) return true;
  }
  return false;
}

}  // namespace

bool is_on_outline(float offset_px, double radius_px, double blur_px) {
  // A box of a few pixels differs from a disc by less than a large one.
  const double tolerance_px =
      std::min(0.25 + 0.01 * radius_px, 0.08 + 0.03 * radius_px) + std::max(0.0, blur_px - 1.4);
  return std::abs(static_cast<double>(offset_px)) <= tolerance_px;
}

OutlineShape outline_shape(const EdgeOffsets& offsets, const SectorColors& colors, double radius_px,
                           double blur_px) {
  int confirmed = 0, told = 0;
  for (int i = 0; i < offsets.count; ++i) {
    if (!is_own(colors[i])) continue;
    if (colors[i] != SectorColor::leaking && std::isnan(offsets[i])) continue;
    ++told;
    if (is_on_outline(offsets[i], radius_px, blur_px)) ++confirmed;
  }
  OutlineShape shape;
  if (told > 0) shape.match = static_cast<double>(confirmed) / told;
  // Any blob of a few pixels meets a circle in half of its sectors.
  const double blob = std::clamp((7 - radius_px) / 2, 0.0, 1.0);
  shape.match -= blob * (1 - shape.match);
  shape.match = std::max(0.0, shape.match);
  // Nor can a line be told from an arc of a few pixels.
  const double trust = std::clamp((smeared_px - blur_px) / (smeared_px - sharp_px), 0.0, 1.0) *
                       std::clamp(radius_px - 4.5, 0.0, 1.0);
  if (trust > 0) shape.straight = trust * straight_share(offsets, colors, radius_px);
  return shape;
}

double OutlineSupport::quality() const {
  // An edge that mostly leaves the outline, or leaves it as a straight line, is another thing's.
  const double round = std::min(1.0, 1.3 * shape.roundness());
  // So is one that is met in short arcs only, as where a circle crosses a box's sides.
  const double connected = arc_in_runs > 0 ? 1 : 0.6;
  return std::sqrt(std::clamp(arc, 0.0, 1.0) * std::clamp(fill, 0.0, 1.0)) * (1 - leak) * (1 - leak) * round *
         connected;
}

double OutlineSectors::fraction() const {
  return count > 0 ? static_cast<double>(std::count(values.begin(), values.begin() + count, true)) / count
                   : 0;
}

double OutlineSectors::fraction_in_arcs() const {
  const auto is_seen = [&](int i) { return (*this)[(i + count) % count]; };
  int in_arcs = 0, gaps = 0;
  for (int start = 0; start < count; ++start) {
    // An arc begins after two sectors without anything; a whole turn has no beginning.
    if (is_seen(start - 1) || is_seen(start - 2)) continue;
    if (!is_seen(start)) {
      ++gaps;
      continue;
    }
    int length = 0, seen_in_it = 0;
    while (is_seen(start + length) || is_seen(start + length + 1)) seen_in_it += is_seen(start + length++);
    if (6 * length >= count) in_arcs += seen_in_it;
    ++gaps;
  }
  if (gaps == 0) return fraction();
  return static_cast<double>(in_arcs) / count;
}

OutlineSectors boundary_sectors(const std::vector<BoundaryPoint>& points, const TangentCone& cone,
                                double focal_px) {
  const double radius_px = cone.alpha_rad * focal_px;
  const double tolerance_rad = (0.5 + outline_tolerance_px(radius_px)) / focal_px;
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(cone.axis);
  OutlineSectors sectors(static_cast<int>(std::clamp(6.28 * radius_px, 8.0, 48.0)));
  for (const BoundaryPoint& p : points) {
    const Eigen::Vector3d ray = ray_of(p, focal_px);
    if (std::abs(angle_outside(cone, ray)) > tolerance_rad) continue;
    const Eigen::Vector2d across = basis.transpose() * ray;
    const double angle = std::atan2(across.y(), across.x());
    sectors[sectors.sector_at(angle < 0 ? angle + 2 * M_PI : angle)] = true;
  }
  return sectors;
}

OutlineSectors edge_sectors(const EdgeOffsets& offsets, double tolerance_px) {
  OutlineSectors sectors(offsets.count);
  for (int i = 0; i < offsets.count; ++i)
    sectors[i] = std::abs(static_cast<double>(offsets[i])) <= tolerance_px;
  return sectors;
}

void see_steps_in_own_color(const cv::Mat& bgr, const ColoredPixels& colored, const Camera& camera,
                            const TangentCone& cone, OutlineSectors& sectors) {
  const auto middle = camera.project(cone.axis);
  if (!middle) return;
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(cone.axis);
  for (int i = 0; i < sectors.count; ++i) {
    if (sectors[i]) continue;
    const double angle = 2 * M_PI * (i + 0.5) / sectors.count;
    const Eigen::Vector3d outward = basis * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const auto edge =
        camera.project(cone.axis * std::cos(cone.alpha_rad) + outward * std::sin(cone.alpha_rad));
    if (!edge) continue;
    const double radius_px = (*edge - *middle).norm();
    if (!(radius_px > 0) || !(edge->cwiseAbs().maxCoeff() < 1e6)) continue;
    const Eigen::Vector2d out = (*edge - *middle) / radius_px;
    const int reach = std::min(most_reach, 2 + static_cast<int>(0.1 * radius_px));
    const Eigen::Vector2d beyond = *edge + (reach + 1) * out;
    const int u = static_cast<int>(std::lround(beyond.x())), v = static_cast<int>(std::lround(beyond.y()));
    if (!colored.knows(u, v) || !colored.at(u, v)) continue;
    // From 1.5 px further in than the first place to 1.5 px further out than the last.
    sectors[i] = has_step(bgr, *edge - (reach + 1.5) * out, *edge + (reach + 1.5) * out, 2 * reach + 1);
  }
}

OutlineSupport outline_support(const OutlineSectors& edges, const EdgeOffsets& offsets, double blur_px,
                               const ColoredPixels& colored, const Camera& camera, const TangentCone& cone) {
  OutlineSupport support;
  const auto middle = camera.project(cone.axis);
  if (!middle || !is_near(*middle) || edges.count == 0) return support;
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(cone.axis);
  const double sine = std::sin(cone.alpha_rad), cosine = std::cos(cone.alpha_rad);
  Share disc, rim;
  OutlineSectors supported(edges.count);
  SectorColors colors(edges.count);
  int hidden = 0;
  double radius_sum_px = 0;
  for (int i = 0; i < edges.count; ++i) {
    const double angle = 2 * M_PI * (i + 0.5) / edges.count;
    const Eigen::Vector3d outward = basis * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const auto edge = camera.project(cone.axis * cosine + outward * sine);
    if (!edge) continue;
    const Eigen::Vector2d radius_px = *edge - *middle;
    const double length_px = radius_px.norm();
    if (!is_near(*edge) || !(length_px > 0)) continue;
    const auto look = [&](Share& share, double radii) {
      const Eigen::Vector2d at = *middle + radii * radius_px;
      const int u = nearest(at.x()), v = nearest(at.y());
      if (colored.knows(u, v)) share.add(colored.at(u, v));
    };
    // Just inside and just outside the outline, clear of its blur; and in a wider rim for what runs on.
    for (const double radii : disc_radii) look(disc, radii);
    const double clear = std::max(0.08, 1.2 / length_px);
    Share inside, outside;
    for (const double depth : {0.03, 0.1, 0.17}) {
      look(inside, 1 - clear - depth);
      look(outside, 1 + clear + depth);
    }
    // Where the ball stands before a thing of its own colour, the edge between the two speaks for it; of a
    // ball of a few pixels it could as well be a corner's.
    const bool sharp = i < offsets.count && length_px >= least_radius_before_own_color_px &&
                       is_on_outline(offsets[i], length_px, blur_px);
    const bool runs_on = outside.fraction(0) > 0.5 && !sharp;
    rim.pixels += outside.pixels;
    if (!sharp) rim.colored += outside.colored;
    colors[i] = sector_color(inside, outside);
    hidden += colors[i] == SectorColor::covered || colors[i] == SectorColor::unseen ? 1 : 0;
    radius_sum_px += length_px;
    if (!sharp) {
      for (const double height : {0.24, 0.31}) look(rim, 1 + clear + height);
    }
    supported[i] = edges[i] && inside.fraction(1) >= 0.5 && !runs_on;
  }
  support.arc = supported.fraction();
  support.arc_in_runs = supported.fraction_in_arcs();
  support.fill = disc.fraction(0);
  support.leak = rim.fraction(0);
  support.hidden = static_cast<double>(hidden) / edges.count;
  if (offsets.count == edges.count)
    support.shape = outline_shape(offsets, colors, radius_sum_px / edges.count, blur_px);
  return support;
}

}  // namespace ballservo
