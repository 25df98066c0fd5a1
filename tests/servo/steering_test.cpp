#include "servo/avoidance/steering.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
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

/// Both maps of a robot that has stood at the origin for a while and fired all its sonars, and looked at a
/// floor on which walls stand.
struct Place {
  OccupancyGrid grid;
  ObstacleMap map;

  explicit Place(bool wall) : grid(options()), map(options()) {
    grid.move(0, {});
    map.move({});
    for (int round = 0; round < 4; ++round) {
      for (std::size_t k = 0; k < sonar_count; ++k) {
        const SonarMount& mount = pioneer_3dx_sonars[k];
        const bool ahead = k >= 2 && k <= 5;
        const double to_wall_m =
            (wall_x_m - mount.x_m) / std::cos(std::max(0.0, std::abs(mount.heading_rad) - 0.26));
        const SonarReading reading{0, k, wall && ahead ? to_wall_m : 3.0, wall && ahead};
        grid.look(reading, {});
        map.look(reading, {});
      }
      FloorScan scan;
      scan.time_s = 0;
      scan.count = FloorScan::max_rays;
      for (std::size_t k = 0; k < scan.count; ++k) {
        const double bearing = 0.6 * (2.0 * static_cast<double>(k) / (FloorScan::max_rays - 1) - 1.0);
        const double to_wall_m = wall_x_m / std::cos(bearing);
        const bool hit = wall && std::abs(to_wall_m * std::sin(bearing)) < wall_half_m;
        scan.rays[k] = {bearing, 0.3, hit ? to_wall_m : 2.5, hit ? to_wall_m + 1.0 : 2.5};
      }
      map.look_at_floor(scan, {});
    }
  }
  static OccupancyGridOptions options() {
    OccupancyGridOptions options;
    options.start_clear_m = 1.0;
    return options;
  }
  static constexpr double wall_x_m = 1.2, wall_half_m = 0.6;
};

TEST(ObstacleMap, ShrinksAnArcToWhatOtherFiringsDoNotSeeThrough) {
  ObstacleMap map(Place::options());
  map.move({});
  const auto chance = [&map](double x_m, double y_m) {
    return map.probability(ObstacleMap::cell_at(x_m, y_m));
  };
  // A pole straight ahead of transducer 3, at 1.5 m.
  const SonarMount& mount = pioneer_3dx_sonars[3];
  const Eigen::Vector2d pole = in_world_frame({mount.x_m, mount.y_m, mount.heading_rad}, {1.5, 0});
  const Eigen::Vector2d aside = in_world_frame({mount.x_m, mount.y_m, mount.heading_rad - 0.2}, {1.5, 0});
  map.look({0, 3, 1.5, true}, {});
  map.look({0, 3, 1.5, true}, {});
  EXPECT_LT(chance(pole.x(), pole.y()), 0.6) << "it may stand anywhere on the arc";
  for (int k = 0; k < 6; ++k) {
    map.look({0, 3, 3.0, false}, {0, 0, -0.4});  // past the pole, through the other half of the arc
    map.look({0, 3, 1.5, true}, {});
  }
  EXPECT_LT(chance(aside.x(), aside.y()), 0.05);
  double most = 0;
  for (double angle = 0.0; angle < 0.26; angle += 0.02) {
    const Eigen::Vector2d p = in_world_frame({mount.x_m, mount.y_m, mount.heading_rad + angle}, {1.5, 0});
    most = std::max(most, static_cast<double>(chance(p.x(), p.y())));
  }
  EXPECT_GT(most, 0.15) << "the rest of the arc bears what was heard";
  EXPECT_LT(chance(0.8, 0.0), 0.01) << "short of the echo";
}

TEST(ObstacleMap, NeverAnswersForWhatLeftItsWindow) {
  Place place(true);
  const FloorCell wall = ObstacleMap::cell_at(Place::wall_x_m + 0.03, 0);
  ASSERT_GE(place.map.probability(wall), ObstacleMap::occupied);
  place.map.move({20, 0, 0});
  EXPECT_EQ(place.map.probability(wall), ObstacleMap::prior);
  place.map.move({});
  EXPECT_EQ(place.map.probability(wall), ObstacleMap::prior) << "a ring must not remember another round";
}

