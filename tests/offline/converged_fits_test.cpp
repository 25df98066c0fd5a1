#include "app/offline/converged_fits.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "calibration/camera/sphere_outline.hpp"
#include "calibration/files/random.hpp"

namespace ballservo {
namespace {

constexpr double pi = 3.14159265358979323846;

std::vector<RingPixel> ring_on(const UndistortedCircle& circle, double noise_px, RandomEngine& engine,
                               double arc_rad = 2 * pi) {
  std::vector<RingPixel> ring;
  for (int k = 0; k < 120; ++k) {
    const double angle = arc_rad * k / 120;
    const double radius = circle.radius_px + noise_px * standard_normal(engine);
    ring.push_back({circle.center_px + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
                    uniform(engine, 10, 2000), 0, 0});
  }
  return ring;
}

std::vector<EdgePoint> edges_on(const Eigen::Vector3d& p_C, double radius_m, double noise_px,
                                RandomEngine& engine) {
  std::vector<EdgePoint> edges;
  for (const Eigen::Vector3d& ray : outline_rays(p_C, radius_m, 40)) {
    EdgePoint edge;
    edge.px_per_rad = 800;
    const Eigen::Vector3d outward = (ray - ray.dot(p_C.normalized()) * p_C.normalized()).normalized();
    edge.ray = (ray + noise_px / edge.px_per_rad * standard_normal(engine) * outward).normalized();
    edge.sigma_px = uniform(engine, 0.05, 0.3);
    edge.weight = uniform(engine, 0.1, 1);
    edges.push_back(edge);
  }
  return edges;
}

UndistortedCircle shifted(const UndistortedCircle& circle, double dx, double dy, double dr) {
  return {circle.center_px + Eigen::Vector2d(dx, dy), circle.radius_px + dr};
}

TEST(ConvergeCircle, NoResidualAndNoSlopeAtTheTruth) {
  RandomEngine engine = random_stream(1, "test");
  const UndistortedCircle truth{{41.3, -17.9}, 30.2};
  const std::vector<RingPixel> ring = ring_on(truth, 0, engine);
  EXPECT_LT(circle_cost(truth, ring), 1e-18 * circle_cost(shifted(truth, 1, 0, 0), ring));
  for (const Eigen::Vector3d& way :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)}) {
    const double h = 1e-4;
    const Eigen::Vector3d d = h * way;
    const double ahead = circle_cost(shifted(truth, d.x(), d.y(), d.z()), ring);
    const double behind = circle_cost(shifted(truth, -d.x(), -d.y(), -d.z()), ring);
    EXPECT_LT(std::abs(ahead - behind), 1e-3 * ahead);  // symmetric about the minimum: no slope
  }
  const auto fit = converge_circle(shifted(truth, 3, -2, 1.5), ring);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->circle.center_px - truth.center_px).norm(), 1e-9);
  EXPECT_NEAR(fit->circle.radius_px, truth.radius_px, 1e-9);
  EXPECT_TRUE(fit->convergence.converged);
  EXPECT_LT(fit->convergence.residual_px, 1e-9);
}

TEST(ConvergeCircle, OneStepFromTheMinimumStaysThere) {
  RandomEngine engine = random_stream(2, "test");
  for (int round = 0; round < 20; ++round) {
    const UndistortedCircle truth{{uniform(engine, -200, 200), uniform(engine, -200, 200)},
                                  uniform(engine, 8, 90)};
    const std::vector<RingPixel> ring = ring_on(truth, 0.5, engine);
    const auto minimum = converge_circle(truth, ring);
    ASSERT_TRUE(minimum);
    const auto step = one_gauss_newton_step(minimum->circle, ring);
    ASSERT_TRUE(step);
    EXPECT_LT(step->step_px, 1e-6);
    EXPECT_NEAR(step->residual_px, minimum->convergence.residual_px, 1e-9);
  }
}

TEST(ConvergeCircle, NeverCostsMoreThanOneStep) {
  RandomEngine engine = random_stream(3, "test");
  for (int round = 0; round < 100; ++round) {
    const UndistortedCircle truth{{uniform(engine, -200, 200), uniform(engine, -200, 200)},
                                  uniform(engine, 8, 90)};
    const double arc = round % 2 == 0 ? 2 * pi : 0.6 * pi;
    const std::vector<RingPixel> ring = ring_on(truth, 0.7, engine, arc);
    const UndistortedCircle start =
        shifted(truth, uniform(engine, -2, 2), uniform(engine, -2, 2), uniform(engine, -2, 2));
    const auto step = one_gauss_newton_step(start, ring);
    const auto minimum = converge_circle(start, ring);
    ASSERT_TRUE(step && minimum);
    EXPECT_LE(minimum->convergence.cost, circle_cost(step->circle, ring) * (1 + 1e-9));
    EXPECT_LE(minimum->convergence.cost, minimum->convergence.start_cost);
    EXPECT_NEAR(minimum->convergence.cost, circle_cost(minimum->circle, ring),
                1e-9 * minimum->convergence.start_cost);
  }
}

