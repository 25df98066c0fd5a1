#include "servo/avoidance/steering.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

double cost_of(const BarrierProblem& problem, const Eigen::Vector2d& u) {
  const Eigen::Vector2d d = u - problem.wanted;
  double cost = d.dot(problem.weight.cwiseProduct(d));
  if (problem.soft) {
    const double over = std::max(0.0, problem.soft->a.dot(u) - problem.soft->b);
    cost += problem.slack_weight * over * over;
  }
  return cost;
}

bool keeps(const BarrierProblem& problem, const Eigen::Vector2d& u) {
  for (std::size_t k = 0; k < problem.count; ++k) {
    if (problem.bounds[k].a.dot(u) > problem.bounds[k].b + 1e-7) return false;
  }
  return true;
}

TEST(BarrierQp, NoPointOfAGridIsBetter) {
  rc::check("optimal", [](std::uint64_t seed) {
    RandomEngine engine = random_stream(seed, "qp");
    BarrierProblem problem;
    problem.wanted = {uniform(engine, -1, 1), uniform(engine, -1, 1)};
    problem.weight = {uniform(engine, 0.1, 2), uniform(engine, 0.1, 2)};
    const int count = static_cast<int>(uniform_index(engine, 10));
    for (int k = 0; k < count; ++k) {
      const double angle = uniform(engine, 0, 6.3);
      problem.add({{std::cos(angle), std::sin(angle)}, uniform(engine, -0.3, 1)});
    }
    if (seed % 2 == 0) {
      problem.soft =
          LinearBound{{uniform(engine, -1, 1), uniform(engine, -1, 1)}, uniform(engine, -0.5, 0.5)};
      problem.slack_weight = uniform(engine, 0.01, 5);
    }
    const auto u = solve(problem);
    double best = 1e9;
    for (double x = -2; x <= 2; x += 0.02) {
      for (double y = -2; y <= 2; y += 0.02) {
        if (keeps(problem, {x, y})) best = std::min(best, cost_of(problem, {x, y}));
      }
    }
    if (!u) {
      RC_ASSERT(best > 1e8);
      return;
    }
    RC_ASSERT(keeps(problem, *u));
    RC_ASSERT(cost_of(problem, *u) <= best + 1e-9);
  });
}

TEST(BarrierQp, RefusesWhatIsNotFinite) {
  BarrierProblem problem;
  problem.wanted = {std::numeric_limits<double>::quiet_NaN(), 0};
  EXPECT_FALSE(solve(problem));
  problem.wanted = {0, 0};
  problem.add({{1, std::numeric_limits<double>::infinity()}, 0});
  EXPECT_FALSE(solve(problem));
}

/// A grid with a wall of echoes across the way at x = 1.2, from y = -0.6 to 0.6.
OccupancyGrid grid_with_wall() {
  OccupancyGridOptions options;
  options.start_clear_m = 0.7;
  OccupancyGrid grid(options);
  grid.move(0, {});
  for (const std::size_t k : {2, 3, 4, 5}) {
    const SonarMount& mount = pioneer_3dx_sonars[k];
    const double range_m = (1.2 - mount.x_m) / std::cos(std::max(0.0, std::abs(mount.heading_rad) - 0.26));
    for (int i = 0; i < 2; ++i) grid.look({0, k, range_m, true}, {});
  }
  return grid;
}

TEST(NavigationFunction, GoesAroundWhatWasHeardAndStraightWhereNothingWas) {
  const OccupancyGrid wall = grid_with_wall();
  OccupancyGrid open(OccupancyGridOptions{});
  open.move(0, {});
  const Eigen::Vector2d ball(2.6, 0.0);
  NavigationFunction field;
  field.update(open, ball, 0.8, 0.25, 0);
  EXPECT_TRUE(field.straight({0, 0}, {1.8, 0}));
  EXPECT_NEAR(field.heading({}, 0, 0.5).value(), 0, 0.1);
  EXPECT_NEAR(field.cost_at({0, 0}), 1.8, 0.2);
  field.update(wall, ball, 0.8, 0.25, 0);
  EXPECT_FALSE(field.straight({0, 0}, {1.8, 0}));
  EXPECT_GT(std::abs(wrap_angle(field.heading({}, 0, 0.5).value())), 0.2);
  EXPECT_GT(field.cost_at({0, 0}), 2.0);
  EXPECT_LT(field.cost_at({0, 0}), 5.0);
}

