// When a calibration is refused or warned about, and what wrong corners, parts of boards and wide lenses do.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibration/base/fault.hpp"
#include "calibration/boards/board_calibration.hpp"
#include "calibration/boards/board_detector.hpp"
#include "calibration/boards/calibration_checks.hpp"
#include "calibration/boards/lens_choice.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "tests/calibration/board_examples.hpp"
#include "tests/calibration/camera_examples.hpp"

namespace ballservo {
namespace {

using test::camera_parameters;
using test::chessboard;
using test::only;
using test::random_views;
using testing::HasSubstr;
using testing::Not;

const CameraParameters barrel = camera_parameters(LensModel::brown, 533, {-0.28, 0.05, 1e-3, -5e-4, 0.09});

/// The refusal's words; empty where there is none.
std::string refusal_of(const std::vector<BoardView>& views, const std::vector<LensModel>& models) {
  try {
    calibrate_from_boards({640, 480}, views, models);
  } catch (const Refusal& refusal) {
    return refusal.what();
  }
  return "";
}

TEST(WrongCorners, AreSetAsideAndChangeNothing) {
  const Camera truth(barrel);
  auto views = random_views(truth, 12, 0.1, 21);
  const auto clean = calibrate_from_boards({640, 480}, views, only(LensModel::brown));
  views[3].corners_px[17] += Eigen::Vector2d(9, -4);
  views[7].corners_px[0] += Eigen::Vector2d(-3, 2);
  const auto result = calibrate_from_boards({640, 480}, views, only(LensModel::brown));
  EXPECT_TRUE(result.corners[3].set_aside[17]);
  EXPECT_TRUE(result.corners[7].set_aside[0]);
  std::ptrdiff_t aside = 0;
  for (const CornerResiduals& corners : result.corners)
    aside += std::count(corners.set_aside.begin(), corners.set_aside.end(), true);
  EXPECT_EQ(aside, 2);
  EXPECT_NEAR(result.rms_px, clean.rms_px, 0.002);
  const Eigen::VectorXd change =
      parameter_vector(result.camera.parameters()) - parameter_vector(clean.camera.parameters());
  for (Eigen::Index i = 0; i < change.size(); ++i)
    EXPECT_LT(std::abs(change(i)), 0.5 * std::sqrt(clean.covariance.parameters(i, i))) << i;
  EXPECT_EQ(result.warnings.size(), clean.warnings.size() + 2);
}

TEST(WrongCorners, ABlurredBoardKeepsItsCorners) {
  const Camera truth(barrel);
  auto views = random_views(truth, 12, 0.1, 22);
  RandomEngine engine = random_stream(22, "blur");
  for (Eigen::Vector2d& corner : views[5].corners_px)
    corner += 0.7 * Eigen::Vector2d(standard_normal(engine), standard_normal(engine));
  const auto result = calibrate_from_boards({640, 480}, views, only(LensModel::brown));
  EXPECT_EQ(std::count(result.corners[5].set_aside.begin(), result.corners[5].set_aside.end(), true), 0);
}

TEST(PartsOfBoards, GiveTheSameCamera) {
  const Camera truth(barrel);
  auto views = random_views(truth, 14, 0, 23);
  for (std::size_t v = 0; v < views.size(); v += 2) {
    // The lower half of the board, and named from its own first corner.
    BoardView part{views[v].name, {}, {}};
    for (std::size_t i = 27; i < 54; ++i) {
      part.points_m.push_back(views[v].points_m[i] - views[v].points_m[27]);
      part.corners_px.push_back(views[v].corners_px[i]);
    }
    views[v] = part;
  }
  const auto result = calibrate_from_boards({640, 480}, views, only(LensModel::brown));
  EXPECT_LT(result.rms_px, 1e-5);
  EXPECT_NEAR(result.camera.parameters().fx_px, 533, 1e-3);
}

TEST(PartsOfBoards, AreFoundInAPictureThatCutsTheBoardOff) {
  const Camera camera(barrel);
  test::PlacedBoard placed;
  placed.R_CB = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 1, 0).normalized()).toRotationMatrix();
  placed.p_CB = {-0.01, -0.06, 0.28};  // its right side lies outside
  RandomEngine engine = random_stream(0, "part");
  const cv::Mat picture = test::photographed(test::painted_chessboard(camera, chessboard, placed), 1, engine);
  const BoardFinding finding = find_board(picture, chessboard);
  ASSERT_TRUE(finding.view);
  EXPECT_LT(finding.view->size(), 54u);
  EXPECT_GE(finding.view->size(), 18u);
  // Whatever part it is, its points and corners are those of a flat board.
  const auto poses = board_poses({*finding.view}, barrel);
  ASSERT_TRUE(poses);
  const auto placed_part = adjust_poses({*finding.view}, barrel, *poses);
  ASSERT_TRUE(placed_part);
  EXPECT_LT(placed_part->rms_px, 0.25);
}

