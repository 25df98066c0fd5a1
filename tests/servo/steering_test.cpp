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

/// The shield lets it go nowhere for 7 s, because of something at (1, 0).
void be_stuck(Steering& steering, const OccupancyGrid& grid, const SteeringInput& input) {
  ShieldVerdict blocked;
  const FloorCell cell = OccupancyGrid::cell_at(1.0, 0.0);
  blocked.blocked = cell;
  SteeringInput now = input;
  for (int k = 0; k < 140; ++k) {
    now.time_s = 0.05 * k;
    steering.steer(now, grid, blocked);
  }
}

TEST(Steering, WhatBlockedTheWayLongAgoIsNotInTheWayOfALookElsewhere) {
  OccupancyGrid open(OccupancyGridOptions{});
  open.move(0, {});
  Steering steering(0.5, {}, pioneer_3dx_footprint);
  SteeringInput input;
  input.p_OB = {2.6, 0.0};
  be_stuck(steering, open, input);
  EXPECT_GT((steering.open_place(8, open, 0, 2) - Eigen::Vector2d(2, 0)).norm(), 0.3);
  EXPECT_LT((steering.open_place(100, open, 0, 2) - Eigen::Vector2d(2, 0)).norm(), 0.11);
}

}  // namespace
}  // namespace ballservo
