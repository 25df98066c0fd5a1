#include "app/comparison/estimators/converged_fits.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "calibration/base/random.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "tests/comparison/fit_costs.hpp"

namespace ballservo {
namespace {

std::vector<RingPixel> ring_on(const UndistortedCircle& circle, double noise_px, RandomEngine& engine,
                               double arc_rad = 2 * M_PI) {
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
  const auto fit = converge(shifted(truth, 3, -2, 1.5), ring);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->shape.center_px - truth.center_px).norm(), 1e-9);
  EXPECT_NEAR(fit->shape.radius_px, truth.radius_px, 1e-9);
  EXPECT_TRUE(fit->convergence.converged);
  EXPECT_LT(fit->convergence.residual_px, 1e-9);
}

TEST(ConvergeCircle, OneStepFromTheMinimumStaysThere) {
  RandomEngine engine = random_stream(2, "test");
  for (int round = 0; round < 20; ++round) {
    const UndistortedCircle truth{{uniform(engine, -200, 200), uniform(engine, -200, 200)},
                                  uniform(engine, 8, 90)};
    const std::vector<RingPixel> ring = ring_on(truth, 0.5, engine);
    const auto minimum = converge(truth, ring);
    ASSERT_TRUE(minimum);
    const auto step = one_gauss_newton_step(minimum->shape, ring);
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
    const double arc = round % 2 == 0 ? 2 * M_PI : 0.6 * M_PI;
    const std::vector<RingPixel> ring = ring_on(truth, 0.7, engine, arc);
    const UndistortedCircle start =
        shifted(truth, uniform(engine, -2, 2), uniform(engine, -2, 2), uniform(engine, -2, 2));
    const auto step = one_gauss_newton_step(start, ring);
    const auto minimum = converge(start, ring);
    ASSERT_TRUE(step && minimum);
    EXPECT_LE(minimum->convergence.cost, circle_cost(step->circle, ring) * (1 + 1e-9));
    const double start_cost = circle_cost(start, ring);
    EXPECT_LE(minimum->convergence.cost, start_cost);
    EXPECT_NEAR(minimum->convergence.cost, circle_cost(minimum->shape, ring), 1e-9 * start_cost);
    EXPECT_NEAR(linearise(start, ring).residuals.squaredNorm(), start_cost, 1e-9 * start_cost);
  }
}

TEST(ConvergeCircle, HasNoAnswerWithoutEnoughPixels) {
  RandomEngine engine = random_stream(4, "test");
  const UndistortedCircle truth{{0, 0}, 30};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<RingPixel> ring = ring_on(truth, 0, engine);
  EXPECT_FALSE(converge(UndistortedCircle{{nan, 0}, 30}, ring));
  EXPECT_FALSE(converge(truth, std::vector<RingPixel>{}));
  std::vector<RingPixel> two(ring.begin(), ring.begin() + 2);
  EXPECT_FALSE(converge(truth, two));
  for (RingPixel& pixel : ring) pixel.weight = 0;
  EXPECT_FALSE(converge(truth, ring));
  for (RingPixel& pixel : ring) pixel = {{nan, 0}, 1, 0, 0};
  EXPECT_FALSE(converge(truth, ring));
}

TEST(ConvergeCone, FindsTheBallFromItsOwnRaysWhereverItStands) {
  RandomEngine engine = random_stream(5, "test");
  for (const double angle_deg : {0.0, 15.0, 28.0, 60.0}) {
    const double radius_m = 0.035;
    const Eigen::Vector3d p_C(std::tan(angle_deg * M_PI / 180), 0.02, 1.0);
    const std::vector<EdgePoint> edges = edges_on(p_C, radius_m, 0, engine);
    const TangentCone truth = *TangentCone::of_sphere(p_C, radius_m);
    EXPECT_LT(cone_cost(truth, edges), 1e-12);
    const TangentCone start = moved(truth, {0.003, -0.002, 0.002});
    const auto fit = converge(start, edges);
    ASSERT_TRUE(fit);
    EXPECT_LT((fit->shape.center(radius_m) - p_C).norm(), 1e-8) << angle_deg;  // m
    EXPECT_LT(fit->convergence.residual_px, 1e-8);
  }
}

TEST(ConvergeCone, OneStepFromTheMinimumStaysThere) {
  RandomEngine engine = random_stream(6, "test");
  for (int round = 0; round < 20; ++round) {
    const Eigen::Vector3d p_C(uniform(engine, -0.5, 0.5), uniform(engine, -0.4, 0.4),
                              uniform(engine, 0.5, 3));
    const std::vector<EdgePoint> edges = edges_on(p_C, 0.035, 0.2, engine);
    const auto minimum = converge(*TangentCone::of_sphere(p_C, 0.035), edges);
    ASSERT_TRUE(minimum);
    const auto step = one_gauss_newton_step(minimum->shape, edges);
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
    const auto minimum = converge(start, edges);
    if (!step || !minimum) continue;
    EXPECT_LE(minimum->convergence.cost, cone_cost(step->cone, edges) * (1 + 1e-9));
    const double start_cost = cone_cost(start, edges);
    EXPECT_NEAR(linearise(start, edges).residuals.squaredNorm(), start_cost, 1e-9 * start_cost);
  }
}