TEST(ChessboardSize, ALargerBoardIsSeen) {
  const Camera camera(barrel);
  test::PlacedBoard placed;
  placed.p_CB = {-0.1, -0.06, 0.4};
  RandomEngine engine = random_stream(0, "size");
  const cv::Mat picture = test::photographed(test::painted_chessboard(camera, chessboard, placed), 1, engine);
  EXPECT_EQ(find_board(picture, parse_board("chessboard:8x5", 0.025)).seen, std::make_pair(9, 6));
  EXPECT_EQ(find_board(picture, chessboard).seen, std::make_pair(9, 6));
}

TEST(Refusals, TwoCamerasAreTold) {
  CameraParameters other = barrel;
  other.fx_px += 25, other.fy_px += 25, other.cx_px -= 20, other.cy_px += 15, other.coefficients[0] += 0.04;
  auto views = random_views(Camera(barrel), 9, 0.15, 31);
  for (const BoardView& view : random_views(Camera(other), 6, 0.15, 32)) views.push_back(view);
  const std::string text = refusal_of(views, only(LensModel::brown));
  EXPECT_THAT(text, HasSubstr("two cameras"));
  EXPECT_THAT(text, HasSubstr("board 31.0"));
  EXPECT_THAT(text, HasSubstr("board 32.5"));
  for (const std::uint64_t seed : {41u, 42u, 43u, 44u})
    EXPECT_EQ(refusal_of(random_views(Camera(barrel), 14, 0.15, seed), only(LensModel::brown)), "") << seed;
}

TEST(Refusals, ALensWithRipplesIsNotTakenForTwo) {
  // Ripples of the size of the corners' noise and above, which no model has.
  for (const double ripple_px : {0.1, 0.3}) {
    for (const std::uint64_t seed : {61u, 62u}) {
      auto views = random_views(Camera(barrel), 14, 0.1, seed);
      for (BoardView& view : views)
        for (Eigen::Vector2d& corner : view.corners_px)
          corner += ripple_px * Eigen::Vector2d(std::sin(corner.y() / 25), std::sin(corner.x() / 30));
      EXPECT_THAT(refusal_of(views, only(LensModel::brown)), Not(HasSubstr("two cameras")))
          << ripple_px << " px, " << seed;
    }
  }
}

TEST(Refusals, ABentBoardIsNotTakenForTwoCameras) {
  // Bent by a millimetre over its half-length, 10 cm.
  for (const std::uint64_t seed : {71u, 72u}) {
    RandomEngine engine = random_stream(seed, "bent boards");
    const Camera camera(barrel);
    std::vector<BoardView> views;
    for (int i = 0; i < 14; ++i) {
      const auto placed = test::random_place(camera, chessboard, engine, 0.6, 0.15, 0.6, 12);
      BoardView view = test::noisy_view(camera, chessboard, placed, 0, engine, "board");
      for (std::size_t k = 0; k < view.size(); ++k) {
        const Eigen::Vector3d& point = view.points_m[k];
        const Eigen::Vector3d raised(point.x(), point.y(), 0.1 * std::pow(point.x() - 0.1, 2));
        view.corners_px[k] = *camera.project(placed.R_CB * raised + placed.p_CB) +
                             0.05 * Eigen::Vector2d(standard_normal(engine), standard_normal(engine));
      }
      views.push_back(view);
    }
    EXPECT_THAT(refusal_of(views, only(LensModel::brown)), Not(HasSubstr("two cameras"))) << seed;
  }
}

TEST(Refusals, APrincipalPointOutsideThePicture) {
  // As of a picture cut out of a larger one.
  CameraParameters cut = barrel;
  cut.cx_px = -10;
  EXPECT_THAT(refusal_of(random_views(Camera(cut), 30, 0.02, 81), only(LensModel::brown)),
              HasSubstr("principal point outside the picture (-"));
}

TEST(Refusals, SayWhetherAngleOrDistanceIsMissing) {
  const Camera camera(camera_parameters(LensModel::pinhole, 533, {}));
  // Parallel to the picture, near and far; then at one distance too.
  EXPECT_THAT(refusal_of(random_views(camera, 8, 0.1, 4, 1e-3), only(LensModel::pinhole)),
              HasSubstr("one angle, "));
  EXPECT_THAT(refusal_of(random_views(camera, 8, 0.1, 4, 1e-3, 0.5, 0.51), only(LensModel::pinhole)),
              HasSubstr("one angle and one distance"));
}

