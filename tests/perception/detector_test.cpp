#include "perception/detector.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/base/random.hpp"
#include "perception/outline/paper_refinement.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

const ImageSize size{320, 240};

TEST(Detector, PlacesAFlatBallToAMillimetre) {
  const Camera camera = test::pinhole(size, 400);
  for (const Eigen::Vector3d& p_C :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.2, -0.1, 0.8), Eigen::Vector3d(-0.3, 0.15, 1.1)}) {
    cv::Mat bgr = test::grey_picture();
    test::paint_ball(bgr, camera, p_C, 0.06, test::red);
    Detector detector = test::detector_for(camera, 0.06);
    const auto& balls = detector.detect(bgr);
    ASSERT_EQ(balls.size(), 1u);
    EXPECT_LT((balls[0].position->p_C - p_C).norm(), 1e-3);
    EXPECT_GT(balls[0].quality, 0.9);
    EXPECT_EQ(balls[0].color_class, 1);
    const auto outline = project_sphere(camera, p_C, 0.06);
    EXPECT_LT((balls[0].outline.center_px - outline->center_px).norm(), 0.03);
    EXPECT_NEAR(balls[0].outline.radius_px, outline->radius_px, 0.03);
    // The covariance must not call this impossible.
    const Eigen::Vector3d error = balls[0].position->p_C - p_C;
    EXPECT_LT(error.dot(balls[0].position->covariance_m2.inverse() * error), 16);
  }
}

TEST(Detector, ThePapersFitIsNearOnTheAxis) {
  const Camera camera = test::pinhole(size, 400);
  cv::Mat bgr = test::grey_picture();
  test::paint_ball(bgr, camera, {0, 0, 1}, 0.06, test::red);
  Detector detector = test::detector_for(camera, 0.06, BallFit::paper);
  const auto& balls = detector.detect(bgr);
  ASSERT_EQ(balls.size(), 1u);
  EXPECT_LT((balls[0].position->p_C - Eigen::Vector3d(0, 0, 1)).norm(), 0.02);
}

TEST(BallFitter, KnowsWhetherOneStepWasEnough) {
  const Camera camera = test::pinhole(size, 400);
  cv::Mat bgr = test::grey_picture();
  test::paint_ball(bgr, camera, {0, 0, 1}, 0.06, test::red);  // 24 px
  BallFitter fitter(std::make_shared<const RayTable>(camera));
  OutlineFit fit;
  const UndistortedCircle near{{0.2, -0.1}, 24}, far{{5, -4}, 24};
  const auto expect_enough = [&](bool enough) {
    EXPECT_EQ(fit.ball.one_step_enough, enough);
    EXPECT_EQ(fit.ball.next_step_px <= enough_next_step_px, enough);
  };
  const TangentCone cone = *cone_near_circle(near, camera.focal_px());
  ASSERT_TRUE(fitter.fit_sphere(bgr, CameraResponse::linear(), cone, {}, fit));
  expect_enough(true);
  ASSERT_TRUE(fitter.fit_circle(bgr, near, {}, fit));
  expect_enough(true);
  ASSERT_TRUE(fitter.fit_circle(bgr, far, {}, fit));
  expect_enough(false);
}

// Its edges are seen 3 px to either side: as far as the first steps lead, the next ones see more of them.
TEST(BallFitter, AFarStartGetsThereInMoreSteps) {
  const Camera camera = test::pinhole(size, 400);
  cv::Mat bgr = test::grey_picture();
  test::paint_ball(bgr, camera, {0, 0, 1}, 0.06, test::red);  // 24 px
  BallFitter fitter(std::make_shared<const RayTable>(camera));
  OutlineFit fit;
  const TangentCone start = *cone_near_circle({{4, 4}, 19.5}, camera.focal_px());
  ASSERT_TRUE(fitter.fit_sphere(bgr, CameraResponse::linear(), start, {}, fit));
  EXPECT_LT((fit.ball.outline.center_px - *camera.project({0, 0, 1})).norm(), 0.05);
  EXPECT_GT(fit.passes, 2);
}