TEST(ObstacleMap, NothingStandsWhereTheBodyIs) {
  ObstacleMap map(Place::options());
  map.move({});
  map.move({2.5, 0, 0.3});
  EXPECT_LT(map.probability(ObstacleMap::cell_at(2.6, 0.0)), 0.01);
  EXPECT_EQ(map.probability(ObstacleMap::cell_at(2.5, 0.4)), ObstacleMap::prior);
}

TEST(NavigationFunction, ClearanceIsTheDistanceToWhatStands) {
  for (const double moved_m : {0.0, 0.06, 0.12}) {  // blocks and windows meet in either way
    Place place(true);
    place.map.move({moved_m, moved_m, 0});
    std::vector<Eigen::Vector2d> standing;
    place.map.visit_occupied([&](const FloorCell& cell) {
      EXPECT_GE(place.map.probability(cell), ObstacleMap::occupied);
      standing.push_back(ObstacleMap::center_m(cell));
    });
    ASSERT_GT(standing.size(), 10U);
    NavigationFunction field(pioneer_3dx_footprint);
    field.update(place.map, place.grid, {0, 0}, {-3, 0}, 0.8, 0.25);
    for (double x_m = 0.1; x_m < 2.6; x_m += 0.13) {
      for (double y_m = -1.8; y_m < 1.8; y_m += 0.13) {
        double nearest_m = 1e9;
        for (const Eigen::Vector2d& p : standing)
          nearest_m = std::min(nearest_m, (p - Eigen::Vector2d(x_m, y_m)).norm());
        if (nearest_m > 1.0) continue;  // a chamfer's distance is up to 8 % long
        EXPECT_NEAR(field.clearance_m({x_m, y_m}), 1.04 * nearest_m, 0.05 + 0.05 * nearest_m)
            << x_m << ", " << y_m;
      }
    }
  }
}

TEST(NavigationFunction, CostsMoreWhereSomethingStandsInTheWay) {
  const Place wall(true), open(false);
  const Eigen::Vector2d ball(2.6, 0.0);
  NavigationFunction field(pioneer_3dx_footprint);
  field.update(open.map, open.grid, {0, 0}, ball, 0.8, 0.25);
  EXPECT_TRUE(field.straight({0, 0}, {1.1, 0}, 0.1));
  EXPECT_NEAR(field.cost_m(field.block_at({0, 0})), 1.8, 0.4);
  field.update(wall.map, wall.grid, {0, 0}, ball, 0.8, 0.25);
  EXPECT_FALSE(field.straight({0, 0}, {1.1, 0}, 0.1));
  EXPECT_GT(field.cost_m(field.block_at({0, 0})), 2.4);
  EXPECT_LT(field.cost_m(field.block_at({0, 0})), 8.0);
  EXPECT_FALSE(field.sees_ball(field.block_at({0.0, 0.0})));
  EXPECT_TRUE(field.sees_ball(field.block_at({2.6, 1.5})));
}

TEST(NavigationFunction, WhatTheShieldDoesNotKnowToBeFreeCostsMoreNearTheRobot) {
  Place open(false);
  const Pose2 ahead{0.45, 0, 0};
  NavigationFunction field(pioneer_3dx_footprint);
  const auto price = [&] {
    field.update(open.map, open.grid, {0, 0}, {3, 0}, 0.8, 0.25);
    return field.price(ahead);
  };
  EXPECT_LT(price(), 1.5);
  FloorScan scan;  // something flat, below the beams
  scan.time_s = 0;
  scan.count = 5;
  for (std::size_t k = 0; k < 5; ++k) scan.rays[k] = {0.02 * static_cast<double>(k) - 0.04, 0.3, 0.75, 0.85};
  for (int k = 0; k < 2; ++k) open.grid.look_at_floor(scan, {});
  EXPECT_GT(price(), 3.0) << "the shield's map alone knows of it";
}

