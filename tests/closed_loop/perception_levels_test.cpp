// Level geometric errs as level image does: on seeds that its constants were not measured on.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>

#include "calibration/camera/sphere_outline.hpp"
#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

constexpr std::array<double, 4> radius_limits_px{7, 12, 20, 40};
constexpr std::size_t classes = radius_limits_px.size() - 1, apart = 10;  // frames

struct Mean {
  double sum = 0;
  int count = 0;

  void add(double value) {
    sum += value;
    ++count;
  }
  double rms() const { return std::sqrt(sum / count); }
};

/// Errors of the sightings of whole balls, as px of the outline, in classes of its radius.
struct Errors {
  std::array<Mean, classes> center_px2, radius_px2;
  Mean wild, product_px4, square_px4;  // wild: 1 for an error beyond 8 / r px, else 0

  void add(const RunRecord& run, const Scenario& scenario) {
    const double focal_px = scenario.camera.camera.focal_px(), radius_m = scenario.target_ball().radius_m();
    std::vector<std::optional<Eigen::Vector3d>> times_radius;  // by frame: two axes of the centre, the radius
    for (const FrameRecord& frame : run.frames) {
      std::optional<Eigen::Vector3d>& weighted = times_radius.emplace_back();
      if (frame.measurement.state != TrackState::confirmed || frame.visible_fraction < 0.98) continue;
      const Eigen::Vector3d truth = *frame.truth_p_CB, error = frame.measurement.p_CB - truth;
      const double distance = truth.norm(), r_px = radius_m / distance * focal_px;
      const Eigen::Vector3d ray = truth / distance;
      const Eigen::Vector2d center_px = perpendicular_basis(ray).transpose() * error / distance * focal_px;
      const double radius_px = -error.dot(ray) / distance * r_px;
      for (std::size_t k = 0; k < classes; ++k) {
        if (r_px < radius_limits_px[k] || r_px >= radius_limits_px[k + 1]) continue;
        const bool is_wild = std::max(center_px.norm(), std::abs(radius_px)) > 8 / r_px;
        wild.add(is_wild ? 1 : 0);
        if (is_wild) continue;
        center_px2[k].add(center_px.squaredNorm() / 2);
        radius_px2[k].add(radius_px * radius_px);
        weighted = r_px * Eigen::Vector3d(center_px.x(), center_px.y(), radius_px);
      }
    }
    for (std::size_t k = apart; k < times_radius.size(); ++k) {
      const auto &now = times_radius[k], &before = times_radius[k - apart];
      if (!now || !before) continue;
      product_px4.add(now->dot(*before));
      square_px4.add(0.5 * (now->squaredNorm() + before->squaredNorm()));
    }
  }

  /// Of errors some frames apart.
  double correlation() const { return product_px4.sum / square_px4.sum; }
};

TEST(PerceptionLevels, GeometricErrsAsImageDoes) {
  Errors image, geometric;
  // Errors of one run are alike: many short runs, most of each on its way to the ball, tell more than few.
  // What level geometric draws for all of a run is known, and cheap: more of its runs leave less to chance.
  const auto add = [&](const char* name, std::uint64_t first, std::uint64_t count) {
    for (std::uint64_t seed = first; seed < first + 4 * count; ++seed) {
      const Scenario scenario =
          load_scenario(test::project_data_dir() / "scenarios" / name, {"duration_s=7"}, seed);
      if (seed < first + count) image.add(test::run(scenario, PerceptionLevel::image), scenario);
      geometric.add(test::run(scenario, PerceptionLevel::geometric), scenario);
    }
  };
  add("static_ball.yaml", 301, 16);
  add("obstacles.yaml", 301, 6);
  add("clutter.yaml", 301, 4);
  add("moving_ball.yaml", 301, 4);

  const auto expect_alike = [](const Mean& geometric_px2, const Mean& image_px2, const std::string& what) {
    ASSERT_GE(image_px2.count, 200) << what;
    ASSERT_GE(geometric_px2.count, 200) << what;
    const double ratio = geometric_px2.rms() / image_px2.rms();
    RecordProperty(what, std::to_string(ratio));
    EXPECT_GT(ratio, 1 / 1.5) << what << ": " << geometric_px2.rms() << " and " << image_px2.rms() << " px";
    EXPECT_LT(ratio, 1.5) << what << ": " << geometric_px2.rms() << " and " << image_px2.rms() << " px";
  };
  for (std::size_t k = 0; k < classes; ++k) {
    const std::string from = "_from_" + std::to_string(std::lround(radius_limits_px[k])) + "_px";
    expect_alike(geometric.center_px2[k], image.center_px2[k], "center" + from);
    expect_alike(geometric.radius_px2[k], image.radius_px2[k], "radius" + from);
  }
  EXPECT_LT(image.wild.sum, 0.02 * image.wild.count);
  RecordProperty("correlation_geometric", std::to_string(geometric.correlation()));
  RecordProperty("correlation_image", std::to_string(image.correlation()));
  EXPECT_NEAR(geometric.correlation(), image.correlation(), 0.2);
}

}  // namespace
}  // namespace ballservo