TEST(ConvergeCone, HasNoAnswerWithoutEnoughEdges) {
  RandomEngine engine = random_stream(8, "test");
  const TangentCone truth = *TangentCone::of_sphere({0, 0, 1}, 0.035);
  std::vector<EdgePoint> edges = edges_on({0, 0, 1}, 0.035, 0, engine);
  EXPECT_FALSE(converge(truth, std::vector<EdgePoint>{}));
  std::vector<EdgePoint> two(edges.begin(), edges.begin() + 2);
  EXPECT_FALSE(converge(truth, two));
  EXPECT_FALSE(converge(TangentCone{{0, 0, 1}, std::numeric_limits<double>::quiet_NaN()}, edges));
  for (EdgePoint& edge : edges) edge.sigma_px = 0;
  EXPECT_FALSE(converge(truth, edges));
}

// The step of perception's fits is the step that Ceres' own residuals and derivatives ask for.
Eigen::Vector3d gauss_newton(const Linearisation& at) {
  return -(at.jacobian.transpose() * at.jacobian).ldlt().solve(at.jacobian.transpose() * at.residuals);
}

TEST(Linearisation, OfTheCircleIsThatOfTheStep) {
  RandomEngine engine = random_stream(9, "test");
  for (int round = 0; round < 20; ++round) {
    const UndistortedCircle truth{{uniform(engine, -200, 200), uniform(engine, -200, 200)},
                                  uniform(engine, 8, 90)};
    const std::vector<RingPixel> ring = ring_on(truth, 0.7, engine, round % 2 == 0 ? 2 * M_PI : M_PI);
    const UndistortedCircle start = shifted(truth, uniform(engine, -2, 2), uniform(engine, -2, 2), 1);
    const Linearisation at = linearise(start, ring);
    ASSERT_EQ(at.residuals.size(), static_cast<Eigen::Index>(ring.size()));
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d away = start.center_px - ring[i].position_px;
      const double root = std::sqrt(ring[i].weight), d = away.norm();
      const Eigen::Vector3d row(away.x() / d, away.y() / d, -1);  // paper, "Raffinement"
      EXPECT_NEAR(at.residuals[static_cast<Eigen::Index>(i)], root * (d - start.radius_px), 1e-9);
      EXPECT_LT((at.jacobian.row(static_cast<Eigen::Index>(i)).transpose() - root * row).norm(), 1e-9);
    }
    const auto step = one_gauss_newton_step(start, ring);
    ASSERT_TRUE(step);
    const Eigen::Vector3d expected = gauss_newton(at);
    EXPECT_LT((step->circle.center_px - start.center_px - expected.head<2>()).norm(), 1e-9);
    EXPECT_NEAR(step->circle.radius_px - start.radius_px, expected.z(), 1e-9);
  }
}

TEST(Linearisation, OfTheConeIsThatOfTheStep) {
  RandomEngine engine = random_stream(10, "test");
  for (int round = 0; round < 20; ++round) {
    const Eigen::Vector3d p_C(uniform(engine, -0.5, 0.5), uniform(engine, -0.4, 0.4),
                              uniform(engine, 0.5, 3));
    const std::vector<EdgePoint> edges = edges_on(p_C, 0.035, 0.3, engine);
    const TangentCone truth = *TangentCone::of_sphere(p_C, 0.035);
    const TangentCone start = moved(
        truth, 0.1 * truth.alpha_rad * Eigen::Vector3d(uniform(engine, -1, 1), uniform(engine, -1, 1), 0.5));
    const auto step = one_gauss_newton_step(start, edges);
    ASSERT_TRUE(step);
    const TangentCone expected = moved(start, gauss_newton(linearise(start, edges)));
    EXPECT_LT((step->cone.axis - expected.axis).norm(), 1e-9);
    EXPECT_NEAR(step->cone.alpha_rad, expected.alpha_rad, 1e-9);
  }
}

// A fifth of the points lie on something else, 3 px outside.
TEST(RobustFits, HoldWhereSquaresAreDrawnAway) {
  RandomEngine engine = random_stream(11, "test");
  const UndistortedCircle truth{{10, -20}, 40};
  std::vector<RingPixel> ring = ring_on(truth, 0.1, engine);
  for (std::size_t i = 0; i < ring.size() / 5; ++i)
    ring[i].position_px += 3 * (ring[i].position_px - truth.center_px).normalized();
  const auto squares = converge(truth, ring);
  ASSERT_TRUE(squares);
  EXPECT_GT((squares->shape.center_px - truth.center_px).norm(), 0.5);
  for (const RobustLossKind kind : {RobustLossKind::cauchy, RobustLossKind::tukey}) {
    const auto robust = converge(shifted(truth, 1, 1, 0.5), ring, {kind, 0.5});
    ASSERT_TRUE(robust) << static_cast<int>(kind);
    EXPECT_LT((robust->shape.center_px - truth.center_px).norm(), 0.1) << static_cast<int>(kind);
    EXPECT_TRUE(robust->convergence.converged);
  }
}

TEST(Convergence, KnowsHowWellThePointsDetermineTheCircle) {
  RandomEngine engine = random_stream(12, "test");
  const UndistortedCircle truth{{0, 0}, 30};
  const auto whole = converge(truth, ring_on(truth, 0.1, engine));
  const auto short_arc = converge(truth, ring_on(truth, 0.1, engine, 0.3 * M_PI));
  ASSERT_TRUE(whole && short_arc);
  EXPECT_LT(whole->convergence.condition, 4);
  EXPECT_GT(short_arc->convergence.condition, 5 * whole->convergence.condition);
}

}  // namespace
}  // namespace ballservo
