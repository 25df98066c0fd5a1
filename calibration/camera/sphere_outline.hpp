// How a sphere appears: its tangent cone, its outline in the picture, and the sphere back from rays of its
// outline.
//
// A unit ray u from the camera's centre touches the sphere of centre C and radius R when u.C = sqrt(|C|^2 -
// R^2).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibration/camera/camera.hpp"

namespace ballservo {

/// The ellipse of an outline in the picture as given: centre, and geometric mean of its semi-axes.
/// For a lens that bends the outline away from an exact ellipse: centroid of the area and sqrt(area / pi),
/// which are the same thing for an ellipse.
struct OutlineEllipse {
  Eigen::Vector2d center_px{0, 0};
  double radius_px = 0;
};

/// An orthonormal pair (columns) perpendicular to `direction` (any length but 0): the first column lies as
/// near to the camera's x axis as it can.
Eigen::Matrix<double, 3, 2> perpendicular_basis(const Eigen::Vector3d& direction);

/// Unit rays that touch the sphere (centre p_C in m, radius in m), `count` of them at equal angles around the
/// axis of its tangent cone. Empty if the camera is inside the sphere or on it, or anything is not finite.
std::vector<Eigen::Vector3d> outline_rays(const Eigen::Vector3d& p_C, double radius_m, int count);

/// The outline in the picture; nothing when a part of it cannot be projected at all (behind the lens). It may
/// lie outside the picture.
std::optional<OutlineEllipse> project_sphere(const Camera& camera, const Eigen::Vector3d& p_C,
                                             double radius_m);

/// The outline as a closed polygon of `count` points (px); empty where `project_sphere` gives nothing.
std::vector<Eigen::Vector2d> project_outline(const Camera& camera, const Eigen::Vector3d& p_C,
                                             double radius_m, int count);

/// The centre of the sphere of the given radius (m) whose tangent cone passes closest to the unit rays, in
/// the sense of the linear system u.n = 1 with n = C / sqrt(|C|^2 - R^2) (so that |n| = 1/cos(alpha)). Exact
/// for exact rays; biased on short noisy arcs: a start for a fit of angles. Nothing for fewer than 3 rays or
/// a degenerate set. Takes nothing from the heap.
std::optional<Eigen::Vector3d> sphere_from_rays(const std::vector<Eigen::Vector3d>& rays, double radius_m);
std::optional<Eigen::Vector3d> sphere_from_rays(const Eigen::Ref<const Eigen::Matrix3Xd>& rays,
                                                double radius_m);

/// The same from points of its outline in a picture (px); nothing too where one of them has no ray.
std::optional<Eigen::Vector3d> sphere_from_outline(const Camera& camera,
                                                   const std::vector<Eigen::Vector2d>& outline_px,
                                                   double radius_m);

/// Whether an outline is wholly so far inside a picture of that size; false for an empty one.
bool is_inside_picture(const std::vector<Eigen::Vector2d>& outline_px, ImageSize size, double margin_px = 0);

}  // namespace ballservo
