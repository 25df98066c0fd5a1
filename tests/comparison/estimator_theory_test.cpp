// What theory says of the estimators, each against exact truth.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "app/comparison/estimators/algebraic_circles.hpp"
#include "app/comparison/estimators/converged_fits.hpp"
#include "app/comparison/estimators/methods.hpp"
#include "calibration/base/random.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "perception/outline/paper_refinement.hpp"
#include "perception/segmentation/regions.hpp"
#include "tests/comparison/fit_costs.hpp"
#include "tests/perception/segmentation/class_pictures.hpp"

namespace ballservo {
namespace {

constexpr double radius_m = 0.035, focal_px = 857;
const std::vector<RobustLoss> losses{{RobustLossKind::squares, 0.3},
                                     {RobustLossKind::huber, 0.3},
                                     {RobustLossKind::cauchy, 0.3},
                                     {RobustLossKind::tukey, 0.3}};

// A ball and points that lie exactly on its outline, as each estimator takes them.
struct ExactBall {
  UndistortedCircle circle;
  std::vector<RingPixel> ring;
  std::vector<BoundaryPoint> boundary;
  Eigen::Vector3d p_C{0, 0, 1};
  std::vector<EdgePoint> edges;

  TangentCone cone() const { return *TangentCone::of_sphere(p_C, radius_m); }
};

ExactBall exact_ball(RandomEngine& engine, double arc_rad) {
  ExactBall ball;
  ball.circle = {{uniform(engine, -200, 200), uniform(engine, -200, 200)}, uniform(engine, 8, 90)};
  for (int k = 0; k < 96; ++k) {
    const double angle = arc_rad * k / 96;
    const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
    const Eigen::Vector2d place = ball.circle.center_px + ball.circle.radius_px * normal;
    ball.ring.push_back({place, uniform(engine, 10, 2000), 0, 0});
    ball.boundary.push_back({place.cast<float>(), normal.cast<float>()});
  }
  ball.p_C = {uniform(engine, -0.5, 0.5), uniform(engine, -0.4, 0.4), uniform(engine, 0.5, 3)};
  const std::vector<Eigen::Vector3d> rays = outline_rays(ball.p_C, radius_m, 96);
  for (std::size_t k = 0; k < 96 * arc_rad / (2 * M_PI); ++k)
    ball.edges.push_back({rays[k], focal_px, uniform(engine, 0.05, 0.3), uniform(engine, 0.1, 1), 0});
  return ball;
}

double apart_px(const UndistortedCircle& a, const UndistortedCircle& b) {
  return (a.center_px - b.center_px).norm() + std::abs(a.radius_px - b.radius_px);
}
double apart_px(const TangentCone& a, const TangentCone& b) {
  return focal_px * ((a.axis - b.axis).norm() + std::abs(a.alpha_rad - b.alpha_rad));
}

// How far (px) from the truth an estimator ends that starts there; infinite where it has no answer.
using Strays = std::function<double(const ExactBall&)>;
constexpr double lost = std::numeric_limits<double>::infinity();

double steps_stray(const ExactBall& ball, int steps) {
  UndistortedCircle circle = ball.circle;
  for (int k = 0; k < steps; ++k) {
    const auto step = one_gauss_newton_step(circle, ball.ring);
    if (!step || step->residual_px > 1e-9) return lost;
    circle = step->circle;
  }
  return apart_px(circle, ball.circle);
}
double cone_steps_stray(const ExactBall& ball, int steps) {
  TangentCone cone = ball.cone();
  for (int k = 0; k < steps; ++k) {
    const auto step = one_gauss_newton_step(cone, ball.edges);
    if (!step || step->residual_px > 1e-7) return lost;
    cone = step->cone;
  }
  return apart_px(cone, ball.cone());
}
double circle_stray(const ExactBall& ball, const RobustLoss& loss) {
  const auto fit = converge(ball.circle, ball.ring, loss);
  if (!fit || fit->convergence.residual_px > 1e-9) return lost;
  return apart_px(fit->shape, ball.circle);
}
double cone_stray(const ExactBall& ball, const RobustLoss& loss) {
  const auto fit = converge(ball.cone(), ball.edges, loss);
  if (!fit || fit->convergence.residual_px > 1e-7) return lost;
  return apart_px(fit->shape, ball.cone());
}
double worst_of_losses(const ExactBall& ball, double (*stray)(const ExactBall&, const RobustLoss&)) {
  double worst = 0;
  for (const RobustLoss& loss : losses) worst = std::max(worst, stray(ball, loss));
  return worst;
}
double stray_of(const ExactBall& ball, const std::optional<UndistortedCircle>& circle) {
  return circle ? apart_px(*circle, ball.circle) : lost;
}
// The votes know no start; their places are single-precision pixels, averaged over the cells of a histogram.
double vote_stray(const ExactBall& ball) {
  CircleVoter voter;
  RandomEngine engine = random_stream(1, "estimator_theory/vote");
  const auto circle = voter.estimate(ball.boundary, engine);
  return circle ? apart_px({circle->center_px, circle->radius_px}, ball.circle) : lost;
}

std::map<std::string, Strays> estimators() {
  std::map<std::string, Strays> all{
      {"vote", vote_stray},
      {"paper_one_step", [](const ExactBall& b) { return steps_stray(b, 1); }},
      {"paper_converged", [](const ExactBall& b) { return circle_stray(b, {}); }},
      {"paper_robust", [](const ExactBall& b) { return worst_of_losses(b, circle_stray); }},
      {"sphere_one_step", [](const ExactBall& b) { return cone_steps_stray(b, 1); }},
      {"sphere_steps_2", [](const ExactBall& b) { return cone_steps_stray(b, 2); }},
      {"sphere_converged", [](const ExactBall& b) { return cone_stray(b, {}); }},
      {"sphere_robust", [](const ExactBall& b) { return worst_of_losses(b, cone_stray); }},
      {"kasa", [](const ExactBall& b) { return stray_of(b, kasa_circle(b.ring)); }},
      {"taubin", [](const ExactBall& b) { return stray_of(b, taubin_circle(b.ring)); }}};
  for (const int steps : {2, 3, 5, 10}) {
    // Where a step does not move, the ring around it is the same: choosing it anew changes nothing.
    for (const char* ring : {"", "_reselect"})
      all["paper_steps_" + std::to_string(steps) + ring] = [=](const ExactBall& b) {
        return steps_stray(b, steps);
      };
  }
  return all;
}

TEST(EveryEstimator, LeavesNoResidualAtTheTruthAndStaysThere) {
  const std::map<std::string, Strays> all = estimators();
  for (const FitMethod& method : fit_methods()) {
    if (method.is_peer || method.detect) continue;  // whole detectors fit as sphere_one_step and vote do
    const auto estimator = all.find(method.name);
    ASSERT_NE(estimator, all.end()) << method.name << " is not held against exact points";
    for (const double arc_rad : {2 * M_PI, M_PI}) {
      for (std::uint64_t round = 0; round < 20; ++round) {
        RandomEngine engine = random_stream(1, "estimator_theory/truth", round);
        const double allowed_px = method.name == "vote" ? 0.1 : 1e-6;
        EXPECT_LT(estimator->second(exact_ball(engine, arc_rad)), allowed_px)
            << method.name << ", round " << round << ", arc " << arc_rad;
      }
    }
  }
}

// Sum of weighted squares of an algebraic or geometric distance, by (x, y, r).
using CircleCost = std::function<double(const UndistortedCircle&, const std::vector<RingPixel>&)>;
double kasa_cost(const UndistortedCircle& circle, const std::vector<RingPixel>& ring) {
  double sum = 0;
  for (const RingPixel& p : ring) {
    const double distance =
        (p.position_px - circle.center_px).squaredNorm() - circle.radius_px * circle.radius_px;
    sum += p.weight * distance * distance;
  }
  return sum;
}
double taubin_cost(const UndistortedCircle& circle, const std::vector<RingPixel>& ring) {
  double slopes = 0;
  for (const RingPixel& p : ring) slopes += p.weight * 4 * (p.position_px - circle.center_px).squaredNorm();
  return kasa_cost(circle, ring) / slopes;
}

// A slope is what differs between the two sides of the truth, against what they have in common.
void expect_a_minimum(const std::function<double(const Eigen::Vector3d&)>& cost, double unit,
                      const std::string& name) {
  const double away = cost({unit, 0, 0});
  EXPECT_LT(cost({0, 0, 0}), 1e-18 * away) << name;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d d = 1e-4 * unit * Eigen::Vector3d::Unit(axis);
    EXPECT_GT(cost(d), 0) << name;
    EXPECT_LT(std::abs(cost(d) - cost(-d)), 1e-3 * cost(d)) << name << " by unknown " << axis;
  }
}

TEST(EveryCost, IsNoneAtTheTruthAndHasNoSlopeThere) {
  const std::map<std::string, CircleCost> costs{
      {"E(c)", circle_cost}, {"Kasa", kasa_cost}, {"Taubin", taubin_cost}};
  for (std::uint64_t round = 0; round < 20; ++round) {
    RandomEngine engine = random_stream(2, "estimator_theory/slope", round);
    const ExactBall ball = exact_ball(engine, round % 2 == 0 ? 2 * M_PI : M_PI);
    for (const auto& [name, cost] : costs) {
      expect_a_minimum(
          [&, &of = cost](const Eigen::Vector3d& d) {
            return of({ball.circle.center_px + d.head<2>(), ball.circle.radius_px + d.z()}, ball.ring);
          },
          1, name);
    }
    expect_a_minimum(
        [&](const Eigen::Vector3d& d) {
          return cone_cost(d.norm() > 0 ? moved(ball.cone(), d) : ball.cone(), ball.edges);
        },
        1 / focal_px, "cone");
  }
}

// Slope of log y against log x by least squares.
double exponent(const std::vector<double>& x, const std::vector<double>& y) {
  double mx = 0, my = 0, sxy = 0, sxx = 0;
  const auto n = static_cast<double>(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) {
    mx += std::log(x[k]) / n;
    my += std::log(y[k]) / n;
  }
  for (std::size_t k = 0; k < x.size(); ++k) {
    sxy += (std::log(x[k]) - mx) * (std::log(y[k]) - my);
    sxx += (std::log(x[k]) - mx) * (std::log(x[k]) - mx);
  }
  return sxy / sxx;
}

struct DepthGrowth {
  double exponent, interval;  // of the RMS error with Z; half of its 95 % interval
};
// The sphere's step from a start 2 % off; `points_at_1_m` at 1 m, and as many elsewhere or as the outline is
// long.
DepthGrowth depth_growth(bool as_many_everywhere) {
  const std::vector<double> depths_m{0.5, 0.75, 1, 1.5, 2, 3};
  constexpr int trials = 600;
  std::vector<double> rms_m;
  double spread = 0;
  for (const double z_m : depths_m) {
    const Eigen::Vector3d p_C(0.1 * z_m, -0.05 * z_m, z_m);
    const int points = as_many_everywhere ? 48 : static_cast<int>(std::lround(96 / z_m));
    double squares = 0;
    for (int k = 0; k < trials; ++k) {
      RandomEngine engine = random_stream(3, "estimator_theory/depth", static_cast<std::uint64_t>(k));
      std::vector<EdgePoint> edges;
      for (const Eigen::Vector3d& ray : outline_rays(p_C, radius_m, points)) {
        const Eigen::Vector3d outward = (ray - ray.dot(p_C.normalized()) * p_C.normalized()).normalized();
        edges.push_back(
            {(ray + 0.1 * standard_normal(engine) / focal_px * outward).normalized(), focal_px, 0.1, 1, 0});
      }
      const TangentCone start = *TangentCone::of_sphere(1.02 * p_C, radius_m);
      const auto fit = one_gauss_newton_step(start, edges);
      if (!fit) return {lost, 0};
      squares += std::pow(fit->cone.center(radius_m).z() - z_m, 2) / trials;
    }
    rms_m.push_back(std::sqrt(squares));
  }
  double mean = 0;
  for (const double z_m : depths_m) mean += std::log(z_m) / static_cast<double>(depths_m.size());
  for (const double z_m : depths_m) spread += std::pow(std::log(z_m) - mean, 2);
  // The logarithm of an RMS of n normal errors has the standard deviation 1 / sqrt(2 n).
  return {exponent(depths_m, rms_m), 1.96 / std::sqrt(2.0 * trials * spread)};
}

// A radius of r px says Z = f R / r: an error of the radius moves it by Z^2 / (f R) times that. With as many
// points everywhere the radius is known alike; where they are as many as the outline has pixels, by
// 1 / sqrt(r) ~ sqrt(Z) worse.
TEST(DepthError, GrowsWithTheSquareOfTheDistance) {
  const DepthGrowth alike = depth_growth(true), pixels = depth_growth(false);
  EXPECT_NEAR(alike.exponent, 2, alike.interval);
  EXPECT_LT(alike.interval, 0.1);
  EXPECT_NEAR(pixels.exponent, 2.5, pixels.interval + 0.02);  // whole points
}

struct BoundaryBias {
  double distance_px = 0, circle_px = 0, shifted_px = 0;
};
// Of discs painted without a grey level: the mean distance of the boundary's pixels from the outline, and the
// radius of the circle through them, and through them shifted outwards by half a pixel as the votes take
// them.
BoundaryBias boundary_bias(int discs) {
  BoundaryBias bias;
  RegionMap map;
  for (int k = 0; k < discs; ++k) {
    RandomEngine engine = random_stream(4, "estimator_theory/boundary", static_cast<std::uint64_t>(k));
    const Eigen::Vector2d center(uniform(engine, 59, 60), uniform(engine, 59, 60));
    const double radius_px = uniform(engine, 25, 45);
    cv::Mat numbers = cv::Mat::zeros(120, 120, CV_8UC1);
    for (int v = 0; v < 120; ++v) {
      for (int u = 0; u < 120; ++u)
        if ((Eigen::Vector2d(u, v) - center).norm() <= radius_px) numbers.at<std::uint8_t>(v, u) = 1;
    }
    ClassPictures classes = test::to_bits(numbers, 1);
    map.update(classes, numbers.size());
    std::vector<BoundaryPixel> boundary;
    std::vector<RingPixel> ring, shifted;
    for (std::size_t region = 0; region < map.regions().size(); ++region) {
      if (map.regions()[region].color_class == 1) map.boundary(static_cast<int>(region), boundary);
    }
    for (const BoundaryPixel& pixel : boundary) {
      const Eigen::Vector2d place(pixel.u_px, pixel.v_px);
      const Eigen::Vector2d outward = outward_normal(classes[0], pixel).cast<double>();
      ring.push_back({place, 1, 0, 0});
      shifted.push_back({place + 0.5 * outward, 1, 0, 0});
      bias.distance_px +=
          ((place - center).norm() - radius_px) / static_cast<double>(boundary.size()) / discs;
    }
    const auto inner = converge(UndistortedCircle{center, radius_px}, ring);
    const auto moved_out = converge(UndistortedCircle{center, radius_px}, shifted);
    if (!inner || !moved_out) return {lost, lost, lost};
    bias.circle_px += (inner->shape.radius_px - radius_px) / discs;
    bias.shifted_px += (moved_out->shape.radius_px - radius_px) / discs;
  }
  return bias;
}

// The boundary is a region's own last pixels, so a circle through them is too small. In the octant where the
// outline's normal is within 45 degrees of a row, it is one pixel a row, 0 to 1 px from the outline along the
// row, all alike: at angle t cos(t)/2 along the normal, and there are cos(t) of them per pixel of outline:
//   (1/2) integral cos^2 / integral cos, 0 to pi/4 = (pi/8 + 1/4) / (2 sin(pi/4)) = 0.4545 px,
// not quite the half pixel by which the votes move them outwards.
TEST(BoundaryPixels, LieNearlyHalfAPixelInside) {
  const double theory_px = (M_PI / 8 + 0.25) / std::sqrt(2.0);
  const BoundaryBias bias = boundary_bias(60);
  EXPECT_NEAR(bias.distance_px, -theory_px, 0.01);
  EXPECT_NEAR(bias.circle_px, -theory_px, 0.01);
  EXPECT_NEAR(bias.shifted_px, 0.5 - theory_px, 0.015);
}

}  // namespace
}  // namespace ballservo
