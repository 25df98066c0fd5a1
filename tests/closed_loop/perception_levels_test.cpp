// Level geometric errs as level image does: on seeds that its constants were not measured on.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

/// Errors of a run's sightings, as px of the outline, in ranges of its radius.
struct Errors {
  static constexpr std::array<double, 4> radius_limits_px{7, 12, 20, 40};
  std::array<std::vector<double>, 3> center_px, radius_px;

  void add(const RunRecord& run, const Scenario& scenario) {
    const double focal_px = scenario.camera.camera.focal_px(), radius_m = scenario.target_ball().radius_m();
    for (const FrameRecord& frame : run.frames) {
      if (frame.measurement.state != TrackState::confirmed) continue;
      const Eigen::Vector3d truth = *frame.truth_p_CB, error = frame.measurement.p_CB - truth;
      const double distance = truth.norm(), r_px = radius_m / distance * focal_px;
      const double along = error.dot(truth) / distance;
      const Eigen::Vector3d across = error - along * truth / distance;
      for (std::size_t k = 0; k < 3; ++k) {
        if (r_px < radius_limits_px[k] || r_px >= radius_limits_px[k + 1]) continue;
        center_px[k].push_back(across.norm() / distance * focal_px / std::sqrt(2.0));
        radius_px[k].push_back(along / distance * r_px);
      }
    }
  }
};

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

TEST(PerceptionLevels, GeometricErrsAsImageDoes) {
  Errors image, geometric;
  for (const std::uint64_t seed : {301u, 302u}) {
    const Scenario scenario = test::static_ball(seed);
    image.add(test::run(scenario, PerceptionLevel::image, seed), scenario);
    geometric.add(test::run(scenario, PerceptionLevel::geometric, seed), scenario);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    ASSERT_GE(image.center_px[k].size(), 20u);
    ASSERT_GE(geometric.center_px[k].size(), 20u);
    const double center = rms(geometric.center_px[k]) / rms(image.center_px[k]);
    const double radius = rms(geometric.radius_px[k]) / rms(image.radius_px[k]);
    RecordProperty("center_ratio_" + std::to_string(k), std::to_string(center));
    RecordProperty("radius_ratio_" + std::to_string(k), std::to_string(radius));
    EXPECT_GT(center, 0.6) << "from " << Errors::radius_limits_px[k] << " px on";
    EXPECT_LT(center, 1.7) << "from " << Errors::radius_limits_px[k] << " px on";
    EXPECT_GT(radius, 0.6) << "from " << Errors::radius_limits_px[k] << " px on";
    EXPECT_LT(radius, 1.7) << "from " << Errors::radius_limits_px[k] << " px on";
  }
}

}  // namespace
}  // namespace ballservo
