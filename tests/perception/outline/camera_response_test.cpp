#include "perception/outline/camera_response.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calibration/base/random.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

TEST(CameraResponse, RisesFromDarkToWhiteWithItsSlope) {
  for (const CameraResponse* response : {&CameraResponse::linear(), &CameraResponse::srgb()}) {
    EXPECT_EQ(response->light[0], 0);
    EXPECT_NEAR(response->light[255], 255, 1e-3);
    for (std::size_t k = 1; k < 255; ++k) {
      const float difference = (response->light[k + 1] - response->light[k - 1]) / 2;
      EXPECT_NEAR(response->slope[k], difference, 0.01 * difference + 0.02) << k;
    }
    for (std::size_t k = 0; k < 256; ++k) {
      const GreyLevel shown = response->shown(static_cast<double>(response->light[k]));
      EXPECT_NEAR(shown.level, k, 0.015);
      EXPECT_NEAR(shown.slope / static_cast<double>(response->slope[k]), 1, k > 4 ? 0.1 : 0.5) << k;
    }
    EXPECT_NEAR(response->shown(-1).level, -1 / static_cast<double>(response->slope[0]), 0.01);
    EXPECT_GT(response->shown(270).level, 255);
    EXPECT_TRUE(std::isnan(response->shown(NAN).level));
  }
}

TEST(ResponseBelief, IsSrgbUntilTheEdgesSayOtherwise) {
  ResponseBelief belief;
  EXPECT_TRUE(belief.srgb());
  belief.add({-3, -5});
  EXPECT_TRUE(belief.srgb());
  belief.add({-1e9, -5});  // one picture, however loud, does not settle it
  EXPECT_FALSE(belief.srgb());
  EXPECT_TRUE(belief.open());
  belief.add({-20, -20});
  belief.add({-20, -20});
  EXPECT_FALSE(belief.open());
}

TEST(ResponseBelief, OfCoarseColoursSaysNothingOfTheResponse) {
  ResponseBelief belief;
  belief.add({-1e9, 8});
  EXPECT_TRUE(belief.coarse_chroma());
  EXPECT_TRUE(belief.srgb());
}

TEST(ResponseBelief, AsksNoLongerWhereNothingIsToldForLong) {
  ResponseBelief belief;
  for (int i = 0; i < 1000 && belief.open(); ++i) belief.add({i % 2 == 0 ? 1.0 : -1.0, 0});
  EXPECT_FALSE(belief.open());
}

TEST(ResponseBelief, GivesEveryResponseItsProbability) {
  for (const ResponseEvidence& evidence :
       {ResponseEvidence{0, 0}, {-2, -1}, {-6, -1}, {5, -8}, {0, 6}, {-20, 3}}) {
    ResponseBelief belief;
    belief.add(evidence);
    double others = 0;
    for (const auto& [response, probability] : belief.alternatives()) {
      EXPECT_GT(probability, 0);
      const bool is_believed = response->coarse_chroma == belief.coarse_chroma() &&
                               (response == &CameraResponse::srgb(belief.coarse_chroma())) == belief.srgb();
      EXPECT_FALSE(is_believed);
      others += probability;
    }
    EXPECT_LT(others, 2.0 / 3);  // none is likelier than the one that is believed
  }
  ResponseBelief undecided, settled;
  undecided.add({-3.5, -20});
  EXPECT_NEAR(undecided.alternatives()[0].probability, 0.5, 1e-6);
  settled.add({-20, -20});
  for (const auto& [response, probability] : settled.alternatives()) EXPECT_LT(probability, 1e-6);
}

// What a camera makes of this light.
cv::Mat taken(const cv::Mat& light, const CameraResponse& response, std::uint64_t seed, double noise = 2,
              double blur_px = 0.8) {
  RandomEngine engine = random_stream(seed, "camera_response_test");
  cv::Mat blurred, bgr(light.size(), CV_8UC3);
  light.convertTo(blurred, CV_32FC3);
  cv::GaussianBlur(blurred, blurred, {}, blur_px);
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      for (int c = 0; c < 3; ++c) {
        const float level = blurred.at<cv::Vec3f>(v, u)[c];
        const auto above = std::lower_bound(response.light.begin(), response.light.end(), level);
        const auto grey = static_cast<double>(above - response.light.begin());
        bgr.at<cv::Vec3b>(v, u)[c] = cv::saturate_cast<std::uint8_t>(grey + noise * standard_normal(engine));
      }
    }
  }
  return bgr;
}

