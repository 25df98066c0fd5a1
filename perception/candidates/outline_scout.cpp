#include "perception/candidates/outline_scout.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

// Along each line across the outline so many places to each side are compared, and what is compared.
constexpr int profile_reach = 5, half_step = 2;
constexpr int profile = 2 * (profile_reach + half_step) + 1;
constexpr int sectors = 40;
constexpr int circle_reweightings = 4;
constexpr int min_outline_step = 12;      // across the outline, grey levels summed over the channels
constexpr double least_in_picture = 0.3;  // of the sectors

struct Step {
  bool seen = false;
  double size = 0, offset = 0;  // places
};

// Where along a line across the outline the colours before and behind differ most: sum over the channels.
Step largest_step(const Eigen::Vector3f (&colors)[profile]) {
  float sizes[2 * profile_reach + 1];
  for (int i = 0; i <= 2 * profile_reach; ++i) {
    const Eigen::Vector3f* const at = &colors[i + half_step];
    sizes[i] = 0.5f * (at[-1] + at[-2] - at[1] - at[2]).lpNorm<1>();
  }
  const float* const best = std::max_element(std::begin(sizes), std::end(sizes));
  // At either end it may go on rising beyond.
  if (best == std::begin(sizes) || best + 1 == std::end(sizes)) return {};
  const double before = static_cast<double>(best[-1]), here = static_cast<double>(*best),
               after = static_cast<double>(best[1]);
  const double bend = before - 2 * here + after;
  const double to_top = bend < 0 ? 0.5 * (before - after) / bend : 0;
  return {true, here, static_cast<double>(best - sizes) - profile_reach + to_top};
}

// A cone's outline in a picture.
class ConeOutline {
 public:
  ConeOutline(const Camera& camera, const TangentCone& cone)
      : camera_(camera), cone_(cone), basis_(perpendicular_basis(cone.axis)), focal_px_(camera.focal_px()) {}

  // A cone that much wider, as the part of its rays along the axis and across.
  Eigen::Vector2d opening(double outside_px) const {
    const double angle = cone_.alpha_rad + outside_px / focal_px_;
    return {std::cos(angle), std::sin(angle)};
  }
  Eigen::Vector3d ray(const Eigen::Vector2d& direction, const Eigen::Vector2d& opening) const {
    return cone_.axis * opening.x() + basis_ * direction * opening.y();
  }
  // Between two cones; nothing where the line leaves the picture.
  std::optional<Step> step(const cv::Mat& bgr, const Eigen::Vector2d& direction,
                           const Eigen::Vector2d& narrow, const Eigen::Vector2d& wide) const {
    const auto inner = camera_.project(ray(direction, narrow)), outer = camera_.project(ray(direction, wide));
    if (!inner || !outer || !is_inside(bgr, *inner) || !is_inside(bgr, *outer)) return std::nullopt;
    Eigen::Vector3f colors[profile];
    const Eigen::Vector2d along = (*outer - *inner) / (profile - 1);
    for (int k = 0; k < profile; ++k) {
      const Eigen::Vector2d at = *inner + k * along;
      const cv::Vec3b& color =
          bgr.at<cv::Vec3b>(static_cast<int>(at.y() + 0.5), static_cast<int>(at.x() + 0.5));
      colors[k] = Eigen::Vector3f(color[0], color[1], color[2]);
    }
    return largest_step(colors);
  }
  // The cone whose outline lies so far outside, at angle 0, in the mean and by the cosine and sine.
  TangentCone moved(const Eigen::Vector3d& px) const {
    const Eigen::Vector3d rad = px / focal_px_;
    return {(cone_.axis + basis_ * rad.tail<2>()).normalized(), cone_.alpha_rad + rad(0)};
  }

 private:
  static bool is_inside(const cv::Mat& bgr, const Eigen::Vector2d& at) {
    return at.minCoeff() >= 0 && at.x() <= bgr.cols - 1 && at.y() <= bgr.rows - 1;
  }
  const Camera& camera_;
  TangentCone cone_;
  Eigen::Matrix<double, 3, 2> basis_;
  double focal_px_;
};

struct Pass {
  double within_px, spacing_px;  // how far from the outline an edge counts, and between the places compared
  int looks;
  double agreeing;  // of the least number of looks with an edge, what must agree with their common move
};

