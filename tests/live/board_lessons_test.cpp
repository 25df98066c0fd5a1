// Which pictures of a board are taken, what camera they give, and where the next is asked for.
#include "app/live/board_lessons.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "calibration/base/fault.hpp"
#include "tests/calibration/board_examples.hpp"

namespace ballservo {
namespace {

using Seen = BoardLessons::Seen;
using testing::HasSubstr;
using testing::Not;

constexpr ImageSize picture_size{640, 480};

Camera some_camera() {
  CameraParameters parameters;
  parameters.model = LensModel::brown;
  parameters.size = picture_size;
  parameters.fx_px = parameters.fy_px = 530;
  parameters.cx_px = 330;
  parameters.cy_px = 235;
  parameters.coefficients[0] = -0.25;
  parameters.coefficients[1] = 0.08;
  return Camera(parameters);
}

BoardFinding found(const BoardView& view, double shift_px = 0) {
  BoardFinding finding{view, "", {}};
  for (Eigen::Vector2d& corner : finding.view->corners_px) corner.x() += shift_px;
  return finding;
}

class BoardLessonsTest : public testing::Test {
 protected:
  Seen look(const BoardFinding& finding, double after_s = 0.1) {
    return lessons.look(finding, picture_size, time_s += after_s);
  }
  /// The board is held there for so many pictures, a tenth of a second apart; what came of the last.
  Seen hold(const BoardView& view, int pictures = 8) {
    Seen seen = Seen::nothing;
    for (int i = 0; i < pictures; ++i) {
      seen = look(found(view, 0.1 * (i % 2)));
      if (seen == Seen::taken) return seen;
    }
    return seen;
  }