double radius_error_px(const cv::Mat& bgr, ResponseChoice choice) {
  const Camera camera = test::pinhole({120, 120}, 500);
  DetectorOptions options;
  options.response = choice;
  Detector detector(std::make_shared<const RayTable>(camera), test::red_and_green(), options);
  const auto& balls = detector.detect(bgr);
  EXPECT_EQ(balls.size(), 1u);
  const auto truth = project_sphere(camera, {0.004, 0.002, 0.6}, 0.035);
  return balls.empty() ? NAN : balls[0].outline.radius_px - truth->radius_px;
}

/// A picture whose noise is a sensor's: it grows with the light, and grey levels are proportional to it.
cv::Mat sensed(const cv::Mat& light, std::uint64_t seed) {
  RandomEngine engine = random_stream(seed, "camera_response_test.sensed");
  cv::Mat blurred, bgr(light.size(), CV_8UC3);
  light.convertTo(blurred, CV_32FC3);
  cv::GaussianBlur(blurred, blurred, {}, 0.8);
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      const cv::Vec3f& lit = blurred.at<cv::Vec3f>(v, u);
      for (int c = 0; c < 3; ++c) {
        bgr.at<cv::Vec3b>(v, u)[c] =
            cv::saturate_cast<std::uint8_t>(lit[c] + std::sqrt(0.2 + 0.2 * lit[c]) * standard_normal(engine));
      }
    }
  }
  return bgr;
}

TEST(CameraResponse, IsToldByNoiseWhereTheEdgesOfABallLeaveItOpen) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    cv::Mat light(120, 120, CV_8UC3);
    light.forEach<cv::Vec3b>([](cv::Vec3b& pixel, const int* at) {
      const bool beside_ball = at[0] > 20 && at[0] < 100;
      pixel = beside_ball ? cv::Vec3b(40, 45, 120)
                          : cv::Vec3b::all(static_cast<std::uint8_t>(30 + 210 * at[1] / 120));
    });
    test::paint_ball(light, test::pinhole({120, 120}, 500), {0.004, 0.002, 0.6}, 0.035, {40, 45, 160});
    const cv::Mat bgr = sensed(light, seed);
    EXPECT_EQ(radius_error_px(bgr, ResponseChoice::by_picture), radius_error_px(bgr, ResponseChoice::linear));
  }
}

TEST(CameraResponse, IsToldByTheEdgesOfABall) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    cv::Mat light(120, 120, CV_8UC3, cv::Scalar(20.0 + 10 * static_cast<double>(seed), 50, 25));
    test::paint_ball(light, test::pinhole({120, 120}, 500), {0.004, 0.002, 0.6}, 0.035, {12, 15, 160});
    const cv::Mat linear = taken(light, CameraResponse::linear(), seed),
                  srgb = taken(light, CameraResponse::srgb(), seed);
    EXPECT_NEAR(radius_error_px(linear, ResponseChoice::by_picture), 0, 0.02);
    EXPECT_NEAR(radius_error_px(srgb, ResponseChoice::by_picture), 0, 0.02);
    // Taken for the other, it is not: the pictures can tell.
    EXPECT_GT(std::abs(radius_error_px(srgb, ResponseChoice::linear)), 0.05);
    EXPECT_GT(std::abs(radius_error_px(linear, ResponseChoice::srgb)), 0.05);
  }
}

// A still may be another camera's than the one before it.
TEST(CameraResponse, OfOneStillSaysNothingOfTheNext) {
  const Camera camera = test::pinhole({120, 120}, 500);
  cv::Mat light(120, 120, CV_8UC3, cv::Scalar(20, 50, 25));
  test::paint_ball(light, camera, {0.004, 0.002, 0.6}, 0.035, {12, 15, 160});
  const cv::Mat still = taken(light, CameraResponse::srgb(), 0, 20);  // so noisy that its edges say little
  const auto rays = std::make_shared<const RayTable>(camera);
  Detector alone(rays, test::red_and_green(), {});
  for (const CameraResponse* other : {&CameraResponse::linear(), &CameraResponse::srgb()}) {
    Detector after_another(rays, test::red_and_green(), {});
    for (std::uint64_t seed = 0; seed < 4; ++seed) after_another.detect(taken(light, *other, seed));
    after_another.forget_response();
    alone.forget_response();
    const auto& balls = after_another.detect(still);
    const auto& balls_alone = alone.detect(still);
    ASSERT_EQ(balls.size(), 1u);
    ASSERT_EQ(balls_alone.size(), 1u);
    EXPECT_EQ(balls[0].cone.alpha_rad, balls_alone[0].cone.alpha_rad);
    EXPECT_EQ(balls[0].cone_covariance_rad2, balls_alone[0].cone_covariance_rad2);
  }
}

