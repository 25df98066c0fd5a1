#include "servo/simulation/truth.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ballservo {

namespace {

constexpr int polygon_points = 256;
constexpr int rows = 64, samples_per_row = 48;

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

/// Whether anything at all could stand in front of the ball: its tangent cone meets the bounding cone of
/// something that is nearer.
bool anything_in_front(const Scene& scene, const Eigen::Vector3d& origin, std::size_t own) {
  const Eigen::Vector3d away = scene.balls()[own].center - origin;
  const double distance = away.norm(), angle = std::asin(std::min(scene.balls()[own].radius / distance, 1.0));
  const auto in_front = [&](const Eigen::Vector3d& center, double radius) {
    const Eigen::Vector3d other = center - origin;
    const double other_distance = other.norm();
    if (other_distance <= radius) return true;
    if (other_distance - radius > distance) return false;
    const double between = std::atan2(away.cross(other).norm(), away.dot(other));
    return between < angle + std::asin(radius / other_distance);
  };
  for (const SceneSolid& solid : scene.solids()) {
    if (in_front(solid.center, solid.bounding_radius)) return true;
  }
  for (std::size_t k = 0; k < scene.balls().size(); ++k) {
    if (k != own && in_front(scene.balls()[k].center, scene.balls()[k].radius)) return true;
  }
  return false;
}

/// Where the line y = const cuts a convex polygon.
std::pair<double, double> chord(const std::vector<Eigen::Vector2d>& polygon, double y) {
  double low = 1e300, high = -1e300;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector2d &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    if ((a.y() <= y) == (b.y() <= y)) continue;
    const double x = a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    low = std::min(low, x);
    high = std::max(high, x);
  }
  return {low, high};
}

double visible_fraction(const Camera& camera, const Scene& scene, const CameraView& view, std::size_t own,
                        const std::vector<Eigen::Vector2d>& outline) {
  const auto [lowest, highest] = std::minmax_element(
      outline.begin(), outline.end(), [](const auto& a, const auto& b) { return a.y() < b.y(); });
  const double top = lowest->y(), bottom = highest->y();
  const double right_edge = camera.size().width_px - 0.5, bottom_edge = camera.size().height_px - 0.5;
  const bool check_hidden = anything_in_front(scene, view.X_WC.translation(), own);
  double area = 0, visible = 0;
  for (int row = 0; row < rows; ++row) {
    const double y = top + (row + 0.5) / rows * (bottom - top);
    const auto [low, high] = chord(outline, y);
    if (high <= low) continue;
    area += high - low;
    if (y < -0.5 || y > bottom_edge) continue;
    const double from = std::max(low, -0.5), to = std::min(high, right_edge);
    if (to <= from) continue;
    double share = 1.0;
    if (check_hidden) {
      // Along the row rays turn evenly enough.
      const auto first = camera.unproject({from, y}), last = camera.unproject({to, y});
      int seen = 0;
      for (int k = 0; first && last && k < samples_per_row; ++k) {
        const double at = (k + 0.5) / samples_per_row;
        const Eigen::Vector3d ray = ((1 - at) * *first + at * *last).normalized();
        if (!hidden(scene, view.X_WC.translation(), view.X_WC.linear() * ray, own)) ++seen;
      }
      share = static_cast<double>(seen) / samples_per_row;
    }
    visible += share * (to - from);
  }
  return area > 0 ? std::clamp(visible / area, 0.0, 1.0) : 0.0;
}

}  // namespace

std::vector<BallTruth> ball_truth(const Camera& camera, const World& world, const CameraView& view) {
  const Scene scene(world, view.time_s);
  std::vector<BallTruth> truths;
  for (std::size_t k = 0; k < world.balls.size(); ++k) {
    const Ball& ball = world.balls[k];
    BallTruth truth;
    truth.name = ball.name;
    truth.class_name = ball.class_name;
    truth.p_CB = view.X_WC.inverse() * scene.balls()[k].center;
    truth.outline = project_sphere(camera, truth.p_CB, ball.radius_m());
    if (truth.outline) {
      truth.visible_fraction = visible_fraction(
          camera, scene, view, k, project_outline(camera, truth.p_CB, ball.radius_m(), polygon_points));
    }
    if (const auto pixel = camera.project(truth.p_CB)) {
      truth.center_in_view = pixel->x() >= -0.5 && pixel->x() <= camera.size().width_px - 0.5 &&
                             pixel->y() >= -0.5 && pixel->y() <= camera.size().height_px - 0.5;
    }
    const double distance = truth.p_CB.norm();
    truth.center_hidden = distance > 0 && hidden(scene, view.X_WC.translation(),
                                                 view.X_WC.linear() * (truth.p_CB / distance), k);
    truths.push_back(std::move(truth));
  }
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