// The steps around an outline that count, and in how many looks there might have been one.
struct SeenSteps {
  std::array<Eigen::Vector2d, sectors> direction;  // (cosine, sine)
  std::array<double, sectors> offset_px;
  int count = 0, in_picture = 0;

  Eigen::Vector3d mean_and_wave(std::size_t i) const { return {1, direction[i].x(), direction[i].y()}; }
};

SeenSteps look_around(const cv::Mat& bgr, const ConeOutline& outline, const Pass& pass) {
  SeenSteps steps;
  const double end_px = (profile_reach + half_step) * pass.spacing_px;
  const Eigen::Vector2d narrow = outline.opening(-end_px), wide = outline.opening(end_px);
  for (int i = 0; i < pass.looks; ++i) {
    const double angle = 2 * M_PI * (i + 0.5) / pass.looks;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const auto step = outline.step(bgr, direction, narrow, wide);
    if (!step) continue;
    ++steps.in_picture;
    const double offset_px = step->offset * pass.spacing_px;
    if (!step->seen || step->size < min_outline_step || std::abs(offset_px) > pass.within_px) continue;
    const auto at = static_cast<std::size_t>(steps.count++);
    steps.direction[at] = direction;
    steps.offset_px[at] = offset_px;
  }
  return steps;
}

// What the steps say together of where the outline lies (mean, cosine, sine), by least absolute deviations:
// at first many of them are other things' edges.
Eigen::Vector3d common_move_px(const SeenSteps& steps, double floor_px) {
  Eigen::Vector3d move_px(0, 0, 0);
  for (int iteration = 0; iteration < circle_reweightings; ++iteration) {
    Eigen::Matrix3d normal = 1e-6 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < static_cast<std::size_t>(steps.count); ++i) {
      const Eigen::Vector3d row = steps.mean_and_wave(i);
      const double weight = 1 / std::max(floor_px, std::abs(steps.offset_px[i] - move_px.dot(row)));
      normal += weight * row * row.transpose();
      right += weight * steps.offset_px[i] * row;
    }
    move_px = normal.ldlt().solve(right);
  }
  return move_px;
}

}  // namespace

bool scout_outline(const cv::Mat& bgr, const Camera& camera, const TangentCone& start, double reach_px,
                   double min_support, ScoutedOutline& found) {
  const double focal_px = camera.focal_px(), radius_px = start.alpha_rad * focal_px;
  // What a real ball departs from a sphere, and its outline from a cone's, grows with it.
  const double on_outline_px = 0.35 + 0.025 * radius_px;
  found.cone = start;
  const auto take = [&](const Pass& pass) {
    const ConeOutline outline(camera, found.cone);
    const SeenSteps steps = look_around(bgr, outline, pass);
    const double least = min_support * steps.in_picture;
    if (steps.in_picture < least_in_picture * pass.looks || steps.count < least) return false;
    const Eigen::Vector3d move_px = common_move_px(steps, 0.3 * pass.spacing_px);
    int agreeing = 0;
    found.points.clear();
    for (std::size_t i = 0; i < static_cast<std::size_t>(steps.count); ++i) {
      const double rest_px = steps.offset_px[i] - move_px.dot(steps.mean_and_wave(i));
      agreeing += std::abs(rest_px) <= 2 * pass.spacing_px ? 1 : 0;
      const Eigen::Vector3d edge = outline.ray(steps.direction[i], outline.opening(steps.offset_px[i]));
      if (edge.z() > 0)
        found.points.push_back({(focal_px / edge.z() * edge.head<2>()).cast<float>(), {0, 0}});
    }
    if (agreeing < pass.agreeing * least) return false;
    found.cone = outline.moved(move_px);
    return found.cone.axis.z() > 0 && found.cone.alpha_rad > 0;
  };
  // From far with half of the sectors; nearer; and at last what lies on the outline counts.
  for (double within_px = std::min(reach_px, radius_px); within_px > profile_reach; within_px /= 2)
    if (!take({within_px, within_px / profile_reach, sectors / 2, 0.7})) return false;
  return take({profile_reach, 1, sectors / 2, 0.7}) && take({0.5 * profile_reach, 1, sectors, 0.7}) &&
         take({on_outline_px, 1, sectors, 1});
}

}  // namespace ballservo
