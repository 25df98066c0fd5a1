#include "app/comparison/estimators/position_bound.hpp"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <vector>

#include "calibration/base/random.hpp"
#include "perception/outline/edge_model.hpp"

namespace ballservo {
namespace {

constexpr double ball_radius_m = 0.035, small_focal_px = 300;
constexpr int width = 120, height = 100;
constexpr double cx_px = 59.5, cy_px = 49.5;

Camera small_camera() {
  CameraParameters parameters;
  parameters.size = {width, height};
  parameters.fx_px = parameters.fy_px = small_focal_px;
  parameters.cx_px = cx_px;
  parameters.cy_px = cy_px;
  return Camera(parameters);
}

// One side's colours and the limb's shading, the same all round.
struct Look {
  std::array<double, 3> background{60, 90, 120}, ball{60, 90, 220};
  double root = 0, ramp = 0;  // relative to the ball's level, per sqrt(px) and px
};

// Phi, F and R of a number that carries derivatives.
template <class T>
std::array<T, 3> basis_of(const T& x);
template <>
std::array<double, 3> basis_of(const double& x) {
  const BlurredBasis at = blurred_basis(x);
  return {at.step, at.root, at.ramp};
}
template <class Jet>
std::array<Jet, 3> basis_of(const Jet& x) {
  const BlurredBasis at = blurred_basis(x.a);
  return {Jet(at.step, at.step_slope * x.v), Jet(at.root, at.root_slope * x.v),
          Jet(at.ramp, at.ramp_slope * x.v)};
}

// The distance (px) of a pixel from the outline: the angle outside the cone over its slope in the picture.
template <class T>
T distance_px(const T* p, double u, double v) {
  const double x = (u - cx_px) / small_focal_px, y = (v - cy_px) / small_focal_px,
               length = std::sqrt(x * x + y * y + 1);
  const T away = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
  const T along = (p[0] * x + p[1] * y + p[2]) / length, cosine = along / away;
  const T slope_x = (p[0] - along * (x / length)) / (away * length);
  const T slope_y = (p[1] - along * (y / length)) / (away * length);
  const T slope = sqrt((slope_x * slope_x + slope_y * slope_y) / (1.0 - cosine * cosine));
  return small_focal_px * (acos(cosine) - asin(ball_radius_m / away)) / slope;
}

// Levels of the three channels: `own` is O (3), A (3), slopes of root and ramp.
template <class T>
void levels_at(const T& distance, const T& s, const T* own, T* levels) {
  const std::array<T, 3> basis = basis_of(T(-distance / s));
  for (int c = 0; c < 3; ++c) {
    const T shading = own[6] * sqrt(s) * basis[1] + own[7] * s * basis[2];
    levels[c] = own[c] + own[3 + c] * basis[0] + (own[c] + own[3 + c]) * shading;
  }
}

std::array<double, 8> model_of(const Look& look) {
  std::array<double, 8> own{};
  for (std::size_t c = 0; c < 3; ++c) {
    own[c] = look.background[c];
    own[3 + c] = look.ball[c] - look.background[c];
  }
  own[6] = look.root;
  own[7] = look.ramp;
  return own;
}

double edge_width(double blur_px) { return std::sqrt(blur_px * blur_px + 1.0 / 12); }

cv::Mat picture_of(const Eigen::Vector3d& p_CB, const Look& look, double blur_px) {
  cv::Mat picture(height, width, CV_32FC3);
  const std::array<double, 8> own = model_of(look);
  const double s = edge_width(blur_px);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      std::array<double, 3> levels{};
      levels_at(distance_px(p_CB.data(), u, v), s, own.data(), levels.data());
      for (int c = 0; c < 3; ++c)
        picture.at<cv::Vec3f>(v, u)[c] = static_cast<float>(levels[static_cast<std::size_t>(c)]);
    }
  }
  return picture;
}

struct Case {
  Eigen::Vector3d p_CB{0, 0, 0.5};
  Look look;
  double blur_px = 0.7, noise = 2;
  cv::Mat unhidden;
};

std::optional<Eigen::Matrix3d> bound_of(const Case& it, const BoundNuisances& unknown = {}) {
  const Camera camera = small_camera();
  return position_bound({camera, it.p_CB, ball_radius_m, it.blur_px, it.noise, 0,
                         picture_of(it.p_CB, it.look, it.blur_px), it.unhidden},
                        unknown);
}
double depth_sigma(const Eigen::Matrix3d& covariance) { return std::sqrt(covariance(2, 2)); }
double sigma(const Eigen::Matrix3d& covariance) { return std::sqrt(covariance.trace()); }