TEST(Detector, WorksInTwoDimensionsWithoutACamera) {
  cv::Mat bgr = test::grey_picture();
  test::paint_disc(bgr, {101.3, 88.6}, 20, test::green);
  test::paint_disc(bgr, {240.5, 150.2}, 7, test::red);
  Detector detector = test::detector_for(long_lens_camera(size));
  const auto& balls = detector.detect(bgr);
  ASSERT_EQ(balls.size(), 2u);
  for (const BallObservation& ball : balls) {
    const bool is_green = ball.color_class == 2;
    EXPECT_LT(
        (ball.outline.center_px - (is_green ? Eigen::Vector2d(101.3, 88.6) : Eigen::Vector2d(240.5, 150.2)))
            .norm(),
        0.05);
    EXPECT_NEAR(ball.outline.radius_px, is_green ? 20 : 7, 0.05);
    EXPECT_FALSE(ball.position);
  }
}

TEST(Detector, SeparatesBallsThatTouch) {
  cv::Mat bgr = test::grey_picture();
  test::paint_disc(bgr, {120, 120}, 28, test::red);
  test::paint_disc(bgr, {170, 120}, 24, test::red);
  Detector detector = test::detector_for(long_lens_camera(size));
  const auto& balls = detector.detect(bgr);
  ASSERT_EQ(balls.size(), 2u);
  for (const BallObservation& ball : balls) {
    const Eigen::Vector2d truth =
        ball.outline.center_px.x() < 145 ? Eigen::Vector2d(120, 120) : Eigen::Vector2d(170, 120);
    EXPECT_LT((ball.outline.center_px - truth).norm(), 0.3);
  }
}

TEST(BallObservation, IsOneBallWhateverItsClassWhereItIsAsLarge) {
  const auto ball = [](int color_class, double aside, double alpha_rad) {
    BallObservation seen;
    seen.color_class = static_cast<ClassIndex>(color_class);
    seen.cone = {Eigen::Vector3d(aside, 0, 1).normalized(), alpha_rad};
    return seen;
  };
  const BallObservation red = ball(1, 0, 0.1);
  EXPECT_TRUE(same_ball(red, ball(1, 0.06, 0.1)));
  EXPECT_TRUE(same_ball(red, ball(1, 0, 0.05)));
  EXPECT_TRUE(same_ball(red, ball(2, 0.01, 0.095)));
  EXPECT_FALSE(same_ball(red, ball(2, 0.06, 0.1))) << "half behind it";
  EXPECT_FALSE(same_ball(red, ball(2, 0, 0.05))) << "before it";
}

TEST(Detector, FindsAHalfHiddenBall) {
  cv::Mat bgr = test::grey_picture();
  test::paint_shaded_disc(bgr, {160, 120}, 30, test::red);
  cv::rectangle(bgr, {160, 60}, {230, 180}, cv::Scalar(90, 100, 95), cv::FILLED);
  Detector detector = test::detector_for(long_lens_camera(size));
  const auto& balls = detector.detect(bgr);
  ASSERT_EQ(balls.size(), 1u);
  EXPECT_LT((balls[0].outline.center_px - Eigen::Vector2d(160, 120)).norm(), 1);
  EXPECT_NEAR(balls[0].outline.radius_px, 30, 1);
}

TEST(Detector, HalfAFlatDiscIsNoBall) {
  cv::Mat bgr = test::grey_picture();
  test::paint_disc(bgr, {160, 120}, 30, test::red);
  cv::rectangle(bgr, {160, 60}, {230, 180}, cv::Scalar(90, 100, 95), cv::FILLED);
  Detector detector = test::detector_for(long_lens_camera(size));
  EXPECT_TRUE(detector.detect(bgr).empty());
}