  BoardLessons lessons{"chessboard:9x6", 0.025};
  std::vector<BoardView> views = test::random_views(some_camera(), 12, 0.05, 3);
  double time_s = 0;
};

TEST_F(BoardLessonsTest, OnlyABoardThatIsHeldStillIsTaken) {
  for (int i = 0; i < 30; ++i) EXPECT_EQ(look(found(views[0], 1.5 * i)), Seen::moving);
  EXPECT_THAT(lessons.words(), HasSubstr("still"));
  EXPECT_EQ(hold(views[1], 5), Seen::moving) << "0.4 s";
  EXPECT_EQ(look(found(views[1])), Seen::taken);
  ASSERT_EQ(lessons.taken().size(), 1u);
  EXPECT_EQ(lessons.taken()[0].corners_px, views[1].corners_px);
}

TEST_F(BoardLessonsTest, TwoPicturesProveNoStillness) {
  look(found(views[0]));
  EXPECT_EQ(look(found(views[0]), 2), Seen::moving);
  EXPECT_EQ(look(found(views[0])), Seen::taken);
}

TEST_F(BoardLessonsTest, ALostBoardBeginsAnew) {
  hold(views[0], 5);
  EXPECT_EQ(look({std::nullopt, "it is dark", {}}), Seen::nothing);
  EXPECT_THAT(lessons.words(), HasSubstr("it is dark"));
  EXPECT_FALSE(lessons.newest());
  EXPECT_EQ(hold(views[0], 5), Seen::moving);
}

TEST_F(BoardLessonsTest, APlaceIsTakenOnce) {
  EXPECT_EQ(hold(views[0]), Seen::taken);
  EXPECT_EQ(hold(views[0]), Seen::known);
  EXPECT_THAT(lessons.words(), HasSubstr("elsewhere"));
  BoardView turned = views[0];  // as the finder does that begins at the board's other end
  std::reverse(turned.corners_px.begin(), turned.corners_px.end());
  EXPECT_EQ(hold(turned), Seen::known);
  EXPECT_EQ(hold(found(views[0], 20).view.value()), Seen::taken);
  EXPECT_EQ(lessons.taken().size(), 2u);
}

TEST_F(BoardLessonsTest, WhatIsGivenBackIsNotTakenAgainWhereItStands) {
  hold(views[0]);
  hold(views[1]);
  lessons.undo();
  EXPECT_EQ(lessons.taken().size(), 1u);
  EXPECT_EQ(hold(views[1]), Seen::known);
  EXPECT_EQ(hold(views[2]), Seen::taken);
  EXPECT_EQ(hold(views[1]), Seen::taken) << "it has been away";
  for (int i = 0; i < 3; ++i) lessons.undo();
  EXPECT_THROW(lessons.undo(), Refusal);
}

TEST_F(BoardLessonsTest, AnotherBoardOrPictureSizeIsSaid) {
  BoardFinding other = found(views[0]);
  other.seen = {10, 7};
  EXPECT_EQ(look(other), Seen::nothing);
  EXPECT_THAT(lessons.words(), HasSubstr("10x7"));
  other.seen = {9, 5};  // a part of it
  EXPECT_EQ(look(other), Seen::moving);
  hold(views[0]);
  EXPECT_EQ(lessons.look(found(views[1]), {800, 600}, 100), Seen::nothing);
  EXPECT_THAT(lessons.words(), HasSubstr("800x600"));
  EXPECT_THROW(BoardLessons("chessboard:9", 0.025), InputError);
  EXPECT_THROW(BoardLessons("chessboard:9x6", 0), InputError);
}

TEST_F(BoardLessonsTest, TheFitIsTheCommands) {
  const BoardFit fit = fit_boards(picture_size, views, {LensModel::pinhole, LensModel::brown});
  ASSERT_TRUE(fit.calibration) << fit.refused;
  const BoardCalibration same =
      calibrate_from_boards(picture_size, views, {LensModel::pinhole, LensModel::brown});
  EXPECT_EQ(fit.calibration->camera.parameters().fx_px, same.camera.parameters().fx_px);
  EXPECT_EQ(fit.calibration->covered_ball_sigma_mm, same.covered_ball_sigma_mm);
  ASSERT_TRUE(fit.worst_place());
  EXPECT_EQ(fit.map->sigma_mm[*fit.worst_place()], fit.map->worst_mm());
}

TEST_F(BoardLessonsTest, RefusedWithTheCommandsReason) {
  std::vector<BoardView> flat = test::random_views(some_camera(), 5, 0.05, 3, 0.001, 0.4, 0.41);
  const BoardFit fit = fit_boards(picture_size, flat, {LensModel::pinhole});
  EXPECT_FALSE(fit.calibration);
  EXPECT_FALSE(fit.is_good_enough());
  EXPECT_THAT(fit.refused, HasSubstr("one angle"));
  EXPECT_THAT(next_board(test::chessboard, picture_size, flat, &fit).words, HasSubstr("tilted"));
}

TEST_F(BoardLessonsTest, TheNextBoardIsAskedForWhereTheBallIsMostUncertain) {
  // In the left half alone.
  std::vector<BoardView> left;
  for (std::uint64_t seed = 0; left.size() < 8; ++seed)
    for (BoardView& view : test::random_views(some_camera(), 4, 0.05, seed, 0.6, 0.35, 0.9))
      if (std::all_of(view.corners_px.begin(), view.corners_px.end(),
                      [](const Eigen::Vector2d& corner) { return corner.x() < 360; }))
        left.push_back(view);
  const BoardFit fit = fit_boards(picture_size, left, {LensModel::brown});
  ASSERT_TRUE(fit.calibration && fit.map) << fit.refused;
  const BoardHint hint = next_board(test::chessboard, picture_size, left, &fit);
  const auto& sigma_mm = fit.map->sigma_mm;
  const auto worst = std::find(sigma_mm.begin(), sigma_mm.end(), fit.map->worst_mm()) - sigma_mm.begin();
  EXPECT_EQ(hint.place_px, fit.map->places_px[static_cast<std::size_t>(worst)]);
  EXPECT_THAT(hint.words, HasSubstr(hint.place_px.x() < 213   ? "left of"
                                    : hint.place_px.x() > 426 ? "right of"
                                                              : "at the"));
  EXPECT_THAT(hint.words, HasSubstr(fmt::format("{:.1f} mm", *fit.map->worst_mm())));
  EXPECT_FALSE(fit.is_good_enough()) << "eight boards in one half";
}

TEST_F(BoardLessonsTest, WithoutAFitTheEmptiestPlaceIsAskedFor) {
  const BoardHint first = next_board(test::chessboard, picture_size, {}, nullptr);
  EXPECT_THAT(first.words, HasSubstr("in the middle"));
  EXPECT_THAT(first.words, HasSubstr("so near that it fills half"));
  BoardView middle = views[0];
  for (Eigen::Vector2d& corner : middle.corners_px)
    corner = Eigen::Vector2d(320, 240) + 0.1 * (corner - middle.corners_px.front());
  EXPECT_THAT(next_board(test::chessboard, picture_size, {middle}, nullptr).words, HasSubstr("upper left"));
}

TEST_F(BoardLessonsTest, TheTiltThatIsMissingIsAskedFor) {
  // All with the right side towards the camera, or the lower or upper edge.
  std::vector<BoardView> right;
  RandomEngine engine = random_stream(1, "tilts");
  for (int i = 0; i < 9; ++i) {
    test::PlacedBoard placed;
    const Eigen::Vector3d axes[] = {{0, 1, 0}, {1, 0, 0}, {-1, 0, 0}};
    placed.R_CB = Eigen::AngleAxisd(0.6, axes[i % 3]).toRotationMatrix();
    placed.p_CB = {-0.1 + 0.05 * (i / 3), -0.06 - 0.02 * (i / 3), 0.3 + 0.1 * (i / 3)};
    right.push_back(test::noisy_view(some_camera(), test::chessboard, placed, 0.05, engine, "board"));
  }
  const BoardFit fit = fit_boards(picture_size, right, {LensModel::brown});
  ASSERT_TRUE(fit.calibration) << fit.refused;
  const BoardPose& first = fit.calibration->poses.front();
  const char* const missing = board_normal(first).x() > 0 ? "left side" : "right side";
  EXPECT_THAT(next_board(test::chessboard, picture_size, right, &fit).words, HasSubstr(missing));
  // A board whose right side is nearer has its right corners farther apart.
  const BoardView& view = right.front();
  const double left_px = (view.corners_px[45] - view.corners_px[0]).norm();
  const double right_px = (view.corners_px[53] - view.corners_px[8]).norm();
  EXPECT_EQ(right_px > left_px, board_normal(first).x() > 0);
}

TEST_F(BoardLessonsTest, TheBoardIsDrawnAsItIsAskedFor) {
  const auto length = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return (a - b).norm(); };
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(320, 240), {10, 10}, {630, 300}}) {
    for (std::size_t side = 0; side < 4; ++side) {
      const auto seen = outline_of({place, side, 0.4}, test::chessboard, some_camera());
      ASSERT_EQ(seen.size(), 4u);
      Eigen::Array2d low = seen[0], high = seen[0];
      for (const Eigen::Vector2d& corner : seen) {
        low = low.min(corner.array()), high = high.max(corner.array());
      }
      EXPECT_GT(low.minCoeff(), 0);
      EXPECT_TRUE((high < Eigen::Array2d(639, 479)).all());
      EXPECT_NEAR(((high - low) / Eigen::Array2d(640, 480)).maxCoeff(), 0.4, 0.02);
      if (place.x() == 320) {
        EXPECT_LT(length(((low + high) / 2).matrix(), place), 25);
      }
      const std::array<double, 4> sides{length(seen[1], seen[2]), length(seen[0], seen[1]),
                                        length(seen[3], seen[0]), length(seen[2], seen[3])};
      EXPECT_GT(sides[side], 1.05 * sides[(side + 2) % 4]) << "what is nearer is larger";
    }
  }
  EXPECT_EQ(next_board(test::chessboard, picture_size, {}, nullptr).outline_px.size(), 4u)
      << "before there is a camera";
}