// A blurred step of height A under noise n tells its place with information A^2 / (2 sqrt(pi) s n^2) per px
// of its length: the integral of (A phi(t/s) / s)^2 / n^2.
TEST(PositionBound, IsThatOfAStepAlongACircleWhereNothingElseIsUnknown) {
  for (const double blur_px : {0.5, 0.7, 1.5}) {
    Case it;
    it.blur_px = blur_px;
    const double z = it.p_CB.z(), tangent = std::sqrt(z * z - ball_radius_m * ball_radius_m);
    const double outline_px = small_focal_px * ball_radius_m / tangent;
    const double slope = outline_px * z / (tangent * tangent);  // of the radius against depth
    const double per_px =
        100 * 100 / (2 * std::sqrt(M_PI) * edge_width(blur_px) * (it.noise * it.noise + 1.0 / 12));
    const double expected = 1 / std::sqrt(2 * M_PI * outline_px * per_px * slope * slope);
    const auto bound = bound_of(it, nothing_unknown);
    ASSERT_TRUE(bound);
    EXPECT_NEAR(depth_sigma(*bound), expected, 0.01 * expected) << blur_px;
  }
}

// The radius falls as 1/Z, its slope against Z as 1/Z^2, and there are 1/Z as many pixels to see it by.
TEST(PositionBound, DepthSigmaGrowsWithThePowerFiveHalvesOfTheDistance) {
  Case near, far;
  near.p_CB.z() = 0.35;
  far.p_CB.z() = 0.7;
  const auto of_near = bound_of(near), of_far = bound_of(far);
  ASSERT_TRUE(of_near && of_far);
  EXPECT_NEAR(depth_sigma(*of_far) / depth_sigma(*of_near), std::pow(2, 2.5), 0.05 * std::pow(2, 2.5));
}

TEST(PositionBound, GrowsWithNoiseBlurAndHiddenPart) {
  const Case plain;
  const double base = sigma(*bound_of(plain));
  Case noisy = plain;
  noisy.noise = 10;
  EXPECT_NEAR(sigma(*bound_of(noisy)) / base, std::sqrt((100 + 1.0 / 12) / (4 + 1.0 / 12)), 1e-6);
  Case blurred = plain;
  blurred.blur_px = 1.5;
  EXPECT_GT(sigma(*bound_of(blurred)), 1.2 * base);
  double last = base;
  for (const int hidden_columns : {46, 54, 60, 66}) {
    Case hidden = plain;
    hidden.unhidden = cv::Mat(height, width, CV_8UC1, cv::Scalar(255));
    hidden.unhidden.colRange(0, hidden_columns).setTo(0);
    const auto bound = bound_of(hidden);
    ASSERT_TRUE(bound);
    EXPECT_GT(sigma(*bound), 1.05 * last) << hidden_columns;
    last = sigma(*bound);
  }
}

TEST(PositionBound, WhatIsNotToldNeverHelps) {
  Case it;
  it.p_CB = {0.02, -0.01, 0.5};
  it.look.root = -0.05;
  double last = 0;
  for (const BoundNuisances& unknown :
       {nothing_unknown, BoundNuisances{true, false, false, false}, BoundNuisances{true, true, false, false},
        BoundNuisances{true, true, true, false}, BoundNuisances{}}) {
    const auto bound = bound_of(it, unknown);
    ASSERT_TRUE(bound);
    EXPECT_GE(sigma(*bound), last * (1 - 1e-9));
    last = sigma(*bound);
  }
  EXPECT_GT(last, 1.2 * sigma(*bound_of(it, nothing_unknown)));
}

// The blur of what hides the ball reaches over its edge: what is seen there is not the ball's alone.
TEST(PositionBound, PixelsBesideWhatHidesTheBallTellNothing) {
  Case it;
  it.unhidden = cv::Mat(height, width, CV_8UC1, cv::Scalar(255));
  it.unhidden.colRange(0, 54).setTo(0);
  const auto clean = bound_of(it);
  cv::Mat smeared = picture_of(it.p_CB, it.look, it.blur_px);
  smeared.colRange(54, 56).setTo(cv::Scalar(10, 200, 30));  // within three sigma of the edge
  const Camera camera = small_camera();
  const auto beside =
      position_bound({camera, it.p_CB, ball_radius_m, it.blur_px, it.noise, 0, smeared, it.unhidden});
  ASSERT_TRUE(clean && beside);
  EXPECT_EQ(*clean, *beside);
}