// The light of a ball before bricks of these colours.
const Eigen::Vector3d before_bricks_p_C(0.004, 0.002, 0.6);
template <class Color>
cv::Mat ball_before_bricks(cv::Size brick, const cv::Vec3b& ball, RandomEngine& engine, const Color& color) {
  cv::Mat light(120, 120, CV_8UC3);
  for (int v = 0; v < light.rows; v += brick.height) {
    for (int u = 0; u < light.cols; u += brick.width)
      cv::rectangle(light, {{u, v}, brick}, color(engine), cv::FILLED);
  }
  test::paint_ball(light, test::pinhole({120, 120}, 500), before_bricks_p_C, 0.035, ball);
  return light;
}

// What an sRGB picture of that says of its camera.
template <class Color>
ResponseEvidence evidence_before_bricks(cv::Size brick, const cv::Vec3b& ball, std::uint64_t seed,
                                        const Color& color) {
  RandomEngine engine = random_stream(seed, "what is behind");
  const Camera camera = test::pinhole({120, 120}, 500);
  const Eigen::Vector3d& p_C = before_bricks_p_C;
  const CameraResponse& srgb = CameraResponse::srgb();
  const cv::Mat bgr = taken(ball_before_bricks(brick, ball, engine, color), srgb, seed, 1);
  BallFitter fitter(std::make_shared<const RayTable>(camera), 0);
  OutlineFit fit;
  EXPECT_TRUE(fitter.fit_sphere(bgr, srgb, {p_C.normalized(), std::asin(0.035 / p_C.norm())}, {}, fit));
  return fitter.response_evidence(bgr, srgb, fit.ball.cone);
}

// Edges of bricks, leaves and shadows cross the ball's, and are no part of the profile that is fitted.
TEST(CameraResponse, IsNotToldByWhatIsBehindTheBall) {
  int mistaken = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    ResponseBelief belief;
    belief.add(evidence_before_bricks({5, 4}, {12, 15, 160}, seed, [](RandomEngine& engine) {
      const double level = uniform01(engine) < 0.5 ? 30 : 220;
      return cv::Scalar(level, level, 0.9 * level);
    }));
    mistaken += belief.srgb() ? 0 : 1;
  }
  EXPECT_LE(mistaken, 1);
}

TEST(CameraResponse, IsAskedAgainWhereTheOtherOnePutsTheEdges) {
  for (const std::uint64_t seed : {58, 1403, 1597}) {  // where sRGB's own edges speak against it
    const ResponseEvidence evidence =
        evidence_before_bricks({14, 10}, {3, 4, 48}, seed, [](RandomEngine& engine) {
          const double blue = uniform(engine, 0, 18), green = uniform(engine, 0, 18);
          return cv::Scalar(blue, green, uniform(engine, 0, 18));
        });
    EXPECT_GT(evidence.srgb, -3) << "seed " << seed;
  }
}

// A wide blur before many colours may leave the camera open; the ball is then no better known than that.
TEST(CameraResponse, WhatTheEdgesLeaveOpenOfItIsInTheCovariance) {
  const Camera camera = test::pinhole({120, 120}, 500);
  const auto truth = TangentCone::of_sphere(before_bricks_p_C, 0.035);
  constexpr int pictures = 100;
  int found = 0, far_off = 0;
  double sum = 0, worst = 0;
  for (std::uint64_t seed = 0; seed < pictures; ++seed) {
    RandomEngine engine = random_stream(seed, "what is behind");
    const cv::Mat light = ball_before_bricks({14, 10}, {12, 15, 160}, engine, [](RandomEngine& any) {
      const double blue = uniform(any, 0, 120), green = uniform(any, 0, 120);
      return cv::Scalar(blue, green, uniform(any, 0, 60));
    });
    const cv::Mat bgr = taken(light, CameraResponse::linear(), seed, 2, 1.5);
    DetectorOptions options;
    options.radii = {{0.035}, {0.035}};
    Detector detector(std::make_shared<const RayTable>(camera), test::red_and_green(), options);
    for (const BallObservation& ball : detector.detect(bgr)) {
      if (angle_outside(ball.cone, truth->axis) > -0.5 * truth->alpha_rad) continue;  // a brick
      ++found;
      const double error_rad = ball.cone.alpha_rad - truth->alpha_rad;
      const double normalized = error_rad * error_rad / ball.cone_covariance_rad2(2, 2);
      far_off += 500 * std::abs(error_rad) > 0.3 ? 1 : 0;
      sum += normalized;
      const Eigen::Vector3d& p_C = ball.position->p_C;
      const Eigen::Vector3d sight = p_C.normalized();
      const double range_error_m = p_C.norm() - before_bricks_p_C.norm();
      worst = std::max({worst, normalized,
                        range_error_m * range_error_m / sight.dot(ball.position->covariance_m2 * sight)});
    }
  }
  EXPECT_EQ(found, pictures);
  EXPECT_LE(far_off, 4);
  EXPECT_LT(sum / found, 2);
  EXPECT_LT(worst, 16);
}