/// Someone holds a board as the hint says; what of it is in the picture is seen.
BoardView held(const Camera& camera, const BoardHint& hint, double noise_px, RandomEngine& engine) {
  const auto says = [&](const char* words) { return hint.words.find(words) != std::string::npos; };
  const double tilt_rad = uniform(engine, 0.35, 0.7), turn_rad = uniform(engine, -0.3, 0.3);
  const Eigen::Vector3d axis = says("right side")   ? Eigen::Vector3d(0, 1, 0)
                               : says("left side")  ? Eigen::Vector3d(0, -1, 0)
                               : says("upper edge") ? Eigen::Vector3d(1, 0, 0)
                                                    : Eigen::Vector3d(-1, 0, 0);
  const double range_m = says("half") ? 0.25 : says("far") ? 0.6 : uniform(engine, 0.25, 0.5);
  const Eigen::Vector3d middle(0.1, 0.0625, 0);
  for (Eigen::Vector2d place = hint.place_px;; place = 0.9 * place + 0.1 * Eigen::Vector2d(320, 240)) {
    test::PlacedBoard placed;
    placed.R_CB = (Eigen::AngleAxisd(tilt_rad, axis) * Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()))
                      .toRotationMatrix();
    placed.p_CB = range_m * *camera.unproject(place) - placed.R_CB * middle;
    BoardView view{"board", {}, {}};
    for (const Eigen::Vector3d& point : test::chessboard.points()) {
      const auto corner = test::seen(camera, placed, point, 8);
      if (!corner) continue;
      view.points_m.push_back(point);
      view.corners_px.push_back(*corner +
                                noise_px * Eigen::Vector2d(standard_normal(engine), standard_normal(engine)));
    }
    if (view.size() >= 27) return view;
  }
}

