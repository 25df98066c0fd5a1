#include "calibration/circles/region_circle.hpp"

#include <cmath>
#include <memory>

#include "calibration/circles/circle_vote.hpp"

namespace ballservo {

CircleEstimator region_circle_estimator(std::uint64_t seed) {
  return [seed, voter = std::make_shared<CircleVoter>()](
             const std::vector<Eigen::Vector2f>& boundary_px) -> std::optional<RegionCircle> {
    RandomEngine engine = random_stream(seed, "region_circle", boundary_px.size());
    std::vector<BoundaryPoint> points;
    for (const Eigen::Vector2f& p : boundary_px) points.push_back({p, {0, 0}});
    const auto estimate = voter->estimate(points, engine);
    if (!estimate) return std::nullopt;
    int inliers = 0;
    for (const Eigen::Vector2f& p : boundary_px) {
      const double distance = (p.cast<double>() - estimate->center_px).norm();
      if (std::abs(distance - estimate->radius_px) <= 1.5) ++inliers;
    }
    return RegionCircle{estimate->center_px, estimate->radius_px,
                        static_cast<double>(inliers) / static_cast<double>(boundary_px.size())};
  };
}

}  // namespace ballservo