// An arc segment's own background, contrast and shading can't be told from a few of its pixels.
TEST(PositionBound, ArcSegmentsOfWhichLittleIsSeenDoNotCount) {
  Case it;
  it.unhidden = cv::Mat(height, width, CV_8UC1, cv::Scalar(255));
  for (int u = 0; u < width; u += 14) it.unhidden.colRange(u, std::min(width, u + 4)).setTo(0);
  for (int v = 0; v < height; v += 14) it.unhidden.rowRange(v, std::min(height, v + 4)).setTo(0);
  EXPECT_FALSE(bound_of(it));  // of 14 x 14 pixels the 4 x 4 are left that no blur reaches
}

TEST(PositionBound, NothingWhereThePictureTellsNothing) {
  Case flat;
  flat.look.ball = flat.look.background;
  EXPECT_FALSE(bound_of(flat));
  Case hidden;
  hidden.unhidden = cv::Mat::zeros(height, width, CV_8UC1);
  EXPECT_FALSE(bound_of(hidden));
  Case around;
  around.p_CB.z() = 0.01;  // the camera is inside
  EXPECT_FALSE(bound_of(around));
  Case white;
  white.look.background = {300, 300, 300};
  white.look.ball = {400, 400, 400};
  EXPECT_FALSE(bound_of(white));
}

struct PixelResidual {
  double u, v;
  cv::Vec3f seen;
  template <class T>
  bool operator()(const T* p, const T* s, const T* own, T* residual) const {
    T levels[3];
    levels_at(distance_px(p, u, v), s[0], own, levels);
    for (int c = 0; c < 3; ++c) residual[c] = levels[c] - T(static_cast<double>(seen[c]));
    return true;
  }
};

// The most likely ball: the model itself fitted to a picture, every unknown of the bound free.
Eigen::Vector3d fitted(const cv::Mat& picture, const Case& it) {
  Eigen::Vector3d p = it.p_CB;
  double s = edge_width(it.blur_px);
  const double radius_px = small_focal_px * ball_radius_m / it.p_CB.z(), reach_px = 3 * s + 4;
  const int count = static_cast<int>(std::ceil(2 * M_PI * radius_px / 8));
  std::vector<std::array<double, 8>> own(static_cast<std::size_t>(count), model_of(it.look));
  ceres::Problem problem;
  ceres::Solver::Options options;
  options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (std::abs(distance_px(it.p_CB.data(), u, v)) > reach_px) continue;
      const double angle =
          std::atan2(v - cy_px - small_focal_px * p.y() / p.z(), u - cx_px - small_focal_px * p.x() / p.z());
      const auto segment = static_cast<std::size_t>((angle + M_PI) / (2 * M_PI) * count) % own.size();
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PixelResidual, 3, 3, 1, 8>(
              new PixelResidual{static_cast<double>(u), static_cast<double>(v), picture.at<cv::Vec3f>(v, u)}),
          nullptr, p.data(), &s, own[segment].data());
    }
  }
  for (auto& of_segment : own) options.linear_solver_ordering->AddElementToGroup(of_segment.data(), 0);
  options.linear_solver_ordering->AddElementToGroup(p.data(), 1);
  options.linear_solver_ordering->AddElementToGroup(&s, 1);
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.function_tolerance = 1e-9;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  EXPECT_TRUE(summary.IsSolutionUsable());
  return p;
}

TEST(PositionBound, TheMostLikelyBallAttainsItAndNoMore) {
  Case it;
  it.p_CB = {0.04, -0.02, 0.65};
  it.look.ball = {60, 90, 160};
  it.look.root = 0.15;  // as strong as light from the camera's side makes it
  it.look.ramp = -0.01;
  const auto bound = bound_of(it);
  ASSERT_TRUE(bound);
  const cv::Mat clean = picture_of(it.p_CB, it.look, it.blur_px);
  const double noise = std::sqrt(it.noise * it.noise + 1.0 / 12);
  constexpr int trials = 400;
  double mahalanobis2 = 0, squares_m2 = 0;
  for (int k = 0; k < trials; ++k) {
    RandomEngine engine = random_stream(1, "position_bound_test", static_cast<std::uint64_t>(k));
    cv::Mat noisy = clean.clone();
    for (int i = 0; i < width * height; ++i) {
      for (int c = 0; c < 3; ++c)
        noisy.at<cv::Vec3f>(i / width, i % width)[c] += static_cast<float>(noise * standard_normal(engine));
    }
    const Eigen::Vector3d error = fitted(noisy, it) - it.p_CB;
    mahalanobis2 += error.dot(bound->ldlt().solve(error)) / trials;
    squares_m2 += error.squaredNorm() / trials;
  }
  EXPECT_NEAR(std::sqrt(squares_m2) / sigma(*bound), 1, 0.1);
  EXPECT_NEAR(mahalanobis2, 3, 0.5);  // four standard deviations
}

}  // namespace
}  // namespace ballservo