TEST(Refusals, AModelThatExplainsNothingOfTheLens) {
  const Camera fisheye(camera_parameters(LensModel::kannala_brandt, 236, {-0.02, 0.003, -0.001, 0.0001}));
  const auto views = random_views(fisheye, 14, 0.1, 51);
  const std::string text = refusal_of(views, {LensModel::pinhole, LensModel::visp});
  EXPECT_THAT(text, HasSubstr("does not explain"));
  EXPECT_THAT(text, HasSubstr("kannala_brandt"));
  // Named by the user it is a warning; and the right one raises none.
  const Camera bent(camera_parameters(LensModel::visp, 535, {0.33}));
  const auto named =
      calibrate_from_boards({640, 480}, random_views(bent, 14, 0.1, 52), only(LensModel::pinhole));
  ASSERT_FALSE(named.warnings.empty());
  EXPECT_THAT(named.warnings.front(), HasSubstr("the lens model pinhole does not explain"));
  const auto right = calibrate_from_boards({640, 480}, views, only(LensModel::kannala_brandt));
  for (const std::string& warning : right.warnings) EXPECT_THAT(warning, testing::Not(HasSubstr("explain")));
  EXPECT_LT(*right.structure_px, 0.05);
}

TEST(Trust, WhatDependsOnThePlaceInThePictureIsMeasured) {
  const Camera truth(barrel);
  auto views = random_views(truth, 20, 0.1, 60);
  const auto clean = fit_lens(views, truth.size(), LensModel::brown);
  EXPECT_LT(*residual_structure_px(views, *clean), 0.05);
  // Ripples that no lens has; the boards' poses and the lens take up a part of them.
  for (BoardView& view : views)
    for (Eigen::Vector2d& corner : view.corners_px) corner.x() += 2 * std::sin(corner.x() / 60);
  const auto rippled = fit_lens(views, truth.size(), LensModel::brown);
  EXPECT_GT(*residual_structure_px(views, *rippled), 0.15);
  EXPECT_LT(*residual_structure_px(views, *rippled), rippled->rms_px);
}

TEST(Trust, CornersThatErrTogetherWidenTheSigmas) {
  const Camera truth(barrel);
  auto views = random_views(truth, 14, 0.1, 63);
  const auto widening = [&] {
    const auto fit = fit_lens(views, truth.size(), LensModel::brown);
    const auto covariance = board_covariance(views, *fit);
    return std::sqrt(covariance->parameters(0, 0) / covariance->of_independent_corners(0, 0));
  };
  const double independent = widening();
  EXPECT_GE(independent, 1);
  EXPECT_LT(independent, 1.5);
  test::shear_views(views, truth.size(), 0.4, 63);
  EXPECT_GT(widening(), 1.5 * independent);
}

TEST(Trust, FocalLengthAndDistanceAreCorrelatedWhereBoardsStandSquarely) {
  const Camera truth(barrel);
  const auto flat =
      calibrate_from_boards({640, 480}, random_views(truth, 12, 0.1, 61, 0.15), only(LensModel::brown));
  const auto tilted =
      calibrate_from_boards({640, 480}, random_views(truth, 12, 0.1, 61, 0.9), only(LensModel::brown));
  EXPECT_GT(flat.covariance.focal_distance_correlation, tilted.covariance.focal_distance_correlation);
  EXPECT_GT(flat.covariance.focal_distance_correlation, 0.95);
  EXPECT_GT(flat.covariance.parameters(0, 0), 4 * tilted.covariance.parameters(0, 0));
  EXPECT_NEAR(tilted.covariance.noise_px, 0.1, 0.01);
}

TEST(Trust, CornersThatNoBoardReachedAreUncertainAndWarnedOf) {
  const Camera truth(barrel);
  auto views = random_views(truth, 60, 0.1, 62, 0.6, 0.3, 0.6);
  views.erase(std::remove_if(views.begin(), views.end(),
                             [](const BoardView& view) {
                               return std::any_of(view.corners_px.begin(), view.corners_px.end(),
                                                  [](const Eigen::Vector2d& p) { return p.x() > 330; });
                             }),
              views.end());
  ASSERT_GE(views.size(), 6u);
  const auto result = calibrate_from_boards({640, 480}, views, only(LensModel::brown));
  EXPECT_LT(result.coverage, 0.65);
  EXPECT_GT(*result.ball_sigma_mm, 1.2 * *result.covered_ball_sigma_mm);
  EXPECT_THAT(result.warnings, testing::Contains(HasSubstr("no board came nearer than")));
}

}  // namespace
}  // namespace ballservo