TEST_F(BoardLessonsTest, HeldAsTheHintsSayEightBoardsLeaveNoPlaceFarWorse) {
  constexpr std::size_t count = 8;
  const auto fitted = [](const std::vector<BoardView>& boards) {
    return fit_boards(picture_size, boards, {LensModel::brown});
  };
  RandomEngine engine = random_stream(1, "held");
  std::vector<BoardView> guided;
  BoardFit fit;
  while (guided.size() < count) {
    const BoardHint hint =
        next_board(test::chessboard, picture_size, guided, guided.empty() ? nullptr : &fit);
    guided.push_back(held(some_camera(), hint, 0.12, engine));
    if (guided.size() >= BoardFit::least_boards) fit = fitted(guided);
  }
  const BoardFit anyhow = fitted(test::random_views(some_camera(), count, 0.12, 1, 0.6, 0.25, 0.6));
  ASSERT_TRUE(fit.calibration && anyhow.calibration);
  EXPECT_LT(*fit.calibration->ball_sigma_mm, 0.5 * *anyhow.calibration->ball_sigma_mm);
}

TEST_F(BoardLessonsTest, GoodEnoughIsWhatTheMapSays) {
  const auto fitted = [](int boards) {
    return fit_boards(picture_size, test::random_views(some_camera(), boards, 0.05, 5), {LensModel::brown});
  };
  const BoardFit many = fitted(40), few = fitted(5);
  EXPECT_TRUE(many.is_good_enough()) << *many.calibration->ball_sigma_mm;
  EXPECT_LE(*many.calibration->covered_ball_sigma_mm, BoardFit::good_mm);
  ASSERT_TRUE(few.calibration);
  EXPECT_FALSE(few.is_good_enough());
}

}  // namespace
}  // namespace ballservo
