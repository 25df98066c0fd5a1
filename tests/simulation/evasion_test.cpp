#include "servo/avoidance/evasion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace ballservo {
namespace {

constexpr MovingThingOptions passers{0.3, 0.2};

/// A thing of which all is known.
Mover surely(const Eigen::Vector2d& p_O, const Eigen::Vector2d& v_O) {
  Mover mover;
  mover.discs.fill({p_O, v_O});
  return mover;
}

/// A robot in the open, where nothing but the movers is near.
struct Open {
  ShieldOptions shield;
  OccupancyGrid grid{grid_options()};
  MovingThings things{passers, grid_options()};
  Evasion evasion{passers, shield};

  Open() {
    grid.move(0, {});
    things.move(0, {});
  }
  static OccupancyGridOptions grid_options() {
    OccupancyGridOptions options;
    options.start_clear_m = 3;
    return options;
  }
  std::optional<Twist2> ask(const Twist2& wanted, const std::vector<Mover>& known, double v_mps = 0) const {
    MoverTracker::Movers movers;
    for (const Mover& mover : known) movers.movers[movers.count++] = mover;
    return evasion.command(wanted, {{}, {v_mps, 0}}, movers, grid, things);
  }
};

TEST(Evasion, DrivesOnWhereNothingComesNear) {
  const Open open;
  EXPECT_FALSE(open.ask({0.3, 0}, {}));
  EXPECT_FALSE(open.ask({0.3, 0}, {surely({3, 2}, {0, 0.3})})) << "it goes away";
  EXPECT_FALSE(open.ask({0.3, 0}, {surely({-2, -1.5}, {0.3, 0})})) << "it passes behind, far off";
}

TEST(Evasion, LeavesThePathOfWhatComes) {
  const Open open;
  const auto back = open.ask({0, 0}, {surely({0.05, -2}, {0, 0.3})});
  ASSERT_TRUE(back);
  EXPECT_NE(back->v_mps, 0) << "on its path, it does not stay";
  const auto ahead = open.ask({0, 0}, {surely({-0.3, -2}, {0, 0.3})});
  ASSERT_TRUE(ahead);
  EXPECT_GT(ahead->v_mps, 0) << "forward is the shorter way out";
  const auto behind = open.ask({0, 0}, {surely({0.4, -2}, {0, 0.3})});
  ASSERT_TRUE(behind);
  EXPECT_LT(behind->v_mps, 0);
}

TEST(Evasion, CrossesAPathOnlyWhereThereIsTime) {
  const Open open;
  constexpr double fast_mps = 0.6;
  EXPECT_FALSE(open.ask({fast_mps, 0}, {surely({1.2, -3}, {0, 0.25})}, fast_mps));
  const std::vector<Mover> soon{surely({1.2, -1.5}, {0, 0.25})};
  const auto command = open.ask({fast_mps, 0}, soon, fast_mps);
  ASSERT_TRUE(command);
  EXPECT_LT(command->v_mps, 0.0) << "to rest would be too late";
  EXPECT_FALSE(open.ask({fast_mps, 0}, soon, 0.3)) << "it can wait until later";
}

TEST(Evasion, TheDoubtOfAVelocityMattersOnlySoon) {
  const Open open;
  Mover far = surely({0.05, -2.2}, {0, 0.2});
  ASSERT_TRUE(open.ask({0, 0}, {far}));
  far.speed_sigma_mps = 0.1;  // within 4 s it does not come
  EXPECT_FALSE(open.ask({0, 0}, {far}));
}

TEST(Evasion, AnswersFinitelyWhateverItIsTold) {
  const Open open;
  for (const double odd : std::vector<double>{NAN, INFINITY, 1e308, -1e308}) {
    for (const Mover& mover : std::vector<Mover>{surely({odd, 0}, {0, 0.3}), surely({1, 0}, {odd, 0})}) {
      const auto command = open.ask({odd, 0}, {mover});
      EXPECT_TRUE(!command || command->is_finite());
    }
  }
}

}  // namespace
}  // namespace ballservo