TEST(Detector, HalfAShadedDiscBeforeOneGroundIsNoBall) {
  cv::Mat bgr = test::grey_picture();
  test::paint_shaded_disc(bgr, {160, 120}, 30, test::red);
  cv::Mat(bgr, {160, 60, 70, 120}).setTo(test::grey);
  Detector detector = test::detector_for(long_lens_camera(size));
  EXPECT_TRUE(detector.detect(bgr).empty());
  EXPECT_TRUE(detector.detect_thoroughly(bgr).empty());
}

// It grows darker to one side, as a ball may, but has stripes across.
TEST(Detector, HalfAStripedDiscIsNoBall) {
  cv::Mat bgr = test::grey_picture();
  for (int v = 90; v <= 150; ++v) {
    for (int u = 130; u < 160; ++u) {
      const Eigen::Vector2d n(u / 30.0 - 160 / 30.0, v / 30.0 - 4);
      if (n.norm() <= 1)
        bgr.at<cv::Vec3b>(v, u) = test::red * (0.9 + 0.4 * n.x() + 0.05 * std::sin(7 * n.y()));
    }
  }
  cv::rectangle(bgr, {160, 60}, {230, 180}, cv::Scalar(90, 100, 95), cv::FILLED);
  cv::GaussianBlur(bgr, bgr, {}, 0.7);
  Detector detector = test::detector_for(long_lens_camera(size));
  EXPECT_TRUE(detector.detect(bgr).empty());
}

TEST(Detector, AScrapOfFewPixelsIsNoBall) {
  Detector detector = test::detector_for(long_lens_camera(size));
  std::size_t found = 0;
  for (double width_px = 6; width_px < 9; width_px += 0.5) {
    for (double turn_rad = 0; turn_rad < 1.5; turn_rad += 0.15) {
      cv::Mat bgr = test::grey_picture();
      test::paint(bgr, test::red, [&](const Eigen::Vector2d& p) {
        const Eigen::Vector2d q = Eigen::Rotation2Dd(turn_rad) * (p - Eigen::Vector2d(160, 110));
        return (q.array() > 0).all() && (q.array() < 25).all() && (q.array() < width_px).any();
      });
      cv::GaussianBlur(bgr, bgr, {}, 0.7);
      // Where a ball is expected, its pixels are not looked at again.
      found += detector.detect(bgr, {}, nullptr, 0.99 * min_ball_quality).size();
    }
  }
  EXPECT_EQ(found, 0u);
}

// A wall's pattern holds hundreds of small squares; some circle fits into each.
TEST(Detector, SmallFlatSquaresAreHardlyEverBalls) {
  const auto rays = std::make_shared<const RayTable>(long_lens_camera(size));
  Detector detector(rays, test::red_and_green(), {});
  std::size_t found = 0, found_where_expected = 0;
  for (double half_px = 3.5; half_px < 8; half_px += 0.5) {
    for (double turn_rad = 0; turn_rad < 1.5; turn_rad += 0.25) {
      cv::Mat bgr = test::grey_picture();
      test::paint(bgr, 0.5 * test::red, [&](const Eigen::Vector2d& p) {
        return (Eigen::Rotation2Dd(turn_rad) * (p - Eigen::Vector2d(160, 110))).cwiseAbs().maxCoeff() <
               half_px;
      });
      cv::GaussianBlur(bgr, bgr, {}, 0.7);
      found += detector.detect(bgr).size();
      found_where_expected += detector.detect(bgr, {}, nullptr, 0.99 * min_ball_quality).size();
    }
  }
  EXPECT_GE(found_where_expected, 20u);  // there is no second look there
  EXPECT_LT(4 * found, found_where_expected);
  for (double radius_px = 4; radius_px < 12; ++radius_px) {
    cv::Mat bgr = test::grey_picture();
    test::paint_shaded_disc(bgr, {160, 110}, radius_px, test::red);
    cv::GaussianBlur(bgr, bgr, {}, 0.7);
    EXPECT_EQ(detector.detect(bgr).size(), 1u) << radius_px;
  }
}

