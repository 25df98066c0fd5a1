// Where what a frame shows of the floor comes from: the picture, or geometry.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "app/scenario/scenario.hpp"
#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {

/// One frame, for whoever looks at the floor in it.
struct FloorInput {
  int frame = 0;
  double time_s = 0;                   ///< middle of the exposure
  Pose2 robot;                         ///< the true pose; level geometric only
  const cv::Mat* picture = nullptr;    ///< level image only
  std::optional<OutlineEllipse> ball;  ///< the target as it was seen: it is nothing that stands in the way
};

class FloorSight {
 public:
  virtual ~FloorSight() = default;
  virtual FloorScan look(const FloorInput& input) = 0;
};

/// Level image: the floor of the picture, as it looks close to the robot.
std::unique_ptr<FloorSight> make_image_floor_sight(const Scenario& scenario);
/// The other levels: geometry, of a `scenario` that must outlive it; errors of the edges' places only for
/// level geometric.
std::unique_ptr<FloorSight> make_geometric_floor_sight(const Scenario& scenario, std::uint64_t seed,
                                                       bool exact);

}  // namespace ballservo