TEST(NavigationFunction, AWayIsStraightUnlessItLeadsIntoFloorLessSureThanTheRobots) {
  Place open(false);
  NavigationFunction field(pioneer_3dx_footprint);
  const auto straight = [&] {
    field.update(open.map, open.grid, {0, 0}, {3, 0}, 0.8, 0.25);
    return field.straight({0, 0}, {1.1, 0}, 0.1);
  };
  const auto forget = [&open](const Pose2& from, double from_m, double until_m) {
    FloorScan scan;  // something flat, below the beams
    scan.time_s = 0;
    scan.count = 5;
    for (std::size_t k = 0; k < 5; ++k)
      scan.rays[k] = {0.02 * static_cast<double>(k) - 0.04, 0.1, from_m, until_m};
    for (int k = 0; k < 2; ++k) open.grid.look_at_floor(scan, from);
  };
  ASSERT_TRUE(straight());
  for (double x_m = -0.6; x_m < 0.3; x_m += 0.01) forget({x_m, 0, M_PI / 2}, 0.28, 0.36);
  EXPECT_TRUE(straight()) << "what lies beside the robot lies in no way";
  EXPECT_GT(field.price({0, 0, 0}), 1.0);
  forget({}, 0.75, 0.85);
  EXPECT_FALSE(straight());
}

/// The way from the origin to a ball.
Way way_to(const Place& place, const Eigen::Vector2d& p_OB, double half_view_rad) {
  NavigationFunction field(pioneer_3dx_footprint);
  field.update(place.map, place.grid, {0, 0}, p_OB, 0.8, 0.25);
  WayPlanner planner;
  Way way;
  EXPECT_TRUE(planner.plan(field, {0, {}, p_OB, half_view_rad}, way));
  EXPECT_NEAR(planner.cost_m(field, {0, {}, p_OB, half_view_rad}, way), way.cost_m, 0.2);
  return way;
}

TEST(WayPlanner, LeadsAroundTheWallAndLooksAtTheBallAtItsEnd) {
  const Place wall(true);
  const Eigen::Vector2d ball(2.6, 0.0);
  const Way way = way_to(wall, ball, 0.5);
  double aside_m = 0;
  for (std::size_t k = 0; k < way.count; ++k) {
    const Pose2& pose = way.poses[k];
    if (std::abs(pose.x_m - Place::wall_x_m) < 0.15) aside_m = std::max(aside_m, std::abs(pose.y_m));
    if (k == 0) continue;
    const Eigen::Vector2d step(pose.x_m - way.poses[k - 1].x_m, pose.y_m - way.poses[k - 1].y_m);
    ASSERT_LT(step.norm(), 0.28);
    ASSERT_LT(std::abs(wrap_angle(pose.yaw_rad - way.poses[k - 1].yaw_rad)), 0.5);
  }
  EXPECT_GT(aside_m, Place::wall_half_m + pioneer_3dx_footprint.half_width_m);
  const Pose2& end = way.poses[way.count - 1];
  EXPECT_NEAR(std::hypot(ball.x() - end.x_m, ball.y() - end.y_m), 0.8, 0.12);
  EXPECT_LT(std::abs(wrap_angle(std::atan2(ball.y() - end.y_m, ball.x() - end.x_m) - end.yaw_rad)), 0.5);
}

TEST(WayPlanner, KeepsTheBallInViewWhereThatCostsLittle) {
  // Beside the wall stands a ball: it is turned to, then driven to, where the shortest way looks past it.
  const Place wall(true);
  const Eigen::Vector2d ball(1.5, 1.5);
  const auto unseen_m = [&](const Way& way) {
    double sum_m = 0;
    for (std::size_t k = 1; k < way.count; ++k) {
      const Pose2 &pose = way.poses[k], &before = way.poses[k - 1];
      const double aside = std::atan2(ball.y() - pose.y_m, ball.x() - pose.x_m) - pose.yaw_rad;
      if (std::abs(wrap_angle(aside)) > 0.3)
        sum_m += std::hypot(pose.x_m - before.x_m, pose.y_m - before.y_m);
    }
    return sum_m;
  };
  EXPECT_LT(unseen_m(way_to(wall, ball, 0.3)), 0.3);
  EXPECT_GT(unseen_m(way_to(wall, ball, 0.0)), 1.0) << "without a price on views";
}

