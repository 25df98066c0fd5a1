// The laws of one's own that servo/README.md shows: features of ViSP's in our task, and a class that answers
// with a twist.
#include <gtest/gtest.h>
#include <visp3/visual_features/vpFeaturePoint.h>

#include <array>
#include <cmath>
#include <new>
#include <vector>

#include "servo/features/builtin_laws.hpp"
#include "servo/features/visp_servo_law.hpp"
#include "tests/servo/random_scene.hpp"

namespace ballservo {
namespace {

// The image coordinates of the ball's centre, X/Z and Y/Z: bearing and range as a picture shows them, without
// the ball's radius; the range is known from the camera's height and pitch alone. (Chaumette and Hutchinson,
// "Visual servo control, part I", IEEE RAM 13(4), 2006, equation 11.)
class PointFeatures final : public BallFeatures {
 public:
  explicit PointFeatures(const ServoGoal& goal) { build(goal.desired_p_CB(), desired_); }
  void add_to(vpServo& task) override { task.addFeature(s_, desired_); }
  bool look_at(const Eigen::Vector3d& p_CB) override { return p_CB.z() > 1e-3 && build(p_CB, s_); }

 private:
  static bool build(const Eigen::Vector3d& p, vpFeaturePoint& s) {
    s.buildFrom(p.x() / p.z(), p.y() / p.z(), p.z());
    return true;
  }
  vpFeaturePoint s_, desired_;
};

// Turns towards the ball, and drives the more the better it is ahead.
class CarrotLaw final : public Law {
 public:
  CarrotLaw(const LawOptions& options, const ServoGoal& goal)
      : gain_per_s_(options.gain_per_s), goal_(goal) {}
  std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d&) override {
    const Eigen::Vector3d p_RB = goal_.mount.X_RC() * p_CB;
    const double range_error_m = p_RB.head<2>().norm() - goal_.distance_m;
    const double bearing_rad = std::atan2(p_RB.y(), p_RB.x());
    return LawOutput{{gain_per_s_ * range_error_m * std::cos(bearing_rad), gain_per_s_ * bearing_rad},
                     range_error_m,
                     bearing_rad};
  }

 private:
  double gain_per_s_;
  ServoGoal goal_;
};

LawCatalog laws() {
  LawCatalog laws = builtin_laws();
  laws.add("point", [](const LawOptions& options, const ServoGoal& goal) {
    return std::make_unique<VispServoLaw>(options.gain_per_s, goal.mount,
                                          std::make_unique<PointFeatures>(goal));
  });
  laws.add("carrot", [](const LawOptions& options, const ServoGoal& goal) {
    return std::make_unique<CarrotLaw>(options, goal);
  });
  return laws;
}

// vpServo(type) of ViSP 3.5 leaves the pseudo-inverse's threshold as the memory holds it.
TEST(VispServoLaw, AnswersAlikeWhateverItsMemoryHeld) {
  ServoGoal goal;
  goal.distance_m = 0.5;
  const Eigen::Vector3d p_CB(0.1, 0.2, 1.5);
  std::vector<Eigen::Vector2d> answers;
  alignas(VispServoLaw) std::array<unsigned char, sizeof(VispServoLaw)> memory{};
  for (const unsigned char held : {0x00, 0x41, 0xff}) {  // as a double: 0, 2.3e6, NaN
    memory.fill(held);
    auto* const law =
        new (memory.data()) VispServoLaw(0.8, goal.mount, std::make_unique<PointFeatures>(goal));
    const auto output = law->command(p_CB, {0, 0, 0});
    law->~VispServoLaw();
    ASSERT_TRUE(output);
    answers.emplace_back(output->twist.v_mps, output->twist.w_radps);
  }
  EXPECT_GT(answers[0].norm(), 0.1);
  EXPECT_EQ(answers[1], answers[0]);
  EXPECT_EQ(answers[2], answers[0]);
}

TEST(OwnLaw, ItsErrorsDecayAtTheGain) {
  RandomEngine engine = random_stream(1, "own law");
  int tried = 0;
  for (int i = 0; i < 300; ++i) {
    const ServoGoal goal = test::random_goal(engine);
    const double gain = uniform(engine, 0.3, 3.0), h = 1e-6;
    const auto law = laws().make({"point", gain}, goal);
    const Eigen::Vector3d p_WB = test::random_p_RB(engine, goal);
    const auto output = law->command(test::in_camera(goal, {}, p_WB), {0, 0, 0});
    if (!output || std::abs(goal.mount.up_m - goal.ball_height_m) < 0.05)
      continue;  // behind the camera, or level with it
    ++tried;
    const auto errors = [&](double t) {
      const auto at = law->command(test::in_camera(goal, integrate({}, output->twist, t), p_WB), {0, 0, 0});
      return Eigen::Vector2d(at->error_1, at->error_2);
    };
    const Eigen::Vector2d e(output->error_1, output->error_2);
    EXPECT_NEAR(((errors(h) - errors(-h)) / (2 * h) + gain * e).norm(), 0, 1e-4 * (1 + output->twist.v_mps))
        << i;
  }
  EXPECT_GT(tried, 200);
}

TEST(OwnLaw, DrivesTheRobotToTheGoal) {
  for (const char* name : {"point", "carrot"}) {
    const ServoGoal goal;
    const auto law = laws().make({name, 1.0}, goal);
    const Eigen::Vector3d p_WB(2.5, 0.5, goal.ball_height_m);
    Pose2 robot;
    for (double t = 0; t < 15; t += 0.02) {
      const auto output = law->command(test::in_camera(goal, robot, p_WB), {0, 0, 0});
      ASSERT_TRUE(output) << name << ' ' << t;
      robot = integrate(robot, output->twist, 0.02);
    }
    const Eigen::Vector2d p_RB = in_robot_frame(robot, p_WB.head<2>());
    EXPECT_NEAR(p_RB.x(), goal.distance_m, 1e-3) << name;
    EXPECT_NEAR(p_RB.y(), 0, 1e-3) << name;
  }
}

}  // namespace
}  // namespace ballservo
