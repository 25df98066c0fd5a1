// The same feature on another robot: a six-axis arm (ViSP's model of a Viper 850) with the camera in its
// hand.
#include <gtest/gtest.h>
#include <visp3/robot/vpViper850.h>
#include <visp3/vs/vpServo.h>

#include "calibration/base/random.hpp"
#include "servo/features/ball_feature.hpp"

namespace ballservo {
namespace {

constexpr double desired_range_m = 0.4, period_s = 0.02;
constexpr int starts = 100, arm_steps = 600;

/// Joints within the middle of their ranges, with the wrist bent.
vpColVector random_joints_rad(RandomEngine& engine, const vpViper850& arm) {
  const vpColVector from = arm.getJointMin(), to = arm.getJointMax();
  vpColVector q(6);
  do {
    for (unsigned int i = 0; i < 6; ++i) q[i] = from[i] + (to[i] - from[i]) * uniform(engine, 0.25, 0.75);
  } while (std::abs(q[4]) < 0.3);
  return q;
}

Eigen::Vector3d in_camera(const vpViper850& arm, const vpColVector& q, const vpColVector& p_fB) {
  const vpColVector p = arm.get_fMc(q).inverse() * p_fB;
  return {p[0], p[1], p[2]};
}

struct Ending {
  double direction_rad = 0, range_m = 0, fastest_radps = 0;
  bool within_limits = true, in_view = true;
};

/// Drives the arm, from the joints q, until the ball at p_fB (homogeneous, in the arm's base) is ahead.
Ending drive(const vpViper850& arm, vpColVector q, const vpColVector& p_fB, BallFeature& seen,
             BallFeature& desired) {
  desired.buildFrom({0, 0, desired_range_m});
  vpServo task;  // not vpServo(type): ViSP 3.5 leaves the threshold of the pseudo-inverse uninitialised there
  task.setServo(vpServo::EYEINHAND_L_cVe_eJe);
  task.setInteractionMatrixType(vpServo::CURRENT);
  task.setLambda(1.0);
  vpVelocityTwistMatrix cVe;
  arm.get_cVe(cVe);
  task.set_cVe(cVe);
  task.addFeature(seen, desired);
  Ending ending;
  for (int step = 0; step < arm_steps; ++step) {
    vpMatrix eJe;
    arm.get_eJe(q, eJe);
    task.set_eJe(eJe);
    const Eigen::Vector3d p_CB = in_camera(arm, q, p_fB);
    ending.in_view = ending.in_view && p_CB.z() > 0.1;
    seen.buildFrom(p_CB);
    const vpColVector speeds = task.computeControlLaw();
    q += speeds * period_s;
    for (unsigned int i = 0; i < 6; ++i) {
      ending.fastest_radps = std::max(ending.fastest_radps, std::abs(speeds[i]));
      ending.within_limits =
          ending.within_limits && q[i] > arm.getJointMin()[i] && q[i] < arm.getJointMax()[i];
    }
  }
  task.kill();
  const Eigen::Vector3d p_CB = in_camera(arm, q, p_fB);
  ending.direction_rad = std::atan2(p_CB.head<2>().norm(), p_CB.z());
  ending.range_m = p_CB.norm() - desired_range_m;
  return ending;
}

TEST(Arm, CentresTheBallAndKeepsItsRangeFromEveryStart) {
  const vpViper850 arm;
  RandomEngine engine = random_stream(1, "arm");
  double worst_rad = 0, worst_m = 0;
  for (int i = 0; i < starts; ++i) {
    // A pose from which the ball is as desired, and a start from which it is seen, but not so.
    vpColVector p_fB, q, distances({0, 0, desired_range_m, 1});
    Eigen::Vector3d p_CB;
    do {
      const vpColVector q_goal = random_joints_rad(engine, arm);
      p_fB = arm.get_fMc(q_goal) * distances;
      q = q_goal;
      for (unsigned int joint = 0; joint < 6; ++joint) q[joint] += uniform(engine, -0.35, 0.35);
      p_CB = in_camera(arm, q, p_fB);
    } while (!(p_CB.z() > 0.2 && p_CB.head<2>().norm() < 0.7 * p_CB.z()));
    ConeFeature seen, desired;
    const Ending ending = drive(arm, q, p_fB, seen, desired);
    worst_rad = std::max(worst_rad, ending.direction_rad);
    worst_m = std::max(worst_m, std::abs(ending.range_m));
    EXPECT_LT(ending.direction_rad, 1e-4) << "start " << i;
    EXPECT_LT(std::abs(ending.range_m), 1e-4) << "start " << i;
    EXPECT_TRUE(ending.within_limits) << "start " << i;
    EXPECT_TRUE(ending.in_view) << "start " << i;
    EXPECT_LT(ending.fastest_radps, 5) << "start " << i;

    SphereFeature sphere(0.06), desired_sphere(0.06);
    const Ending by_sphere = drive(arm, q, p_fB, sphere, desired_sphere);
    EXPECT_LT(by_sphere.direction_rad, 1e-4) << "start " << i;
    EXPECT_LT(std::abs(by_sphere.range_m), 1e-4) << "start " << i;
  }
  RecordProperty("worst_direction_urad", static_cast<int>(1e6 * worst_rad));
  RecordProperty("worst_range_um", static_cast<int>(1e6 * worst_m));
}

}  // namespace
}  // namespace ballservo