// As JPEG files (4:2:0) and videos keep it: colours averaged over 2x2 pixels.
cv::Mat with_coarse_chroma(const cv::Mat& bgr) {
  cv::Mat coded, restored;
  std::vector<cv::Mat> planes;
  cv::cvtColor(bgr, coded, cv::COLOR_BGR2YCrCb);
  cv::split(coded, planes);
  for (const std::size_t chroma : {1u, 2u}) {
    cv::Mat half;
    cv::resize(planes[chroma], half, bgr.size() / 2, 0, 0, cv::INTER_AREA);
    cv::resize(half, planes[chroma], bgr.size(), 0, 0, cv::INTER_LINEAR);
  }
  cv::merge(planes, coded);
  cv::cvtColor(coded, restored, cv::COLOR_YCrCb2BGR);
  return restored;
}

TEST(CameraResponse, ThatColoursAreCoarseMayBeKnown) {
  DetectorOptions options;
  options.coarse_chroma = true;
  Detector detector(std::make_shared<const RayTable>(test::pinhole({120, 120}, 500)), test::red_and_green(),
                    options);
  EXPECT_TRUE(detector.response().coarse_chroma);
  cv::Mat light(120, 120, CV_8UC3, cv::Scalar(20, 50, 25));  // shows sharp colours
  test::paint_ball(light, detector.rays().camera(), {0.004, 0.002, 0.6}, 0.035, {12, 15, 160});
  EXPECT_EQ(detector.detect(taken(light, CameraResponse::srgb(), 0)).size(), 1u);
  EXPECT_TRUE(detector.response().coarse_chroma);
  detector.forget_response();
  EXPECT_TRUE(detector.response().coarse_chroma);
}

// Red before a grey of its own luma, whose own level chroma does not tell.
TEST(CameraResponse, WhereLumaShowsNoEdgeChromaDoes) {
  DetectorOptions options;
  options.coarse_chroma = true;
  double sum_px = 0;
  constexpr int pictures = 8;
  for (std::uint64_t seed = 0; seed < pictures; ++seed) {
    cv::Mat light(120, 120, CV_8UC3, cv::Scalar::all(39));
    test::paint_disc(light, {60.2, 59.7}, 29, {12, 15, 160});
    Detector detector(std::make_shared<const RayTable>(long_lens_camera({120, 120})), test::red_and_green(),
                      options);
    const auto& balls = detector.detect(with_coarse_chroma(taken(light, CameraResponse::srgb(), seed)));
    ASSERT_EQ(balls.size(), 1u);
    sum_px += balls[0].outline.radius_px - 29;
  }
  EXPECT_NEAR(sum_px / pictures, 0, 0.1);
}

TEST(CameraResponse, WhereColoursAreCoarseTheEdgeIsThatOfLuma) {
  double sum_px = 0;
  constexpr int pictures = 8;
  for (std::uint64_t seed = 0; seed < pictures; ++seed) {
    cv::Mat light(120, 120, CV_8UC3, cv::Scalar(90.0 + 10 * static_cast<double>(seed), 100, 80));
    test::paint_ball(light, test::pinhole({120, 120}, 500), {0.004, 0.002, 0.6}, 0.035, {12, 15, 160});
    const cv::Mat coarse = with_coarse_chroma(taken(light, CameraResponse::srgb(), seed));
    const double error_px = radius_error_px(coarse, ResponseChoice::by_picture);
    EXPECT_NEAR(error_px, 0, 0.06);
    sum_px += error_px;
  }
  EXPECT_NEAR(sum_px / pictures, 0, 0.03);
}

}  // namespace
}  // namespace ballservo
