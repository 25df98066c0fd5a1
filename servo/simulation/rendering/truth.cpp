#include "servo/simulation/rendering/truth.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "servo/simulation/rendering/scene.hpp"

namespace ballservo {

namespace {

constexpr std::size_t outline_rays = 1000;  // of a ball that is not seen whole

/// What may stand before a ball.
struct Foreground {
  Eigen::Vector3d eye, to_ball;
  std::vector<const SceneSolid*> solids;
  std::vector<const SceneBall*> balls;

  /// Whether something stands in front of the ball along a unit ray (world) that meets it.
  bool hides(const Eigen::Vector3d& ray) const {
    const double limit = to_ball.dot(ray);  // the middle of the chord: what lies before it hides the ball
    const auto solid_hides = [&](const SceneSolid* solid) { return hit_solid(*solid, eye, ray) < limit; };
    const auto ball_hides = [&](const SceneBall* ball) {
      const Eigen::Vector3d away = ball->center - eye;
      const double along = away.dot(ray);
      return along > 0 && along < limit && away.squaredNorm() - along * along < ball->radius * ball->radius;
    };
    return std::any_of(solids.begin(), solids.end(), solid_hides) ||
           std::any_of(balls.begin(), balls.end(), ball_hides);
  }
};

/// `within_rad`: only what comes nearer than that to the ray to the ball's centre is asked for.
Foreground foreground(const Scene& scene, const Eigen::Vector3d& eye, std::size_t ball, double within_rad) {
  Foreground before{eye, scene.balls()[ball].center - eye, {}, {}};
  const auto may_hide = [&](const Eigen::Vector3d& center, double radius) {
    const Eigen::Vector3d away = center - eye;
    const double distance = away.norm();
    if (distance <= radius) return true;
    const double aside = std::atan2(away.cross(before.to_ball).norm(), away.dot(before.to_ball));
    return distance - radius < before.to_ball.norm() && aside - std::asin(radius / distance) < within_rad;
  };
  for (const SceneSolid& solid : scene.solids())
    if (may_hide(solid.center, solid.bounding_radius)) before.solids.push_back(&solid);
  for (std::size_t k = 0; k < scene.balls().size(); ++k) {
    const SceneBall& other = scene.balls()[k];
    if (k != ball && may_hide(other.center, other.radius)) before.balls.push_back(&other);
  }
  return before;
}

/// See BallTruth. Rays through the circle where they touch the ball, spread evenly over it, each with the
/// area that the lens makes of its part.
double visible_fraction(const Camera& camera, const Scene& scene, const CameraView& view, std::size_t index,
                        const Eigen::Vector3d& p_CB) {
  const double radius = scene.balls()[index].radius, sine = radius / p_CB.norm();
  const Foreground before = foreground(scene, view.X_WC.translation(), index, std::asin(sine));
  const bool whole = is_inside_picture(project_outline(camera, p_CB, radius, 32), camera.size());
  if (whole && before.solids.empty() && before.balls.empty()) return 1;
  const Eigen::Vector3d middle = (1 - sine * sine) * p_CB;
  const Eigen::Matrix<double, 3, 2> across = perpendicular_basis(p_CB);
  std::array<Eigen::Vector3d, outline_rays> rays;
  std::array<bool, outline_rays> seen;
  for (std::size_t k = 0; k < outline_rays; ++k) {
    rays[k] = middle + radius * std::sqrt(1 - sine * sine) * across * disc_samples<outline_rays>()[k];
    seen[k] = (whole || camera.shows(rays[k])) && !before.hides(view.X_WC.linear() * rays[k].normalized());
  }
  if (std::count(seen.begin(), seen.end(), seen[0]) == outline_rays) return seen[0] ? 1 : 0;
  double area = 0, visible = 0;
  for (std::size_t k = 0; k < outline_rays; ++k) {
    const auto jacobian = camera.project_jacobian(rays[k]);
    const double part = jacobian ? std::abs((*jacobian * across).determinant()) : 0;
    area += part;
    visible += seen[k] ? part : 0;
  }
  return visible / area;
}

BallTruth truth_in(const Camera& camera, const World& world, const Scene& scene, const CameraView& view,
                   std::size_t index) {
  const Ball& ball = world.balls[index];
  BallTruth truth;
  truth.name = ball.name;
  truth.class_name = ball.class_name;
  truth.p_CB = view.X_WC.inverse() * scene.balls()[index].center;
  truth.outline = project_sphere(camera, truth.p_CB, ball.radius_m());
  if (truth.outline) truth.visible_fraction = visible_fraction(camera, scene, view, index, truth.p_CB);
  truth.center_in_view = camera.shows(truth.p_CB);
  return truth;
}

}  // namespace

BallTruth ball_truth(const Camera& camera, const World& world, const CameraView& view, std::size_t index) {
  return truth_in(camera, world, Scene(world, view.time_s), view, index);
}

std::vector<BallTruth> ball_truth(const Camera& camera, const World& world, const CameraView& view) {
  const Scene scene(world, view.time_s);
  std::vector<BallTruth> truths;
  for (std::size_t k = 0; k < world.balls.size(); ++k)
    truths.push_back(truth_in(camera, world, scene, view, k));
  return truths;
}

cv::Mat unhidden_pixels(const Camera& camera, const World& world, const CameraView& view, std::size_t index,
                        const cv::Rect& box) {
  const Scene scene(world, view.time_s);
  const cv::Size size(camera.size().width_px, camera.size().height_px);
  const Foreground before = foreground(scene, view.X_WC.translation(), index, M_PI);
  cv::Mat unhidden = cv::Mat::zeros(size, CV_8UC1);
  const cv::Rect inside = box & cv::Rect({0, 0}, size);
  for (int v = inside.y; v < inside.y + inside.height; ++v) {
    for (int u = inside.x; u < inside.x + inside.width; ++u) {
      const auto ray = camera.unproject({u, v});
      if (ray && !before.hides(view.X_WC.linear() * *ray)) unhidden.at<std::uint8_t>(v, u) = 255;
    }
  }
  return unhidden;
}

}  // namespace ballservo