// A wallpaper's hexagons: nearly round, and all alike.
TEST(Detector, HexagonsOfAWallAreNoBalls) {
  Detector detector(std::make_shared<const RayTable>(long_lens_camera(size)), test::red_and_green(), {});
  std::size_t found = 0, found_where_expected = 0;
  for (const double blur_px : {0.7, 1.5}) {
    for (const double turn_rad : {0.0, 0.2, 0.5}) {
      for (const double inner_px : {14.0, 18.0, 22.0}) {
        cv::Mat bgr = test::grey_picture();
        test::paint(bgr, 0.5 * test::red, [&](const Eigen::Vector2d& p) {
          const double apart_px = 2.6 * inner_px;
          Eigen::Vector2d q = Eigen::Rotation2Dd(turn_rad) * p;
          for (double& x : q) x -= apart_px * std::round(x / apart_px);
          return std::max({std::abs(q.x()), std::abs(0.5 * q.x() + std::sqrt(0.75) * q.y()),
                           std::abs(0.5 * q.x() - std::sqrt(0.75) * q.y())}) < inner_px;
        });
        cv::GaussianBlur(bgr, bgr, {}, blur_px);
        found += detector.detect(bgr).size();
        found_where_expected += detector.detect(bgr, {{0, 0}, bgr.size()}).size();
      }
    }
  }
  EXPECT_GE(found_where_expected, 9u);  // larger ones are not looked at again there
  EXPECT_LT(4 * found, found_where_expected);
}

// A ball, or a flat disc in its place, spoilt and then hidden by a sheet from `shown` radii right of its
// centre on.
template <typename Spoil>
cv::Mat half_behind_a_sheet(bool is_ball, const Eigen::Vector2d& center_px, double radius_px, double shown,
                            const Spoil& spoil) {
  cv::Mat bgr = test::grey_picture();
  if (is_ball)
    test::paint_shaded_disc(bgr, center_px, radius_px, test::red);
  else
    test::paint_disc(bgr, center_px, radius_px, test::red);
  spoil(bgr);
  test::paint(bgr, {60, 90, 80}, [&](const Eigen::Vector2d& p) {
    return p.x() > center_px.x() + shown * radius_px && p.x() < 280 && std::abs(p.y() - 120) < 90;
  });
  cv::GaussianBlur(bgr, bgr, {}, 0.7);
  return bgr;
}

// A ball with a line across it, half behind a sheet; and half a flat disc with such a line, which is none.
TEST(Detector, ASecondLookDecidesWhereNothingElseIsABall) {
  Detector detector(std::make_shared<const RayTable>(test::pinhole(size, 400)), test::red_and_green(), {});
  const Eigen::Vector2d center_px(160, 120);
  for (const double radius_px : {20.0, 30.0, 40.0}) {
    for (const double shown : {-0.1, 0.0}) {
      for (const bool is_ball : {true, false}) {
        const cv::Mat bgr = half_behind_a_sheet(is_ball, center_px, radius_px, shown, [&](cv::Mat& picture) {
          test::paint(picture, {30, 30, 40}, [&](const Eigen::Vector2d& p) {
            const Eigen::Vector2d q = (p - center_px) / radius_px;
            return q.norm() < 1 && std::abs((q - Eigen::Vector2d(-1.2, -0.5)).norm() - 0.8) < 0.04;
          });
        });
        EXPECT_TRUE(detector.detect(bgr).empty());
        const auto& balls = detector.detect_thoroughly(bgr);
        ASSERT_EQ(balls.size(), is_ball ? 1u : 0u) << radius_px << " px, " << shown;
        if (!is_ball) continue;
        EXPECT_NEAR((balls[0].outline.center_px - center_px).norm(), 0, 0.1);
        EXPECT_NEAR(balls[0].outline.radius_px, radius_px, 0.1);
      }
    }
  }
}

