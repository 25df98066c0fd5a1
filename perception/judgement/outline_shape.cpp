#include "perception/judgement/outline_shape.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

constexpr double two_pi = 6.283185307179586;
// The window in which a curvature is told: so far (rad) to each side.
constexpr double reach_rad = 0.35;
// Edges of clean pictures are less blurred than this; above, their shape means less and less (px).
constexpr double sharp_px = 2, smeared_px = 2.4;

bool is_own(SectorColor color) { return color == SectorColor::bounded || color == SectorColor::leaking; }

// The parabola through the offsets around a sector: its second derivative by the angle as a part of the
// radius, 0 for the outline itself and 1 for a straight line (r / cos(a) - r ~ r a^2 / 2), and how well it
// fits.
struct LocalRun {
  bool told = false;
  double bend = 0, scatter_px = 0;
};

LocalRun local_run(const EdgeOffsets& offsets, int at, int reach, double radius_px) {
  const int count = offsets.count;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double squares = 0;
  int seen = 0;
  for (int j = -reach; j <= reach; ++j) {
    const double offset = static_cast<double>(offsets[(at + j + count) % count]);
    if (std::isnan(offset)) continue;
    const double angle = j * two_pi / count;
    const Eigen::Vector3d row(1, angle, 0.5 * angle * angle);
    normal += row * row.transpose();
    right += row * offset;
    squares += offset * offset;
    ++seen;
  }
  if (seen < std::max(3, 2 * reach)) return {};
  const Eigen::Vector3d p = normal.ldlt().solve(right);
  const double rest = squares - 2 * p.dot(right) + p.dot(normal * p);
  return {true, p(2) / radius_px, std::sqrt(std::max(0.0, rest) / seen)};
}

double straight_share(const EdgeOffsets& offsets, const SectorColors& colors, double radius_px) {
  const int count = offsets.count;
  const int reach = std::max(1, static_cast<int>(std::lround(reach_rad * count / two_pi)));
  int straight = 0, round = 0;
  for (int i = 0; i < count; ++i) {
    if (!is_own(colors[i]) || std::isnan(offsets[i])) continue;
    const LocalRun run = local_run(offsets, i, reach, radius_px);
    if (!run.told) continue;
    if (std::abs(run.bend) < 0.5)
      ++round;
    else if (run.bend > 0 && run.bend < 1.8 && run.scatter_px < 0.15 + 0.005 * radius_px)
      ++straight;
  }
  return straight + round > 0 ? static_cast<double>(straight) / (straight + round) : 0;
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

}  // namespace ballservo
