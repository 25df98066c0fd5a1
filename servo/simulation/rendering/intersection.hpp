// Where rays meet the shapes of a scene.
#pragma once

#include <Eigen/Core>
#include <limits>

#include "servo/simulation/rendering/scene.hpp"

namespace ballservo {

inline constexpr double no_hit = std::numeric_limits<double>::infinity();

/// Distance along the ray to a solid's surface, `no_hit` where it misses it or starts inside.
double hit_solid(const SceneSolid& solid, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction);

/// Face (0-5: -x +x -y +y -z +z of its own frame; cylinders: 0 the side, 4 and 5 the ends), normal and
/// surface coordinates of a point on the solid.
void describe_hit(const SceneSolid& solid, const Eigen::Vector3d& p, const Eigen::Vector3d& direction,
                  SurfaceHit& hit, int& face);

}  // namespace ballservo