// Its edges tell the camera's response as those of any other: the picture is linear.
TEST(Detector, ABallThatOnlyAThoroughLookFindsTellsTheResponse) {
  Detector detector(std::make_shared<const RayTable>(test::pinhole(size, 400)), test::red_and_green(), {});
  const Eigen::Vector2d center_px(160, 120);
  for (const double radius_px : {20.0, 30.0}) {
    detector.forget_response();
    cv::Mat bgr = half_behind_a_sheet(true, center_px, radius_px, 0, [&](cv::Mat& picture) {
      test::paint(picture, {14, 14, 30}, [&](const Eigen::Vector2d& p) {
        const Eigen::Vector2d q = (p - center_px) / radius_px;
        return q.norm() > 1 || std::abs((q - Eigen::Vector2d(-1.2, -0.5)).norm() - 0.8) < 0.04;
      });
    });
    cv::GaussianBlur(bgr, bgr, {}, 1.2);
    EXPECT_TRUE(detector.detect(bgr).empty());
    const auto& balls = detector.detect_thoroughly(bgr);
    ASSERT_EQ(balls.size(), 1u);
    EXPECT_NEAR(balls[0].outline.radius_px, radius_px, 0.3);
  }
}

// Small balls of a linear picture say that it is one; but they may be leaves, where a large ball is sRGB's.
TEST(Detector, SmallBallsBesideALargeOneDoNotTellTheResponse) {
  Detector detector(std::make_shared<const RayTable>(test::pinhole(size, 400)), test::red_and_green(), {});
  const CameraResponse& srgb = detector.response();
  cv::Mat bgr(size.height_px, size.width_px, CV_8UC3, cv::Scalar(70, 70, 70));
  for (int k = 0; k < 15; ++k)
    test::paint_shaded_disc(bgr, {25.0 + 30 * (k % 8), 195.0 + 25 * (k / 8)}, 7, test::red);
  cv::GaussianBlur(bgr, bgr, {}, 1.2);
  EXPECT_GE(detector.detect(bgr).size(), 8u);
  EXPECT_NE(&detector.response(), &srgb);

  cv::Mat covered(size.height_px, size.width_px, CV_8UC3, cv::Scalar::all(0));
  test::paint_disc(covered, {160, 90}, 20, {255, 255, 255});
  cv::GaussianBlur(covered, covered, {}, 1.2);
  bgr.forEach<cv::Vec3b>([&](cv::Vec3b& pixel, const int* at) {
    const double part = covered.at<cv::Vec3b>(at[0], at[1])[0] / 255.0;
    const cv::Vec3b ball(20, 20, 70);
    if (part <= 0) return;
    for (int c = 0; c < 3; ++c)
      pixel[c] = cv::saturate_cast<std::uint8_t>(
          srgb.shown((1 - part) * srgb.light[pixel[c]] + part * srgb.light[ball[c]]).level);
  });
  detector.forget_response();
  EXPECT_GE(detector.detect(bgr).size(), 9u);
  EXPECT_EQ(&detector.response(), &srgb);
}

// A blotched ball half behind a sheet: its shading is no clean sphere's, but what is seen of its outline is a
// circle's, behind an edge that goes on. A blotched disc there is none.
TEST(Detector, HalfABlotchedBallIsSeenByItsArc) {
  Detector detector(std::make_shared<const RayTable>(test::pinhole(size, 400)), test::red_and_green(), {});
  const Eigen::Vector2d center_px(160, 120);
  for (const double radius_px : {24.0, 28.0, 32.0}) {
    for (const bool is_ball : {true, false}) {
      const cv::Mat bgr = half_behind_a_sheet(is_ball, center_px, radius_px, -0.1, [&](cv::Mat& picture) {
        picture.forEach<cv::Vec3b>([&](cv::Vec3b& pixel, const int* at) {
          const Eigen::Vector2d q = (Eigen::Vector2d(at[1], at[0]) - center_px) / radius_px;
          if (q.norm() < 0.99 && std::sin(9 * q.x()) * std::sin(11 * q.y() + 1) > 0.3) pixel *= 0.45;
        });
      });
      EXPECT_TRUE(detector.detect(bgr).empty());
      const auto& balls = detector.detect_thoroughly(bgr);
      ASSERT_EQ(balls.size(), is_ball ? 1u : 0u) << radius_px << " px";
      if (!is_ball) continue;
      EXPECT_NEAR((balls[0].outline.center_px - center_px).norm(), 0, 0.02 * radius_px);
    }
  }
}

