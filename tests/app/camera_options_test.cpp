// Which camera --camera and --fov stand for, and how sure its balls are.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "app/commands/ball_options.hpp"
#include "app/commands/command.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/output.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

const Eigen::Vector3d point(0.31, -0.2, 1);

DetectorFactory factory_of(const std::string& camera, const std::string& fov) {
  BallOptions options;
  options.colors = (test::project_data_dir() / "colors/red.colors").string();
  options.diameter = "0.07";
  options.camera = camera;
  options.fov = fov;
  return DetectorFactory(options, CommonOptions());
}

/// The standard deviation of the range to a ball at that place, whose outline is known exactly (m).
double range_sigma_m(const DetectorFactory& factory, const Eigen::Vector3d& p_C) {
  BallObservation ball;
  ball.color_class = 1;
  ball.position = BallPosition{p_C, Eigen::Matrix3d::Zero()};
  const Eigen::Matrix3d covariance_m2 = factory.with_total_covariance(ball).position->covariance_m2;
  return std::sqrt(p_C.normalized().dot(covariance_m2 * p_C.normalized()));
}

TEST(CameraOptions, AScaledCameraSeesTheSameRaysAsSurely) {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "camera.yaml").string();
  const Camera camera(
      CameraParameters{LensModel::brown, {640, 480}, 600, 605, 310, 245, {-0.1, 0.02, 1e-3, -1e-3}}, file);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(9, 9);
  covariance.diagonal().head<4>() << 4, 4, 1, 1;
  const CameraFileFormat& format = camera_file_format("ros", file);
  write_file(file, camera_file_text(camera, format, "camera"), Overwrite::refuse);
  write_file(file + ".covariance.json", camera_covariance_text(camera, covariance), Overwrite::refuse);
  const DetectorFactory whole = factory_of(file, ""), half = factory_of(file + "@320x240", "");
  try {
    half.make({640, 480}, "a.png");
    ADD_FAILURE() << "a camera of another size";
  } catch (const InputError& error) {
    EXPECT_EQ(to_text(error.faults().front()),
              "--camera: found a camera of 320 x 240 pixels; allowed: one of 640 x 480, the size of a.png; "
              "or FILE@640x480, if that was made smaller or larger");
  }
  const auto in = [](const DetectorFactory& factory, ImageSize size) {
    return *factory.make(size, "picture").rays().camera().project(point);
  };
  const Eigen::Vector2d p = in(whole, {640, 480}), q = in(half, {320, 240});
  EXPECT_NEAR(q.x(), (p.x() + 0.5) / 2 - 0.5, 1e-9);
  EXPECT_NEAR(q.y(), (p.y() + 0.5) / 2 - 0.5, 1e-9);
  EXPECT_GT(range_sigma_m(whole, {0.1, 0, 1}), 1e-3);
  EXPECT_NEAR(range_sigma_m(half, {0.1, 0, 1}), range_sigma_m(whole, {0.1, 0, 1}), 1e-6);
  for (const char* size : {"@320x200", "@320", "@0x0", "@320x240x3"})
    EXPECT_THROW(factory_of(file + size, ""), InputError) << size;
}

TEST(CameraOptions, AFieldOfViewIsAnApproximateCamera) {
  const DetectorFactory factory = factory_of("", "60");
  for (const ImageSize size : {ImageSize{640, 480}, ImageSize{1920, 1080}}) {
    const auto right = factory.make(size, "picture").rays().camera().project({std::tan(M_PI / 6), 0, 1});
    EXPECT_NEAR(right->x(), size.width_px - 0.5, 1e-9);
  }
  EXPECT_NE(factory.doubt(), "");
  EXPECT_NEAR(range_sigma_m(factory, {0, 0, 2}), 0.24, 0.02);  // 54 to 66 degrees: 628 to 493 px
  EXPECT_NEAR(range_sigma_m(factory_of("", "60+-1"), {0, 0, 2}), 0.04, 0.005);
  for (const char* fov : {"0", "wide", "170", "60+-30", "60+-", "60+--1"})
    EXPECT_THROW(factory_of("", fov), InputError) << fov;
  EXPECT_THROW(factory_of((test::project_data_dir() / "cameras/narrow.yaml").string(), "60"), InputError);
}

TEST(CameraOptions, ADetectorKnowsHowItsPicturesWereStored) {
  const std::string camera = (test::project_data_dir() / "cameras/narrow.yaml").string();
  for (const DetectorFactory& factory : {factory_of("", "60"), factory_of(camera, "")})
    for (const bool coarse : {false, true})
      EXPECT_EQ(factory.make({640, 480}, "picture", {false, coarse}).response().coarse_chroma, coarse);
}

TEST(CameraOptions, WithoutACameraAVideosBallMayBeMoreOfAnOvalThanAStills) {
  const auto oval = [](const DetectorFactory& factory, bool still) {
    return factory.make({640, 480}, "picture", {still, false}).options().oval_fraction;
  };
  BallOptions options;
  options.color_table = std::make_shared<const ColorTable>();
  const DetectorFactory without(options, CommonOptions()), with = factory_of("", "60");
  EXPECT_GT(oval(without, true), 0.005);
  EXPECT_GT(oval(without, false), 2 * oval(without, true));
  for (const bool still : {true, false}) EXPECT_EQ(oval(with, still), 0);
}

}  // namespace
}  // namespace ballservo
