#include "servo/simulation/rendering/truth.hpp"

#include "servo/simulation/rendering/scene.hpp"

namespace ballservo {

namespace {

/// Whether something stands in front of ball `own` along a unit ray (world) that meets it.
bool hidden(const Scene& scene, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
            std::size_t own) {
  const Eigen::Vector3d away = scene.balls()[own].center - origin;
  const double limit = away.dot(direction);  // the middle of the chord: what lies before it hides the ball
  if (scene.hit_solids(origin, direction, limit) < limit) return true;
  for (std::size_t k = 0; k < scene.balls().size(); ++k) {
    if (k == own) continue;
    const Eigen::Vector3d other = scene.balls()[k].center - origin;
    const double along = other.dot(direction);
    const double radius = scene.balls()[k].radius;
    if (along > 0 && along < limit && other.squaredNorm() - along * along < radius * radius) return true;
  }
  return false;
}

BallTruth truth_in(const Camera& camera, const World& world, const Scene& scene, const CameraView& view,
                   std::size_t index) {
  const Ball& ball = world.balls[index];
  BallTruth truth;
  truth.name = ball.name;
  truth.class_name = ball.class_name;
  truth.p_CB = view.X_WC.inverse() * scene.balls()[index].center;
  truth.outline = project_sphere(camera, truth.p_CB, ball.radius_m());
  if (truth.outline) truth.visible_fraction = visible_fraction(camera, scene, view.X_WC, index);
  if (const auto pixel = camera.project(truth.p_CB)) {
    truth.center_in_view = pixel->x() >= -0.5 && pixel->x() <= camera.size().width_px - 0.5 &&
                           pixel->y() >= -0.5 && pixel->y() <= camera.size().height_px - 0.5;
  }
  const double distance = truth.p_CB.norm();
  truth.center_hidden = distance > 0 && hidden(scene, view.X_WC.translation(),
                                               view.X_WC.linear() * (truth.p_CB / distance), index);
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
  cv::Mat unhidden = cv::Mat::zeros(size, CV_8UC1);
  const cv::Rect inside = box & cv::Rect({0, 0}, size);
  for (int v = inside.y; v < inside.y + inside.height; ++v) {
    for (int u = inside.x; u < inside.x + inside.width; ++u) {
      const auto ray = camera.unproject({u, v});
      if (ray && !hidden(scene, view.X_WC.translation(), view.X_WC.linear() * *ray, index))
        unhidden.at<std::uint8_t>(v, u) = 255;
    }
  }
  return unhidden;
}

}  // namespace ballservo
