#include "perception/outline_scout.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

constexpr double two_pi = 6.283185307179586;
constexpr int reach = 5, width = 2;  // px: how far from the outline its edge is sought, and what is compared
constexpr int profile = 2 * (reach + width) + 1;
constexpr int sectors = 40;

struct Step {
  bool seen = false;
  double size = 0, offset_px = 0;
};

// Where along a line across the outline the colours before and behind differ most: sum over the channels.
Step largest_step(const std::array<Eigen::Vector3f, profile>& colors) {
  std::array<float, 2 * reach + 1> sizes;
  for (int i = 0; i <= 2 * reach; ++i) {
    const auto at = static_cast<std::size_t>(i + width);
    sizes[static_cast<std::size_t>(i)] =
        0.5f * (colors[at - 1] + colors[at - 2] - colors[at + 1] - colors[at + 2]).lpNorm<1>();
  }
  const auto best = std::max_element(sizes.begin(), sizes.end());
  // At either end it may go on rising beyond.
  if (best == sizes.begin() || best + 1 == sizes.end()) return {};
  const double before = static_cast<double>(best[-1]), here = static_cast<double>(*best),
               after = static_cast<double>(best[1]);
  const double bend = before - 2 * here + after;
  const double to_top = bend < 0 ? 0.5 * (before - after) / bend : 0;
  return {true, here, static_cast<double>(best - sizes.begin()) - reach + to_top};
}

// A cone's outline in a picture.
class Outline {
 public:
  Outline(const Camera& camera, const TangentCone& cone)
      : camera_(camera), cone_(cone), basis_(perpendicular_basis(cone.axis)), focal_px_(camera.focal_px()) {}

  Eigen::Vector3d ray(double angle, double outside_px) const {
    const double opening = cone_.alpha_rad + outside_px / focal_px_;
    return cone_.axis * std::cos(opening) +
           basis_ * Eigen::Vector2d(std::cos(angle), std::sin(angle)) * std::sin(opening);
  }
  Step step(const cv::Mat& bgr, double angle) const {
    const auto inner = camera_.project(ray(angle, -reach - width)),
               outer = camera_.project(ray(angle, reach + width));
    if (!inner || !outer || !is_inside(bgr, *inner) || !is_inside(bgr, *outer)) return {};
    std::array<Eigen::Vector3f, profile> colors;
    const Eigen::Vector2d along = (*outer - *inner) / (profile - 1);
    for (int k = 0; k < profile; ++k) {
      const Eigen::Vector2d at = *inner + k * along;
      const cv::Vec3b& color =
          bgr.at<cv::Vec3b>(static_cast<int>(at.y() + 0.5), static_cast<int>(at.x() + 0.5));
      colors[static_cast<std::size_t>(k)] = Eigen::Vector3f(color[0], color[1], color[2]);
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

Eigen::Vector3d mean_and_wave(double angle) { return {1, std::cos(angle), std::sin(angle)}; }

}  // namespace

bool scout_outline(const cv::Mat& bgr, const Camera& camera, const TangentCone& start,
                   const OutlineScoutOptions& options, ScoutedOutline& found) {
  const double focal_px = camera.focal_px(), radius_px = start.alpha_rad * focal_px;
  found.cone = start;
  // From far with half of the sectors; nearer; and at last what lies on the outline counts.
  const std::array<double, 3> tolerances_px{reach, 0.5 * reach, 0.6 + 0.015 * radius_px};
  for (std::size_t pass = 0; pass < tolerances_px.size(); ++pass) {
    const Outline outline(camera, found.cone);
    const bool is_last = pass + 1 == tolerances_px.size();
    const int looks = pass == 0 ? sectors / 2 : sectors;
    std::array<Step, sectors> steps;
    Eigen::Matrix3d normal = 1e-6 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    found.points.clear();
    int seen = 0;
    for (int i = 0; i < looks; ++i) {
      const double angle = two_pi * (i + 0.5) / looks;
      Step& step = steps[static_cast<std::size_t>(i)] = outline.step(bgr, angle);
      step.seen =
          step.seen && step.size >= options.min_step && std::abs(step.offset_px) <= tolerances_px[pass];
      if (!step.seen) continue;
      ++seen;
      const Eigen::Vector3d row = mean_and_wave(angle);
      normal += row * row.transpose();
      right += row * step.offset_px;
      const Eigen::Vector3d edge = outline.ray(angle, step.offset_px);
      if (is_last && edge.z() > 0)
        found.points.push_back({(focal_px / edge.z() * edge.head<2>()).cast<float>(), {0, 0}});
    }
    const double least = options.min_support * looks;
    if (seen < least) return false;
    const Eigen::Vector3d move_px = normal.ldlt().solve(right);
    // Most must agree with what they say together, roughly at first.
    int agreeing = 0;
    for (int i = 0; i < looks; ++i) {
      const Step& step = steps[static_cast<std::size_t>(i)];
      const double rest_px = step.offset_px - move_px.dot(mean_and_wave(two_pi * (i + 0.5) / looks));
      agreeing += step.seen && std::abs(rest_px) <= 2 ? 1 : 0;
    }
    if (agreeing < (is_last ? 1 : 0.7) * least) return false;
    found.cone = outline.moved(move_px);
    if (!(found.cone.axis.z() > 0 && found.cone.alpha_rad > 0)) return false;
    found.support = static_cast<double>(seen) / looks;
  }
  return true;
}

}  // namespace ballservo