TEST(ConvergeCircle, HasNoAnswerWithoutEnoughPixels) {
  RandomEngine engine = random_stream(4, "test");
  const UndistortedCircle truth{{0, 0}, 30};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<RingPixel> ring = ring_on(truth, 0, engine);
  EXPECT_FALSE(converge_circle({{nan, 0}, 30}, ring));
  EXPECT_FALSE(converge_circle(truth, {}));
  std::vector<RingPixel> two(ring.begin(), ring.begin() + 2);
  EXPECT_FALSE(converge_circle(truth, two));
  for (RingPixel& pixel : ring) pixel.weight = 0;
  EXPECT_FALSE(converge_circle(truth, ring));
  for (RingPixel& pixel : ring) pixel = {{nan, 0}, 1, 0, 0};
  EXPECT_FALSE(converge_circle(truth, ring));
}

TEST(ConvergeCone, FindsTheBallFromItsOwnRaysWhereverItStands) {
  RandomEngine engine = random_stream(5, "test");
  for (const double angle_deg : {0.0, 15.0, 28.0, 60.0}) {
    const double radius_m = 0.035;
    const Eigen::Vector3d p_C(std::tan(angle_deg * pi / 180), 0.02, 1.0);
    const std::vector<EdgePoint> edges = edges_on(p_C, radius_m, 0, engine);
    const TangentCone truth = *TangentCone::of_sphere(p_C, radius_m);
    EXPECT_LT(cone_cost(truth, edges), 1e-12);
    const TangentCone start = moved(truth, {0.003, -0.002, 0.002});
    const auto fit = converge_cone(start, edges);
    ASSERT_TRUE(fit);
    EXPECT_LT((fit->cone.center(radius_m) - p_C).norm(), 1e-8) << angle_deg;  // m
    EXPECT_LT(fit->convergence.residual_px, 1e-8);
  }
}

TEST(ConvergeCone, OneStepFromTheMinimumStaysThere) {
  RandomEngine engine = random_stream(6, "test");
  for (int round = 0; round < 20; ++round) {
    const Eigen::Vector3d p_C(uniform(engine, -0.5, 0.5), uniform(engine, -0.4, 0.4),
                              uniform(engine, 0.5, 3));
    const std::vector<EdgePoint> edges = edges_on(p_C, 0.035, 0.2, engine);
    const auto minimum = converge_cone(*TangentCone::of_sphere(p_C, 0.035), edges);
    ASSERT_TRUE(minimum);
    const auto step = one_gauss_newton_step(minimum->cone, edges);
    ASSERT_TRUE(step);
    EXPECT_LT(step->step_px, 1e-5);
    EXPECT_NEAR(step->residual_px, minimum->convergence.residual_px, 1e-8);
  }
}

TEST(ConvergeCone, NeverCostsMoreThanOneStep) {
  RandomEngine engine = random_stream(7, "test");
  for (int round = 0; round < 100; ++round) {
    const Eigen::Vector3d p_C(uniform(engine, -0.5, 0.5), uniform(engine, -0.4, 0.4),
                              uniform(engine, 0.5, 3));
    std::vector<EdgePoint> edges = edges_on(p_C, 0.035, 0.3, engine);
    if (round % 2 == 1) edges.resize(14);  // a short arc
    const TangentCone truth = *TangentCone::of_sphere(p_C, 0.035);
    const TangentCone start = moved(
        truth, 0.2 * truth.alpha_rad *
                   Eigen::Vector3d(uniform(engine, -1, 1), uniform(engine, -1, 1), uniform(engine, -1, 1)));
    const auto step = one_gauss_newton_step(start, edges);
    const auto minimum = converge_cone(start, edges);
    if (!step || !minimum) continue;
    EXPECT_LE(minimum->convergence.cost, cone_cost(step->cone, edges) * (1 + 1e-9));
    EXPECT_NEAR(minimum->convergence.start_cost, cone_cost(start, edges),
                1e-9 * minimum->convergence.start_cost);
  }
}

TEST(ConvergeCone, HasNoAnswerWithoutEnoughEdges) {
  RandomEngine engine = random_stream(8, "test");
  const TangentCone truth = *TangentCone::of_sphere({0, 0, 1}, 0.035);
  std::vector<EdgePoint> edges = edges_on({0, 0, 1}, 0.035, 0, engine);
  EXPECT_FALSE(converge_cone(truth, {}));
  std::vector<EdgePoint> two(edges.begin(), edges.begin() + 2);
  EXPECT_FALSE(converge_cone(truth, two));
  EXPECT_FALSE(converge_cone({{0, 0, 1}, std::numeric_limits<double>::quiet_NaN()}, edges));
  for (EdgePoint& edge : edges) edge.sigma_px = 0;
  EXPECT_FALSE(converge_cone(truth, edges));
}

}  // namespace
}  // namespace ballservo
