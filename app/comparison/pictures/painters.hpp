// The three painters of a comparison's frames, and what they share.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "app/comparison/pictures/rendered_frame.hpp"
#include "calibration/base/random.hpp"
#include "servo/simulation/rendering/camera_renderer.hpp"

namespace ballservo {

/// All chance comes from the engine. The `frame` number seeds the lab's sensor noise, too.
RenderedFrame lab_frame(const ComparisonCondition& condition, RandomEngine& engine, int frame);
RenderedFrame room_frame(const ComparisonCondition& condition, RandomEngine& engine);
RenderedFrame painted_frame(const ComparisonCondition& condition, RandomEngine& engine);

/// In every painter's frames the ball's depth is the condition's, more or less by up to this part of it.
inline constexpr double depth_jitter = 0.02;

/// A ball at the condition's depth and angle off the axis, in a direction (rad) of the picture.
Eigen::Vector3d place_off_axis(const ComparisonCondition& condition, double azimuth_rad);

/// Evenly spread directions (rad, of the picture) off the axis in which the whole ball is in the picture.
std::vector<double> usable_azimuths(const ComparisonCondition& condition);

/// Channels of a picture of a red, green or blue ball, red 0: the ball's own, and the other two.
struct BallChannels {
  int own, other_1, other_2;
  explicit BallChannels(int own_channel)
      : own(own_channel), other_1(own == 0 ? 1 : 0), other_2(own == 2 ? 1 : 2) {}
};
/// 0, 1 or 2 for "red", "green", "blue".
int own_channel(const std::string& ball_color);

/// Where the ball stands (m, camera frame) in a room or painted picture: off the axis as the condition says,
/// within 0.2 rad of it where that says 0, or at the picture's border.
Eigen::Vector3d draw_ball_place(const ComparisonCondition& condition, RandomEngine& engine);

/// A camera at `p_WC` (m) that looks along the world's x axis, upright.
Eigen::Isometry3d level_camera(const Eigen::Vector3d& p_WC);

/// How far from a disc's centre (in radii) a straight edge runs that hides the given fraction of it.
double hiding_edge_distance(double hidden_fraction);

/// The sides of a picture, left first, as OcclusionSide has them.
inline const Eigen::Vector2d picture_sides[] = {{-1, 0}, {1, 0}, {0, 1}, {0, -1}};

inline Eigen::Vector2d unit_vector(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }

/// Any pattern, of two colours that `draw_color` gives, the second nearer to the first.
template <class DrawColor>
Texture random_texture(DrawColor draw_color, double least_scale_m, RandomEngine& engine) {
  Texture texture;
  texture.pattern = all_patterns[uniform_index(engine, static_cast<std::uint32_t>(all_patterns.size()))];
  texture.color = draw_color();
  texture.color_2 = 0.6 * texture.color + 0.4 * draw_color();
  texture.scale_m = uniform(engine, least_scale_m, 0.4);
  return texture;
}

/// A rendered picture in the making.
struct Stage {
  const ComparisonCondition& condition;
  Eigen::Vector3d p_CB{0, 0, 0};  ///< where the ball stands, if there is one (m)
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  World world{};

  /// Adds the ball, of that colour.
  Ball& put_ball(const Rgb& color);
  /// Adds an obstacle whose centre is at `p_C` (m, camera frame).
  void put(const Shape& shape, const Eigen::Vector3d& p_C, double yaw_rad, const Texture& texture);
  /// Its picture, seen from `views` while the camera is exposed, with noise from the engine and
  /// `noise_frame`.
  RenderedFrame picture(const std::vector<CameraView>& views, RandomEngine& engine,
                        std::uint64_t noise_frame) const;
};

}  // namespace ballservo