// As JPEG and video compress: colours at half the size, cosine waves in steps of their lengths.
void compress(cv::Mat& bgr, double step) {
  cv::Mat planes;
  cv::cvtColor(bgr, planes, cv::COLOR_BGR2YCrCb);
  std::vector<cv::Mat> channels;
  cv::split(planes, channels);
  for (int k = 0; k < 3; ++k) {
    const double scale = k == 0 ? 1 : 0.5;
    cv::Mat coarse;
    cv::resize(channels[k], coarse, {}, scale, scale, cv::INTER_AREA);
    coarse.convertTo(coarse, CV_32F);
    for (int v = 0; v + 8 <= coarse.rows; v += 8) {
      for (int u = 0; u + 8 <= coarse.cols; u += 8) {
        cv::Mat block = coarse(cv::Rect(u, v, 8, 8));
        cv::dct(block, block);
        block.forEach<float>([&](float& wave, const int* at) {
          const auto unit = static_cast<float>(step * (1 + 0.5 * (at[0] + at[1])));
          wave = unit * std::round(wave / unit);
        });
        cv::dct(block, block, cv::DCT_INVERSE);
      }
    }
    coarse.convertTo(coarse, CV_8U);
    cv::resize(coarse, channels[k], bgr.size());
  }
  cv::merge(channels, planes);
  cv::cvtColor(planes, bgr, cv::COLOR_YCrCb2BGR);
}

// Of 80 dull pixels, much compressed, the outline says too little. Nor do squares of that size become balls.
TEST(Detector, ASmallBallIsSeenByItsPixels) {
  Detector detector(std::make_shared<const RayTable>(long_lens_camera(size)), test::red_and_green(), {});
  const cv::Vec3b dull = 0.7 * test::red + 0.3 * test::grey;
  const cv::Rect window(120, 80, 80, 70);
  int at_once = 0, thoroughly = 0;
  for (int k = 0; k < 16; ++k) {
    const Eigen::Vector2d center_px(160 + 2 * (k % 4), 110 + 2 * (k / 4));
    for (const bool is_ball : {true, false}) {
      cv::Mat bgr = test::grey_picture();
      if (is_ball)
        test::paint_shaded_disc(bgr, center_px, 5, dull);
      else
        test::paint(bgr, dull, [&](const auto& p) { return (p - center_px).cwiseAbs().maxCoeff() < 4.5; });
      cv::GaussianBlur(bgr, bgr, {}, 0.7);
      compress(bgr, 6);
      if (is_ball) at_once += static_cast<int>(detector.detect(bgr).size());
      detector.detect(bgr, {400, 0, 50, 50});
      EXPECT_TRUE(detector.detect_thoroughly(bgr).empty()) << "nothing lies outside the picture";
      detector.detect(bgr, window);
      const auto& balls = detector.detect_thoroughly(bgr);
      ASSERT_LE(balls.size(), is_ball ? 1u : 0u);
      for (const BallObservation& ball : balls) {
        ++thoroughly;
        EXPECT_LT((ball.outline.center_px - center_px).norm(), 0.6);
        EXPECT_NEAR(ball.outline.radius_px, 5, 0.8);
        EXPECT_GE(ball.quality, min_ball_quality);
      }
    }
  }
  EXPECT_LE(at_once, 10);
  EXPECT_GE(thoroughly, 15);
}

// Dots of a wallpaper, leaves far off: the smaller, the more there are.
TEST(Detector, TheSmallerTheSurerMustASecondLookBe) {
  Detector detector(std::make_shared<const RayTable>(long_lens_camera(size)), test::red_and_green(), {});
  for (const double radius_px : {4.5, 5.0, 5.5, 9.0, 10.0, 11.0}) {
    for (const double off_px : {0.0, 0.3, 0.6}) {
      cv::Mat bgr = test::grey_picture();
      test::paint_disc(bgr, {160 + off_px, 110}, radius_px, 0.6 * test::red + 0.4 * test::grey);
      cv::GaussianBlur(bgr, bgr, {}, 0.7);
      EXPECT_EQ(detector.detect(bgr).size(), radius_px > 6 ? 1u : 0u) << radius_px;
    }
  }
}