TEST(WayPlanner, AWayThatNoLongerFacesTheBallAtItsEndIsWorthNothing) {
  const Place open(false);
  const Eigen::Vector2d ball(2.6, 0.0);
  const Way way = way_to(open, ball, 0.5);
  const Pose2 end = way.poses[way.count - 1];
  NavigationFunction field(pioneer_3dx_footprint);
  WayPlanner planner;
  const auto left_m = [&](const Pose2& from, const Eigen::Vector2d& p_OB) {
    field.update(open.map, open.grid, {from.x_m, from.y_m}, p_OB, 0.8, 0.25);
    Way other;
    EXPECT_TRUE(planner.plan(field, {0, from, p_OB, 0.5}, other));
    return planner.cost_m(field, {0, from, p_OB, 0.5}, way);
  };
  EXPECT_LT(left_m(end, ball), 0.1) << "it is there";
  EXPECT_GT(left_m({end.x_m, end.y_m, end.yaw_rad + 1.0}, ball), 0.3) << "the turn is left";
  EXPECT_TRUE(std::isinf(left_m(end, {2.6, 0.5}))) << "the ball has gone elsewhere";
}

TEST(WayPlanner, AvoidsWhatTheShieldRefusedForAWhile) {
  const Place open(false);
  const Eigen::Vector2d ball(2.6, 0.0);
  NavigationFunction field(pioneer_3dx_footprint);
  field.update(open.map, open.grid, {0, 0}, ball, 0.8, 0.25);
  WayPlanner planner;
  WayRequest request{10, {}, ball, 0.5};
  request.refused[0] = {{0.9, 0, 0}, 20};
  const auto passes = [&] {
    Way way;
    EXPECT_TRUE(planner.plan(field, request, way));
    return std::any_of(way.poses.begin(), way.poses.begin() + way.count, [](const Pose2& pose) {
      return std::hypot(pose.x_m - 0.9, pose.y_m) < 0.15 && std::abs(wrap_angle(pose.yaw_rad)) < 0.4;
    });
  };
  EXPECT_FALSE(passes());
  request.time_s = 20.1;
  EXPECT_TRUE(passes()) << "it is forgotten";
}

TEST(WayPlanner, FindsNoWayOutOfAClosedRoomAndSteeringSaysSo) {
  Place place(false);
  NavigationFunction field(pioneer_3dx_footprint);
  for (int round = 0; round < 6; ++round) {
    FloorScan scan;
    scan.time_s = 0;
    scan.count = FloorScan::max_rays;
    for (std::size_t k = 0; k < scan.count; ++k) {
      const double bearing = 0.1 * (static_cast<double>(k) - 31.5);
      scan.rays[k] = {bearing, 0.3, 1.0, 1.6};
    }
    place.map.look_at_floor(scan, {});
  }
  field.update(place.map, place.grid, {0, 0}, {2.5, 0}, 0.8, 0.25);
  WayPlanner planner;
  Way way;
  EXPECT_FALSE(planner.plan(field, {0, {}, {2.5, 0}, 0.5}, way));
  Steering steering(0.5, {}, pioneer_3dx_footprint);
  SteeringInput input;
  input.p_OB = {2.5, 0};
  const SteeringOutput output = steering.steer(input, place.map, place.grid, {});
  EXPECT_TRUE(output.no_way);
  EXPECT_EQ(output.command.v_mps, 0.0);
}

TEST(Steering, NeverRunsTowardsWhatStandsFasterThanItCanBrake) {
  const Place wall(true);
  Steering steering(0.5, {}, pioneer_3dx_footprint);
  SteeringInput input;
  input.p_OB = {2.6, 0.0};
  input.law = Twist2{1.2, 0.0};
  const SteeringOutput output = steering.steer(input, wall.map, wall.grid, {});
  EXPECT_NE(output.reason, "the way is clear: driving by the law");
  const double gap_m = Place::wall_x_m - 0.21 - Steering::margin_m;
  EXPECT_LE(output.command.v_mps, std::sqrt(2 * 0.3 * gap_m));
  EXPECT_GT(std::abs(output.command.w_radps), 0.05);
}

