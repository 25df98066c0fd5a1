#include "app/comparison/pictures/plan_pictures.hpp"

#include <gtest/gtest.h>

#include "calibration/base/output.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

// The methods are told a camera that is off by as much as its covariance says; the picture is the true one's.
TEST(PlanPictures, MisjudgeTheCameraByItsCovariance) {
  const test::TemporaryFolder folder;
  CameraParameters p;
  p.size = {160, 120};
  p.fx_px = p.fy_px = 200;
  p.cx_px = 79.5;
  p.cy_px = 59.5;
  const Camera camera(p);
  const std::string file = (folder.path() / "camera.yaml").string();
  write_file(file, camera_file_text(camera, camera_file_format("opencv", file), "camera"), Overwrite::refuse);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(4, 4);
  covariance.diagonal() << 4, 4, 1, 1;
  write_file(covariance_file_name(file), camera_covariance_text(camera, covariance), Overwrite::refuse);
  const ComparisonPlan plan = parse_comparison_plan(
      "methods: [sphere_one_step]\ndefaults: {camera: {file: camera.yaml}, depth_m: 0.5}\n"
      "conditions: [{name: known}, {name: off, calibration_sigmas: 1}]\n",
      "plan.yaml", folder.path());
  PlanPictures source(plan);
  source.prepare({1, 1});
  EXPECT_EQ(source.picture(0, 0).detector.rays->camera().parameters().fx_px, 200);
  EXPECT_TRUE(source.picture(0, 0).truth.bound_m);
  double squares = 0;
  constexpr int frames = 14;
  for (int k = 0; k < frames; ++k) {
    const ComparisonPicture picture = source.picture(1, k);
    const double off = picture.detector.rays->camera().parameters().fx_px - 200;
    squares += off * off / frames;
    EXPECT_FALSE(picture.truth.bound_m);  // the bound knows the camera
  }
  EXPECT_NEAR(std::sqrt(squares), 2, 1.2);
}

}  // namespace
}  // namespace ballservo