// What may be a small ball where it is alone is hardly one among hundreds of its colour and size.
TEST(Detector, AmongLeavesLessIsABall) {
  Detector detector(std::make_shared<const RayTable>(long_lens_camera(size)), test::red_and_green(), {});
  std::size_t alone = 0, among = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    RandomEngine engine = random_stream(seed, "leaves");
    const auto paint_leaf = [&](cv::Mat& bgr, const Eigen::Vector2d& center_px) {
      const Eigen::Rotation2Dd turn(uniform(engine, 0, 3));
      const double length_px = uniform(engine, 4, 5), width_px = uniform(engine, 0.8, 1) * length_px;
      test::paint(bgr, 0.6 * test::red, [&](const Eigen::Vector2d& p) {
        const Eigen::Vector2d q = turn * (p - center_px);
        return std::hypot(q.x() / length_px, q.y() / width_px) < 1;
      });
    };
    cv::Mat one = test::grey_picture();
    paint_leaf(one, {160, 110});
    cv::Mat many = one.clone();
    for (int v = 12; v < 230; v += 24)
      for (int u = 12; u < 310; u += 24)
        cv::ellipse(many, cv::Point(u, v), cv::Size(5, 3), uniform(engine, 0, 180), 0, 360,
                    cv::Scalar(0.6 * test::red), cv::FILLED);
    cv::Mat leaf = one(cv::Rect(148, 98, 24, 24));
    leaf.copyTo(many(cv::Rect(148, 98, 24, 24)));
    const auto is_at_the_leaf = [&](const cv::Mat& bgr) {
      cv::Mat blurred;
      cv::GaussianBlur(bgr, blurred, {}, 0.7);
      const auto& balls = detector.detect(blurred);
      return std::any_of(balls.begin(), balls.end(), [](const BallObservation& ball) {
        return (ball.outline.center_px - Eigen::Vector2d(160, 110)).norm() < 3;
      });
    };
    alone += is_at_the_leaf(one);
    among += is_at_the_leaf(many);
  }
  EXPECT_GE(alone, 8u);
  EXPECT_LT(2 * among, alone);
}

TEST(Detector, DoesNotTakeBoxesForBalls) {
  for (const double half_px : {10.0, 15.0, 25.0, 45.0}) {
    for (const double shape : {0.7, 1.0}) {
      for (const double turn_rad : {0.0, 0.3, 0.785}) {
        cv::Mat bgr = test::grey_picture();
        const Eigen::Vector2d along(std::cos(turn_rad), std::sin(turn_rad)), across(-along.y(), along.x());
        test::paint(bgr, test::red, [&](const Eigen::Vector2d& p) {
          const Eigen::Vector2d q = p - Eigen::Vector2d(160, 120);
          return std::abs(q.dot(along)) < half_px && std::abs(q.dot(across)) < shape * half_px;
        });
        cv::GaussianBlur(bgr, bgr, {}, 0.7);
        Detector detector = test::detector_for(long_lens_camera(size));
        EXPECT_TRUE(detector.detect(bgr).empty())
            << "half a side " << half_px << " px, sides " << shape << ", turned " << turn_rad;
      }
    }
  }
}

TEST(Detector, FindsABallOfEightPixels) {
  cv::Mat bgr = test::grey_picture();
  test::paint_disc(bgr, {160.3, 119.6}, 4, test::red);
  cv::GaussianBlur(bgr, bgr, {}, 0.7);
  Detector detector = test::detector_for(long_lens_camera(size));
  const auto& balls = detector.detect(bgr);
  ASSERT_EQ(balls.size(), 1u);
  EXPECT_LT((balls[0].outline.center_px - Eigen::Vector2d(160.3, 119.6)).norm(), 0.1);
  EXPECT_NEAR(balls[0].outline.radius_px, 4, 0.15);
}