/// One look around from the origin.
ViewedFloor look_around(const ObstacleMap& map) {
  ViewedFloor viewed;
  for (int k = 0; k < 16; ++k) viewed.look({0, 0, k * M_PI / 8}, 0.5, map);
  return viewed;
}

TEST(ViewedFloor, WhatWasInThePictureIsNotNewAndWhatIsHiddenIs) {
  const Place open(false), wall(true);
  ViewedFloor none;
  none.look({}, 0.01, open.map);
  const ViewedFloor all = look_around(open.map), hidden = look_around(wall.map);
  EXPECT_GT(none.unseen_from({0, 0}, open.map).area_m2, 10.0);
  EXPECT_LT(all.unseen_from({0, 0}, open.map).area_m2, 0.02 * none.unseen_from({0, 0}, open.map).area_m2);
  EXPECT_LT(hidden.unseen_from({0, 0}, wall.map).area_m2, 0.3) << "what is hidden stays so";
  EXPECT_GT(hidden.unseen_from({1.2, 1.2}, wall.map).area_m2, 2.0) << "and is seen from beside the wall";
  ViewedFloor ahead;
  ahead.look({}, 0.5, open.map);
  EXPECT_GT(ahead.unseen_from({0, 0}, open.map).area_m2, 3.0) << "only ahead was looked at";
}

TEST(ViewedFloor, FloorBehindTheFirstPoseCountsLess) {
  const Place open(false);
  ViewedFloor viewed;
  viewed.look({}, 0.1, open.map);
  EXPECT_GT(viewed.unseen_from({3, 0}, open.map).area_m2,
            2.0 * viewed.unseen_from({-3, 0}, open.map).area_m2);
}

TEST(ViewedFloor, KnowsWhichWayRoundATurnShowsTheRestSooner) {
  const Place open(false);
  const ObstacleMap& map = open.map;
  ViewedFloor viewed;
  viewed.look({0, 0, 0.9}, 0.01, map);
  EXPECT_NEAR(viewed.unseen_from({0, 0, 0.9}, map).sooner_left, 1.0, 0.1) << "both ways as soon";
  for (const double yaw_rad : {0.6, 1.2}) viewed.look({0, 0, yaw_rad}, 0.6, map);
  EXPECT_LT(viewed.unseen_from({}, map).sooner_left, 0.7) << "to the left all was seen";
  EXPECT_GT(viewed.unseen_from({0, 0, 1.8}, map).sooner_left, 1.5);
  EXPECT_GT(viewed.unseen_from({0, 0, 1.8 + 2 * M_PI}, map).sooner_left, 1.5);
  for (int k = 0; k < 200; ++k) viewed.look({0, 0, k * 0.05}, 0.6, map);
  EXPECT_GT(viewed.unseen_from({}, map).sooner_left, 0.0) << "defined where all was seen";
}

TEST(ViewedFloor, ForgetsWhatTheWindowLeaves) {
  const ObstacleMap open = Place(false).map;
  ViewedFloor viewed = look_around(open);
  viewed.look({20, 0, 0}, 0.1, open);
  viewed.look({0, 0, 0}, 0.1, open);
  EXPECT_GT(viewed.unseen_from({0, 0}, open).area_m2, 10.0);
  viewed = look_around(open);
  viewed.expect({0, 0});
  EXPECT_GT(viewed.unseen_from({0, 0}, open).area_m2, 2.0);
  EXPECT_GT(viewed.unseen_from({1, 0}, open).area_m2, viewed.unseen_from({3, 0}, open).area_m2)
      << "rather near";
}

TEST(Steering, LooksForTheBallWhereTheWallHidesTheFloor) {
  const Place wall(true);
  const ViewedFloor viewed = look_around(wall.map);
  Steering steering(0.5, {}, pioneer_3dx_footprint);
  const Eigen::Vector2d p_O = steering.place_to_look_from(wall.map, wall.grid, viewed);
  EXPECT_GT(p_O.x(), 0.5) << p_O.transpose();
  EXPECT_GT(std::abs(p_O.y()), 0.5) << p_O.transpose();
  EXPECT_GT(viewed.unseen_from({p_O.x(), p_O.y()}, wall.map).area_m2, 2.0);
}

}  // namespace
}  // namespace ballservo