TEST(NavigationFunction, WhatBlockedTheWayOnceIsAvoidedForAWhile) {
  OccupancyGrid open(OccupancyGridOptions{});
  open.move(0, {});
  NavigationFunction field;
  field.add_virtual(1.0, 0.0, 10.0);
  field.update(open, {2.6, 0.0}, 0.8, 0.25, 11.0);
  EXPECT_FALSE(field.straight({0, 0}, {1.8, 0}));
  field.update(open, {2.6, 0.0}, 0.8, 0.25, 30.0);
  EXPECT_TRUE(field.straight({0, 0}, {1.8, 0}));
}

TEST(Steering, NeverRunsTowardsWhatIsSuspectedFasterThanItCanBrake) {
  const OccupancyGrid wall = grid_with_wall();
  Steering steering(0.5, {}, pioneer_3dx_footprint);
  SteeringInput input;
  input.p_OB = {2.6, 0.0};
  input.law = Twist2{1.2, 0.0};
  const SteeringOutput output = steering.steer(input, wall, {});
  EXPECT_FALSE(output.by_law);
  const double gap_m = 1.2 - 0.21 - Steering::margin_m;
  EXPECT_LE(output.command.v_mps, std::sqrt(2 * 0.3 * gap_m));
  EXPECT_GT(std::abs(output.command.w_radps), 0.05);
}

/// One look around from the origin.
ViewedFloor look_around(const OccupancyGrid& grid) {
  ViewedFloor viewed;
  for (int k = 0; k < 16; ++k) viewed.look({0, 0, k * M_PI / 8}, 0.5, grid);
  return viewed;
}

TEST(ViewedFloor, WhatWasInThePictureIsNotNewAndWhatIsHiddenIs) {
  OccupancyGrid open(OccupancyGridOptions{});
  open.move(0, {});
  ViewedFloor none;
  none.look({}, 0.01, open);
  const ViewedFloor all = look_around(open), hidden = look_around(grid_with_wall());
  EXPECT_GT(none.new_from_m2({0, 0}, open), 10.0);
  EXPECT_LT(all.new_from_m2({0, 0}, open), 0.02 * none.new_from_m2({0, 0}, open));
  EXPECT_LT(hidden.new_from_m2({0, 0}, grid_with_wall()), 0.3) << "what is hidden stays so";
  EXPECT_GT(hidden.new_from_m2({1.2, 0.8}, grid_with_wall()), 2.0) << "and is seen from beside the wall";
  ViewedFloor ahead;
  ahead.look({}, 0.5, open);
  EXPECT_GT(ahead.new_from_m2({0, 0}, open), 3.0) << "only ahead was looked at";
}

TEST(ViewedFloor, FloorBehindTheFirstPoseCountsLess) {
  OccupancyGrid open(OccupancyGridOptions{});
  open.move(0, {});
  ViewedFloor viewed;
  viewed.look({}, 0.1, open);
  EXPECT_GT(viewed.new_from_m2({3, 0}, open), 2.0 * viewed.new_from_m2({-3, 0}, open));
}

TEST(ViewedFloor, ForgetsWhatTheWindowLeaves) {
  OccupancyGrid open(OccupancyGridOptions{});
  open.move(0, {});
  ViewedFloor viewed = look_around(open);
  viewed.look({20, 0, 0}, 0.1, open);
  viewed.look({0, 0, 0}, 0.1, open);
  EXPECT_GT(viewed.new_from_m2({0, 0}, open), 10.0);
  viewed = look_around(open);
  viewed.expect({0, 0});
  EXPECT_GT(viewed.new_from_m2({0, 0}, open), 2.0);
  EXPECT_GT(viewed.new_from_m2({1, 0}, open), viewed.new_from_m2({3, 0}, open)) << "rather near";
}

TEST(Steering, LooksForTheBallWhereTheWallHidesTheFloor) {
  const OccupancyGrid wall = grid_with_wall();
  const ViewedFloor viewed = look_around(wall);
  Steering steering(0.5, {}, pioneer_3dx_footprint);
  const Eigen::Vector2d p_O = steering.place_to_look_from(0, wall, viewed);
  EXPECT_GT(p_O.x(), 0.5) << p_O.transpose();
  EXPECT_GT(std::abs(p_O.y()), 0.5) << p_O.transpose();
  EXPECT_GT(viewed.new_from_m2(p_O, wall), 2.0);
}

}  // namespace
}  // namespace ballservo