TEST(Detector, DoesNotTakeBarsForBalls) {
  cv::Mat bgr = test::grey_picture();
  cv::rectangle(bgr, {40, 60}, {200, 90}, cv::Scalar(40, 40, 210), cv::FILLED);
  cv::rectangle(bgr, {230, 20}, {250, 200}, cv::Scalar(60, 200, 50), cv::FILLED);
  cv::rectangle(bgr, {60, 130}, {150, 220}, cv::Scalar(40, 40, 210), cv::FILLED);
  Detector detector = test::detector_for(long_lens_camera(size));
  EXPECT_TRUE(detector.detect(bgr).empty());
}

TEST(Detector, MovesWithThePicture) {
  const auto find = [](double shift) {
    cv::Mat bgr = test::grey_picture();
    test::paint_disc(bgr, {100.25 + shift, 90.5}, 18, test::red);
    Detector detector = test::detector_for(long_lens_camera(size));
    return detector.detect(bgr).at(0).outline;
  };
  const OutlineEllipse before = find(0), after = find(31);
  EXPECT_NEAR(after.center_px.x() - before.center_px.x(), 31, 0.01);
  EXPECT_NEAR(after.center_px.y(), before.center_px.y(), 0.01);
  EXPECT_NEAR(after.radius_px, before.radius_px, 0.01);
}

TEST(Detector, AWindowSeesTheSameBall) {
  cv::Mat bgr = test::grey_picture();
  test::paint_disc(bgr, {160, 120}, 22, test::red);
  Detector detector = test::detector_for(long_lens_camera(size));
  const OutlineEllipse whole = detector.detect(bgr).at(0).outline;
  const OutlineEllipse part = detector.detect(bgr, {110, 70, 100, 100}).at(0).outline;
  EXPECT_LT((whole.center_px - part.center_px).norm(), 0.01);
  EXPECT_TRUE(detector.detect(bgr, {0, 0, 60, 60}).empty());
  EXPECT_TRUE(detector.detect(bgr, {-50, -50, 10, 10}).empty());
}

TEST(Detector, SurvivesNoiseBlackWhiteAndTinyPictures) {
  auto engine = random_stream(9, "detector_test");
  Detector detector = test::detector_for(long_lens_camera(size));
  cv::Mat noise(240, 320, CV_8UC3);
  for (int trial = 0; trial < 5; ++trial) {
    for (int i = 0; i < 240 * 320; ++i) {
      for (int c = 0; c < 3; ++c)
        noise.at<cv::Vec3b>(i)[c] = static_cast<std::uint8_t>(uniform_index(engine, 256));
    }
    EXPECT_TRUE(detector.detect(noise).empty());
  }
  EXPECT_TRUE(detector.detect(cv::Mat(240, 320, CV_8UC3, cv::Scalar(0, 0, 0))).empty());
  EXPECT_TRUE(detector.detect(cv::Mat(240, 320, CV_8UC3, cv::Scalar(40, 40, 210))).empty());
  for (const ImageSize tiny : {ImageSize{1, 1}, ImageSize{3, 2}, ImageSize{8, 8}}) {
    Detector small = test::detector_for(long_lens_camera(tiny));
    EXPECT_TRUE(
        small.detect(cv::Mat(tiny.height_px, tiny.width_px, CV_8UC3, cv::Scalar(40, 40, 210))).empty());
  }
}

TEST(Detector, RefusesAPictureOfAnotherSize) {
  Detector detector = test::detector_for(long_lens_camera(size));
  EXPECT_THROW(detector.detect(test::grey_picture(100, 100)), InputError);
}

TEST(DetectorOptions, NameEveryFault) {
  DetectorOptions options;
  options.oval_fraction = std::nan("");
  options.threads = DetectorOptions::most_threads + 1;
  options.radii = {{-1, 0}};
  try {
    options.validate();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().size(), 3u);
  }
}

}  // namespace
}  // namespace ballservo
