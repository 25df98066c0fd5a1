#include "perception/judgement/ball_shading.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "calibration/base/random.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

constexpr double radius_px = 30;
const Eigen::Vector2d center_px(160, 120);

// The light that leaves a thing where a sphere would have the normal n (n.z() towards the camera): its own
// colour's, and that of the lamp in the mirror.
struct Light {
  double own = 0, mirrored = 0;
};
using Look = std::function<Light(const Eigen::Vector3d& n)>;

// A lamp so far aside that a part is in the dark.
Light lambert(const Eigen::Vector3d& n) {
  const Eigen::Vector3d lamp = Eigen::Vector3d(-0.9, -0.3, 0.4).normalized();
  return {0.35 + 0.6 * std::max(0.0, n.dot(lamp)), 0};
}
Light glossy(const Eigen::Vector3d& n) {
  const Eigen::Vector3d between = Eigen::Vector3d(-0.5, -0.2, 1).normalized();
  return {lambert(n).own, 0.5 * std::pow(std::max(0.0, n.dot(between)), 60)};
}
Light even(const Eigen::Vector3d&) { return {0.8, 0}; }
Light two_shades(const Eigen::Vector3d& n) { return {n.y() < 0.1 ? 0.8 : 0.32, 0}; }
Light cloudy(const Eigen::Vector3d& n) {
  return {0.6 + 0.15 * std::sin(6 * n.x() + 1) + 0.15 * std::sin(5 * n.y()), 0};
}

// What is seen of it to the left of a bright card's edge, through a lens that blurs and a noisy sensor.
BallShading shading_of(const Look& look, int cut_px, double noise = 3) {
  cv::Mat bgr = test::grey_picture();
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      const Eigen::Vector2d n = (Eigen::Vector2d(u, v) - center_px) / radius_px;
      if (n.norm() > 1) continue;
      const Light light = look({n.x(), n.y(), std::sqrt(1 - n.squaredNorm())});
      for (int c = 0; c < 3; ++c)
        bgr.at<cv::Vec3b>(v, u)[c] =
            cv::saturate_cast<std::uint8_t>(light.own * test::red[c] + 255 * light.mirrored);
    }
  }
  bgr.colRange(cut_px, bgr.cols) = cv::Scalar(250, 200, 180);
  cv::GaussianBlur(bgr, bgr, {}, 0.8);
  RandomEngine engine = random_stream(1, "shading");
  for (int v = 0; v < bgr.rows; ++v)
    for (int u = 0; u < bgr.cols; ++u)
      for (int c = 0; c < 3; ++c)
        bgr.at<cv::Vec3b>(v, u)[c] =
            cv::saturate_cast<std::uint8_t>(bgr.at<cv::Vec3b>(v, u)[c] + noise * standard_normal(engine));
  BitPicture pixels;
  pixels.resize(bgr.size());
  for (int v = 0; v < bgr.rows; ++v) {
    pixels.fill(v, 0, bgr.cols, false);
    for (int u = 0; u < cut_px; ++u) {
      if ((Eigen::Vector2d(u, v) - center_px).norm() < radius_px - 1) pixels.fill(v, u, u + 1, true);
    }
  }
  const Camera camera = long_lens_camera({bgr.cols, bgr.rows});
  const Eigen::Vector3d edge = *camera.unproject(center_px + Eigen::Vector2d(radius_px, 0));
  TangentCone cone;
  cone.axis = *camera.unproject(center_px);
  cone.alpha_rad = std::acos(std::min(1.0, cone.axis.dot(edge)));
  const ColoredPixels colored{1, pixels, {0, 0}};
  const RayTable rays(camera);
  const OutlineEllipse outline{center_px, radius_px};
  const BallShading shading = ball_shading(bgr, CameraResponse::linear(), colored, rays, cone, outline);
  EXPECT_NEAR(shading_strength(bgr, CameraResponse::linear(), colored, rays, cone, outline), shading.strength,
              0.09);
  return shading;
}

TEST(BallShading, ExplainsASphereDullOrGlossyByItsNormals) {
  for (const Look& look : {Look(lambert), Look(glossy)}) {
    for (const int cut_px : {145, 160, 200}) {
      const BallShading sphere = shading_of(look, cut_px);
      EXPECT_GT(sphere.strength, 0.4) << cut_px;
      EXPECT_GT(sphere.explained, 0.96) << cut_px;
      EXPECT_GT(sphere.explained, sphere.explained_by_two) << cut_px;
    }
  }
}

TEST(BallShading, ExplainsItThroughNoiseToo) {
  for (const double noise : {0.0, 5.0, 10.0})
    EXPECT_GT(shading_of(lambert, 160, noise).explained, 0.95) << noise;
}

TEST(BallShading, AnEvenDiscHasNone) {
  for (const int cut_px : {145, 160, 200}) EXPECT_LT(shading_of(even, cut_px).strength, 0.1) << cut_px;
}

TEST(BallShading, ADiscOfTwoShadesIsBetterExplainedByTwo) {
  for (const int cut_px : {145, 160, 200}) {
    const BallShading disc = shading_of(two_shades, cut_px);
    EXPECT_GT(disc.strength, 0.4) << cut_px;
    EXPECT_LT(disc.explained, disc.explained_by_two) << cut_px;
  }
}

TEST(BallShading, ACloudyDiscIsNotExplained) {
  for (const int cut_px : {145, 160, 200}) EXPECT_LT(shading_of(cloudy, cut_px).explained, 0.95) << cut_px;
}

}  // namespace
}  // namespace ballservo
