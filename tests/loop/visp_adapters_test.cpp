// ViSP's robots and grabbers as ports.
#include <gtest/gtest.h>
#include <visp3/core/vpFrameGrabber.h>
#include <visp3/core/vpImage.h>
#include <visp3/io/vpDiskGrabber.h>
#include <visp3/robot/vpSimulatorPioneer.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "app/loop/visp/visp_camera.hpp"
#include "app/loop/visp/visp_robot.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

constexpr double period_s = 0.02;

struct PioneerTest : testing::Test {
  PioneerTest() {
    robot.setSamplingTime(period_s);
    vpHomogeneousMatrix cMe(0.1, -0.3, 0.2, 0.4, -1.1, 0.7);  // the camera wherever it may be
    robot.vpUnicycle::set_cMe(cMe);
  }
  vpSimulatorPioneer robot;
};

TEST_F(PioneerTest, StandsWhereItBegan) {
  VispRobot port(robot, {});
  const Pose2 pose = pose_of(robot);
  EXPECT_NEAR(pose.x_m, 0, 1e-12);
  EXPECT_NEAR(pose.y_m, 0, 1e-12);
  EXPECT_NEAR(pose.yaw_rad, 0, 1e-12);
}

// ViSP integrates by Euler's rule: the two differ by half a period of the turn.
TEST_F(PioneerTest, GoesAlongTheArcThatItIsTold) {
  VispRobot by_odometry(robot, {}, [this] { return pose_of(robot); });
  const Twist2 twist{0.4, 0.5};
  double now_s = 0;
  RobotState state;
  for (int step = 0; step < 100; ++step) {
    state = by_odometry.read(now_s);
    by_odometry.command(twist, now_s);
    now_s += period_s;
  }
  state = by_odometry.read(now_s);
  const Pose2 arc = integrate({}, twist, now_s);
  EXPECT_NEAR(state.odometry.x_m, arc.x_m, twist.v_mps * now_s * twist.w_radps * period_s);
  EXPECT_NEAR(state.odometry.y_m, arc.y_m, twist.v_mps * now_s * twist.w_radps * period_s);
  EXPECT_NEAR(state.odometry.yaw_rad, arc.yaw_rad, 1e-9);
  EXPECT_NEAR(state.twist.v_mps, twist.v_mps, 1e-4);
  EXPECT_NEAR(state.twist.w_radps, twist.w_radps, 1e-9);
}

TEST_F(PioneerTest, WithoutOdometryItIsTakenToDoAsItIsTold) {
  VispRobot port(robot, {});
  port.command({0.4, 0.5}, 0);
  const RobotState state = port.read(0.5);
  const Pose2 arc = integrate({}, {0.4, 0.5}, 0.5);
  EXPECT_DOUBLE_EQ(state.odometry.x_m, arc.x_m);
  EXPECT_DOUBLE_EQ(state.odometry.y_m, arc.y_m);
  EXPECT_EQ(port.read(0.4).time_s, 0.5) << "time does not run backwards";
}

TEST_F(PioneerTest, KeepsTheLimitsWithoutViSPSayingSo) {
  UnicycleLimits limits;
  limits.v_max_mps = 0.6;
  VispRobot port(robot, limits);
  testing::internal::CaptureStdout();
  port.command({0.9, 0.3}, 0);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_NEAR(pose_of(robot).x_m, 0.6 * period_s, 1e-12);
  EXPECT_NEAR(pose_of(robot).yaw_rad, 0.2 * period_s, 1e-12) << "the path keeps its curvature";
}

/// Each picture in one colour, which says its number.
class CountingGrabber final : public vpFrameGrabber {
 public:
  void open(vpImage<unsigned char>&) override { FAIL() << "grey pictures"; }
  void open(vpImage<vpRGBa>& image) override {
    image.resize(4, 6);
    ++opened;
  }
  void acquire(vpImage<unsigned char>&) override { FAIL() << "grey pictures"; }
  void acquire(vpImage<vpRGBa>& image) override {
    if (acquired == 3) throw vpException(vpException::ioError, "unplugged");
    image = vpRGBa(10, 20, static_cast<unsigned char>(++acquired));
  }
  void close() override {}
  int opened = 0, acquired = 0;
};

TEST(VispCamera, GivesTheGrabbersPicturesInOursFormatWithTheTimeOfTheirExposure) {
  CountingGrabber grabber;
  VispCamera camera(grabber, {10, 0.03});
  EXPECT_EQ(grabber.opened, 1);
  SteppedClock clock;
  clock.sleep_until(0.001);
  for (int k = 0; k < 3; ++k) {
    const auto frame = camera.take(clock, 0.25);
    ASSERT_TRUE(frame) << k;
    EXPECT_EQ(frame->number, k);
    EXPECT_NEAR(frame->time_s, clock.now_s() - 0.03, 1e-12);
    EXPECT_NEAR(clock.now_s(), std::max(0.001, 0.1 * k), 1e-12);
    EXPECT_EQ(frame->bgr.size(), cv::Size(6, 4));
    EXPECT_EQ(frame->bgr.at<cv::Vec3b>(3, 5), cv::Vec3b(static_cast<unsigned char>(k + 1), 20, 10));
  }
  EXPECT_FALSE(camera.take(clock, 0.25)) << "the next is due later";
  EXPECT_THROW(camera.take(clock, 0.4), vpException);
}

TEST(VispCamera, AFrameKeepsItsPicture) {
  CountingGrabber grabber;
  VispCamera camera(grabber, {});
  SteppedClock clock;
  const auto first = camera.take(clock, 1), second = camera.take(clock, 1);
  EXPECT_EQ(first->bgr.at<cv::Vec3b>(0, 0)[0], 1);
  EXPECT_EQ(second->bgr.at<cv::Vec3b>(0, 0)[0], 2);
}

TEST(VispCamera, ReadsPicturesFromADisk) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "visp_camera_test";
  std::filesystem::create_directories(folder);
  for (int k = 1; k <= 2; ++k) {
    cv::imwrite((folder / ("image000" + std::to_string(k) + ".ppm")).string(),
                cv::Mat(8, 12, CV_8UC3, cv::Scalar(40 * k, 50, 60)));
  }
  vpDiskGrabber grabber((folder / "image%04d.ppm").string().c_str());
  grabber.setImageNumber(1);
  VispCamera camera(grabber, {});
  SteppedClock clock;
  const auto frame = camera.take(clock, 1);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->bgr.size(), cv::Size(12, 8));
  EXPECT_EQ(frame->bgr.at<cv::Vec3b>(0, 0)[1], 50);
  std::filesystem::remove_all(folder);
}

TEST(VispCamera, RefusesARateOrALatencyThatCannotBe) {
  CountingGrabber grabber;
  for (const VispCameraOptions& odd : {VispCameraOptions{0, 0}, VispCameraOptions{std::nan(""), 0},
                                       VispCameraOptions{30, -1}, VispCameraOptions{30, std::nan("")}}) {
    EXPECT_THROW(VispCamera(grabber, odd), InputError);
  }
}

}  // namespace
}  // namespace ballservo
