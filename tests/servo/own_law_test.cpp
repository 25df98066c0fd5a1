// The README's law of one's own: one class, the checks that every law must stand, and a drive under it.
#include <gtest/gtest.h>

#include <cmath>

#include "servo/features/feature_law.hpp"
#include "tests/servo/random_scene.hpp"

namespace ballservo {
namespace {

// The image coordinates of the ball's centre, X/Z and Y/Z: bearing and range as a picture shows them, without
// the ball's radius; the range is known from the camera's height and pitch alone. (Chaumette and Hutchinson,
// "Visual servo control, part I", IEEE RAM 13(4), 2006, equation 11, carried to the robot's two speeds.)
class PointLaw final : public FeatureLaw {
 public:
  PointLaw(const LawOptions& options, const ServoGoal& goal)
      : gain_per_s_(options.gain_per_s), X_RC_(goal.mount.X_RC()), desired_(features(goal.desired_p_CB())) {}

  std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) override {
    if (!((X_RC_ * p_CB).x() >= min_ahead_m)) return std::nullopt;
    return decaying(*this, gain_per_s_, p_CB, v_CB);
  }

  std::optional<Eigen::Vector2d> errors(const Eigen::Vector3d& p_CB) const override {
    if (!(p_CB.allFinite() && p_CB.z() > 1e-3)) return std::nullopt;
    return Eigen::Vector2d(features(p_CB) - desired_);
  }

  std::optional<Eigen::Matrix<double, 2, 3>> ball_jacobian(const Eigen::Vector3d& p_CB) const override {
    if (!errors(p_CB)) return std::nullopt;
    const double x = p_CB.x() / p_CB.z(), y = p_CB.y() / p_CB.z();
    Eigen::Matrix<double, 2, 3> L;
    L << 1, 0, -x,  //
        0, 1, -y;
    return Eigen::Matrix<double, 2, 3>(L / p_CB.z());
  }

  // A ball at rest moves by (-v + w y, -w x, 0) in the robot frame.
  std::optional<Eigen::Matrix2d> robot_jacobian(const Eigen::Vector3d& p_CB) const override {
    const auto L = ball_jacobian(p_CB);
    if (!L) return std::nullopt;
    const Eigen::Vector3d p_RB = X_RC_ * p_CB;
    Eigen::Matrix<double, 3, 2> motion_R;
    motion_R << -1, p_RB.y(),  //
        0, -p_RB.x(),          //
        0, 0;
    return Eigen::Matrix2d(*L * X_RC_.linear().transpose() * motion_R);
  }

 private:
  static Eigen::Vector2d features(const Eigen::Vector3d& p_CB) { return p_CB.head<2>() / p_CB.z(); }

  double gain_per_s_;
  Eigen::Isometry3d X_RC_;
  Eigen::Vector2d desired_;
};

TEST(OwnLaw, ItsRobotJacobianIsTheDerivativeOfItsErrors) {
  RandomEngine engine = random_stream(1, "own law");
  for (int i = 0; i < 300; ++i) {
    const ServoGoal goal = test::random_goal(engine);
    const PointLaw law({}, goal);
    const Eigen::Vector3d p_WB = test::random_p_RB(engine, goal);
    const auto J = law.robot_jacobian(test::in_camera(goal, {}, p_WB));
    if (!J) continue;  // behind the camera
    const double h = 1e-6;
    const Twist2 directions[2] = {{1, 0}, {0, 1}};
    for (int column = 0; column < 2; ++column) {
      const auto after = law.errors(test::in_camera(goal, integrate({}, directions[column], h), p_WB));
      const auto before = law.errors(test::in_camera(goal, integrate({}, directions[column], -h), p_WB));
      if (!after || !before) continue;
      EXPECT_NEAR((J->col(column) - (*after - *before) / (2 * h)).norm(), 0, 1e-5 * (1 + J->squaredNorm()));
    }
  }
}

TEST(OwnLaw, DrivesTheRobotToTheGoal) {
  const ServoGoal goal;
  LawOptions options;
  options.gain_per_s = 1.0;
  PointLaw law(options, goal);
  const Eigen::Vector3d p_WB(2.5, 0.5, goal.ball_height_m);
  Pose2 robot;
  for (double t = 0; t < 15; t += 0.02) {
    const auto output = law.command(test::in_camera(goal, robot, p_WB), {0, 0, 0});
    ASSERT_TRUE(output) << t;
    robot = integrate(robot, output->twist, 0.02);
  }
  const Eigen::Vector2d p_RB = in_robot_frame(robot, p_WB.head<2>());
  EXPECT_NEAR(p_RB.x(), goal.distance_m, 1e-3);
  EXPECT_NEAR(p_RB.y(), 0, 1e-3);
}

}  // namespace
}  // namespace ballservo
