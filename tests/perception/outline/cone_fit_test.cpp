#include "perception/outline/cone_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "calibration/base/random.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "perception/outline/paper_refinement.hpp"

namespace ballservo {
namespace {

std::vector<EdgePoint> edges_of(const Eigen::Vector3d& p_C, double radius_m, int count, double focal_px) {
  std::vector<EdgePoint> edges;
  for (const Eigen::Vector3d& ray : outline_rays(p_C, radius_m, count))
    edges.push_back({ray, focal_px, 0.1, 1, 0});
  return edges;
}

Eigen::Vector3d at_angle(double degrees, double depth_m) {
  return {depth_m * std::tan(degrees * 0.017453292519943295), 0, depth_m};
}

TangentCone disturbed(const TangentCone& cone, double step_rad) {
  return moved(cone, {step_rad, -0.7 * step_rad, 0.5 * step_rad});
}

class AnywhereInTheField : public testing::TestWithParam<double> {};

TEST_P(AnywhereInTheField, OneStepOnExactEdgePointsIsWithinATenthOfAMillimetre) {
  const Eigen::Vector3d p_C = at_angle(GetParam(), 1.0);
  const auto edges = edges_of(p_C, 0.035, 40, 500);
  // From a tenth of a pixel off, as the first of the two passes leaves it.
  const auto fit = one_gauss_newton_step(disturbed(*TangentCone::of_sphere(p_C, 0.035), 0.1 / 500), edges);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->cone.center(0.035) - p_C).norm(), 1e-4);
}

TEST_P(AnywhereInTheField, PaperFormulaOnAPerfectCircleIsExactOnlyOnTheAxis) {
  const double focal_px = 500;
  const Eigen::Vector3d p_C = at_angle(GetParam(), 1.0);
  // The circle through the outline's mean centre and mean radius.
  UndistortedCircle circle;
  const auto rays = outline_rays(p_C, 0.035, 360);
  for (const Eigen::Vector3d& ray : rays) circle.center_px += focal_px * ray.head<2>() / ray.z() / 360;
  for (const Eigen::Vector3d& ray : rays)
    circle.radius_px += (focal_px * ray.head<2>() / ray.z() - circle.center_px).norm() / 360;
  const double error_m = (paper_position(circle, focal_px, 0.035) - p_C).norm();
  if (GetParam() == 0) {
    EXPECT_LT(error_m, 1e-4);
  }
  if (GetParam() == 28) {
    EXPECT_NEAR(error_m, 0.071, 0.01);
  }
}

INSTANTIATE_TEST_SUITE_P(Angles, AnywhereInTheField, testing::Values(0.0, 15.0, 28.0, 60.0));

TEST(ConeFit, StaysAtTheTruth) {
  const Eigen::Vector3d p_C(0.2, -0.1, 1.3);
  const auto truth = *TangentCone::of_sphere(p_C, 0.06);
  const auto fit = one_gauss_newton_step(truth, edges_of(p_C, 0.06, 24, 480));
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->step_px, 1e-9);
  EXPECT_LT(fit->residual_px, 1e-9);
}

TEST(ConeFit, JacobianIsTheDerivativeOfTheResidual) {
  // A step that undoes a small disturbance exactly to first order proves the rows.
  const Eigen::Vector3d p_C(0.3, 0.2, 0.9);
  const auto truth = *TangentCone::of_sphere(p_C, 0.05);
  const auto edges = edges_of(p_C, 0.05, 30, 500);
  for (const double size : {1e-3, 1e-4}) {
    const auto fit = one_gauss_newton_step(disturbed(truth, size), edges);
    ASSERT_TRUE(fit);
    EXPECT_LT((fit->cone.axis - truth.axis).norm(), 30 * size * size);
    EXPECT_LT(std::abs(fit->cone.alpha_rad - truth.alpha_rad), 30 * size * size);
  }
}

