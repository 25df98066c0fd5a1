// A camera's file taken for pictures of its sensor at another size.
#include <gtest/gtest.h>

#include "calibration/base/fault.hpp"
#include "calibration/base/output.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

TEST(ScaledCamera, SeesTheSameRaysAsSurely) {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "camera.yaml").string();
  const Camera camera(
      CameraParameters{LensModel::brown, {640, 480}, 600, 605, 310, 245, {-0.1, 0.02, 1e-3, -1e-3}}, file);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(9, 9);
  covariance.diagonal().head<5>() << 4, 4, 1, 1, 1e-4;
  write_file(file, camera_file_text(camera, camera_file_format("ros", file), "camera"), Overwrite::refuse);
  write_file(file + ".covariance.json", camera_covariance_text(camera, covariance), Overwrite::refuse);
  const std::string half_name = file + "@320x240";
  const Camera half = read_camera(half_name);
  EXPECT_EQ(half.size().width_px, 320);
  const Eigen::Vector3d point(0.31, -0.2, 1);
  const Eigen::Vector2d p = *camera.project(point), q = *half.project(point);
  EXPECT_NEAR(q.x(), (p.x() + 0.5) / 2 - 0.5, 1e-9);
  EXPECT_NEAR(q.y(), (p.y() + 0.5) / 2 - 0.5, 1e-9);
  const auto known = read_camera_covariance(half_name, half);
  ASSERT_TRUE(known);
  EXPECT_EQ(known->covariance(0, 0), 1);
  EXPECT_EQ(known->covariance(2, 2), 0.25);
  EXPECT_EQ(known->covariance(4, 4), 1e-4);
  for (const char* size : {"@320x200", "@320", "@0x0", "@320x240x3"})
    EXPECT_THROW(read_camera(file + size), InputError) << size;
}

}  // namespace
}  // namespace ballservo
