// What is exactly true of every ball in a frame.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration/camera/camera.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "servo/simulation/rendering/camera_view.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

class Scene;

struct BallTruth {
  std::string name, class_name;
  Eigen::Vector3d p_CB{0, 0, 0};          ///< centre in the camera frame (m)
  std::optional<OutlineEllipse> outline;  ///< nothing where the outline cannot be projected
  /// Fraction of the outline's area that the camera sees: inside the picture and not behind anything. 0
  /// without an outline.
  double visible_fraction = 0;
  bool center_in_view = false;  ///< the centre's image lies inside the picture
  bool center_hidden = false;   ///< something stands between the camera and the ball's middle
};

/// One entry per ball of the world, in its order. Exact; the visible fraction of a partly hidden ball to
/// about 0.002.
std::vector<BallTruth> ball_truth(const Camera& camera, const World& world, const CameraView& view);
/// Of one ball alone.
BallTruth ball_truth(const Camera& camera, const World& world, const CameraView& view, std::size_t index);

/// The fraction of the area (px^2) of a ball's outline that lies in the picture and not behind anything. The
/// ball must be seen whole by the lens (project_sphere), if not by the picture.
///
/// In the plane across the ray to the ball's centre the outline is a circle, the shadow of a box or column a
/// convex polygon (the hull of its corners; round things have 48 of them) and that of a ball a conic: of each
/// of 256 rows the hidden part is known in closed form, weighted with the area that the lens makes of it.
/// Exact to about 0.002 where something is cut off, else exactly 1 or 0.
double visible_fraction(const Camera& camera, const Scene& scene, const Eigen::Isometry3d& X_WC,
                        std::size_t ball);

/// Where ball `index` hides what is behind it, or would: CV_8UC1 of the camera's size, 0 where something
/// stands nearer than the ball's middle, and outside `box` (px), which bounds the cost.
cv::Mat unhidden_pixels(const Camera& camera, const World& world, const CameraView& view, std::size_t index,
                        const cv::Rect& box);

}  // namespace ballservo