TEST(ConeFit, RobustWeightsDropTheEdgesOfOtherThings) {
  const Eigen::Vector3d p_C(0.1, 0, 1);
  auto edges = edges_of(p_C, 0.035, 40, 857);
  auto engine = random_stream(3, "cone_fit_test");
  const auto truth = *TangentCone::of_sphere(p_C, 0.035);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const double shift_px =
        i < 14 ? uniform(engine, 0.8, 3) * (i % 3 == 0 ? 1 : -1) : 0.05 * standard_normal(engine);
    const TangentCone opened{truth.axis, truth.alpha_rad + shift_px / 857};
    edges[i].ray = outline_rays(opened.axis, std::sin(opened.alpha_rad), 40)[i];
  }
  const auto start = disturbed(truth, 0.3 / 857);
  RobustWeights().set(start, edges, 0.06);
  for (std::size_t i = 0; i < 14; ++i) EXPECT_LT(edges[i].weight, 0.05);
  const auto fit = one_gauss_newton_step(start, edges);
  ASSERT_TRUE(fit);
  EXPECT_LT((fit->cone.center(0.035) - p_C).norm(), 2e-3);
}

TEST(ConeFit, CovarianceGrowsWithNoiseAndDistance) {
  const auto sigma_m = [](double depth_m, double sigma_px) {
    auto edges = edges_of({0, 0, depth_m}, 0.035, 40, 857);
    for (EdgePoint& edge : edges) edge.sigma_px = sigma_px;
    const auto fit = one_gauss_newton_step(*TangentCone::of_sphere({0, 0, depth_m}, 0.035), edges);
    return std::sqrt(center_covariance(*fit, 0.035, 0)(2, 2));
  };
  EXPECT_GT(sigma_m(2, 0.1), 3 * sigma_m(1, 0.1));
  EXPECT_GT(sigma_m(1, 0.5), 1.5 * sigma_m(1, 0.1));
}

// Mean squared Mahalanobis distance of the centre over many sets of edges whose neighbours err alike by
// `rho`.
double mean_nees(double rho) {
  const Eigen::Vector3d p_C(0.1, -0.05, 1);
  const auto truth = *TangentCone::of_sphere(p_C, 0.035);
  const auto exact = edges_of(p_C, 0.035, 60, 1500);
  RandomEngine engine = random_stream(5, "correlated_edges");
  double sum = 0;
  constexpr int sets = 400;
  for (int k = 0; k < sets; ++k) {
    auto edges = exact;
    double error_px = 0.1 * standard_normal(engine);
    for (std::size_t i = 0; i < edges.size(); ++i) {
      error_px = rho * error_px + 0.1 * std::sqrt(1 - rho * rho) * standard_normal(engine);
      const Eigen::Vector3d out = (edges[i].ray - truth.axis * truth.axis.dot(edges[i].ray)).normalized();
      edges[i].ray = (edges[i].ray + out * (error_px / 1500)).normalized();
      edges[i].angle_rad = 6.283185307179586 * (static_cast<double>(i) + 0.5) / 60;
    }
    const auto fit = one_gauss_newton_step(truth, edges);
    if (!fit) return -1;
    const Eigen::Vector3d error = fit->cone.center(0.035) - p_C;
    sum += error.dot(center_covariance(*fit, 0.035, 0).inverse() * error);
  }
  return sum / sets;
}

TEST(ConeFit, CovarianceIsTrueAlsoWhereNeighbouringEdgesErrAlike) {
  for (const double rho : {0.0, 0.3, 0.6}) {
    EXPECT_GT(mean_nees(rho), 1.5) << rho;
    EXPECT_LT(mean_nees(rho), 6) << rho;
  }
}

TEST(ConeFit, ADiameterInDoubtIsADepthInDoubt) {
  // 0.3 mm of a 70 mm diameter is 4.3 mm at 1 m.
  const auto fit =
      one_gauss_newton_step(*TangentCone::of_sphere({0, 0, 1}, 0.035), edges_of({0, 0, 1}, 0.035, 40, 1e6));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(std::sqrt(center_covariance(*fit, 0.035, 0.00015)(2, 2)), 0.0043, 0.0001);
}

// Texture scatters the ball's own edges; that of its shadow on the floor is sharp.
TEST(ConeFit, AShadowsSharpEdgeDoesNotOutweighTheBalls) {
  constexpr double focal_px = 800;
  const TangentCone truth = *TangentCone::of_sphere({0.05, -0.02, 1}, 0.035);
  RandomEngine engine = random_stream(7, "shadow");
  for (int trial = 0; trial < 20; ++trial) {
    auto edges = edges_of(truth.center(0.035), 0.035, 24, focal_px);
    for (std::size_t i = 0; i < edges.size(); ++i) {
      EdgePoint& edge = edges[i];
      const bool of_shadow = i == 5;
      const double outside_px = of_shadow ? 3 : 0.4 * standard_normal(engine);
      edge.sigma_px = of_shadow ? 0.05 : 0.2;
      edge.ray = (edge.ray + outside_px / focal_px * (edge.ray - truth.axis).normalized()).normalized();
    }
    const auto step = RobustWeights().set(truth, edges, 0.06);
    ASSERT_TRUE(step);
    EXPECT_LT(step->norm() * focal_px, 0.5) << trial;
    EXPECT_EQ(edges[5].weight, 0) << trial;
  }
}

// A fifth of a ball's outline is in sight, and a part of a line across it.
TEST(ConeFit, AKnownAngleHoldsTheCenterOfAHalfHiddenBall) {
  constexpr double focal_px = 800;
  const TangentCone truth = *TangentCone::of_sphere({0.05, -0.02, 1}, 0.035);
  RandomEngine engine = random_stream(4, "half hidden");
  double free_px2 = 0, held_px2 = 0;
  constexpr int trials = 40;
  for (int trial = 0; trial < trials; ++trial) {
    auto edges = edges_of(truth.center(0.035), 0.035, 48, focal_px);
    edges.resize(10);
    for (EdgePoint& edge : edges)
      edge.ray = (edge.ray + 0.3 / focal_px * standard_normal(engine) * (edge.ray - truth.axis).normalized())
                     .normalized();
    // The edge of what hides it.
    for (int i = 1; i <= 4; ++i) {
      EdgePoint edge = edges[9];
      edge.ray = (edges[9].ray + 0.08 * i * (edges[0].ray - edges[9].ray)).normalized();
      edges.push_back(edge);
    }
    const auto error_px2 = [&](const KnownAngle& known) {
      auto weighted = edges;
      TangentCone cone = disturbed(truth, 1 / focal_px);
      const auto step = RobustWeights().set(cone, weighted, 0.06, 0, 1e-3, known);
      const auto fit = one_gauss_newton_step(step ? moved(cone, *step) : cone, weighted, 0, known);
      return fit ? (fit->cone.axis - truth.axis).squaredNorm() * focal_px * focal_px / trials : 1e6;
    };
    free_px2 += error_px2({});
    held_px2 += error_px2({truth.alpha_rad * 1.005, 0.01 * truth.alpha_rad});
  }
  EXPECT_LT(std::sqrt(held_px2), 0.6 * std::sqrt(free_px2));
  EXPECT_LT(std::sqrt(held_px2), 0.025 * truth.alpha_rad * focal_px);
}

TEST(ConeFit, DegenerateSetsHaveNoFit) {
  const auto cone = *TangentCone::of_sphere({0, 0, 1}, 0.035);
  EXPECT_FALSE(one_gauss_newton_step(cone, {}));
  EXPECT_FALSE(one_gauss_newton_step(cone, edges_of({0, 0, 1}, 0.035, 2, 500)));
  auto same = edges_of({0, 0, 1}, 0.035, 1, 500);
  same.resize(10, same[0]);
  EXPECT_FALSE(one_gauss_newton_step(cone, same));
  auto broken = edges_of({0, 0, 1}, 0.035, 10, 500);
  for (EdgePoint& edge : broken) edge.ray.x() = std::nan("");
  EXPECT_FALSE(one_gauss_newton_step(cone, broken));
  EXPECT_FALSE(TangentCone::of_sphere({0, 0, 0.01}, 0.035));
  EXPECT_FALSE(TangentCone::of_sphere({0, 0, std::nan("")}, 0.035));
}

TEST(ConeNearCircle, HasTheCirclesOutline) {
  const double focal_px = 500;
  for (const double x_px : {0.0, 120.0, 250.0}) {
    const UndistortedCircle circle{{x_px, -40}, 25};
    const auto cone = cone_near_circle(circle, focal_px);
    ASSERT_TRUE(cone);
    for (const Eigen::Vector3d& ray : outline_rays(cone->axis, std::sin(cone->alpha_rad), 32)) {
      const Eigen::Vector2d p = focal_px * ray.head<2>() / ray.z();
      EXPECT_NEAR((p - circle.center_px).norm(), 25, 0.08 * 25);  // an ellipse of up to 14 % meets a circle
    }
  }
}

}  // namespace
}  // namespace ballservo
