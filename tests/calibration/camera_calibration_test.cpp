// Board calibration: synthetic boards give back the camera that made them, to what the covariance promises;
// real ones give the known figures.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/random.hpp"
#include "calibration/boards/board_calibration.hpp"
#include "calibration/boards/board_detector.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "calibration/pictures/image_file.hpp"
#include "tests/calibration/board_examples.hpp"
#include "tests/calibration/camera_examples.hpp"
#include "tests/support/faults.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using test::camera_examples;
using test::camera_parameters;
using test::chessboard;
using test::only;
using test::random_views;

class EveryLensCalibrated : public testing::TestWithParam<test::CameraExample> {};

INSTANTIATE_TEST_SUITE_P(Models, EveryLensCalibrated, testing::ValuesIn(camera_examples()),
                         [](const auto& example) { return example.param.name; });

TEST_P(EveryLensCalibrated, ExactBoardsGiveTheCameraBack) {
  const Camera truth(GetParam().parameters);
  const auto result =
      calibrate_from_boards(truth.size(), random_views(truth, 15, 0, 1), only(truth.parameters().model));
  EXPECT_LT(result.rms_px, 1e-5);
  EXPECT_LT(result.held_out_rms_px, 1e-4);
  // What counts is where rays go: the rational lens has nearly equal ones with other coefficients.
  for (double v = 20; v < 480; v += 44)
    for (double u = 20; u < 640; u += 60) {
      const auto pixel = result.camera.project(*truth.unproject({u, v}));
      ASSERT_TRUE(pixel);
      EXPECT_LT((*pixel - Eigen::Vector2d(u, v)).norm(), 1e-2);
    }
}

TEST(BoardCalibration, AutoTakesTheSimplestModelThatSuffices) {
  const std::vector<LensModel> models{LensModel::brown8, LensModel::brown, LensModel::pinhole,
                                      LensModel::visp};
  for (const char* name : {"pinhole", "visp_barrel", "brown"}) {
    for (const auto& example : camera_examples()) {
      if (example.name != name) continue;
      const Camera truth(example.parameters);
      const auto result = calibrate_from_boards(truth.size(), random_views(truth, 12, 0.1, 5), models);
      EXPECT_EQ(result.camera.parameters().model, truth.parameters().model) << name;
      EXPECT_EQ(result.trials.size(), 4u);
    }
  }
}

TEST(BoardCalibration, ABallsUncertaintyIsTheScatterUnderRandomCameras) {
  const Camera camera(camera_parameters(LensModel::brown, 533, {-0.28, 0.05, 1e-3, -5e-4, 0.09}));
  // Correlated as calibrations are: a little of everything along three directions.
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(9, 3);
  root.col(0) << 0.4, 0.42, 0.05, 0.03, 1e-3, -8e-3, 0, 0, 1e-2;
  root.col(1) << 0.1, 0.12, 0.3, -0.2, 0, 0, 1e-4, 0, 0;
  root.col(2) << 0, 0.03, -0.2, 0.4, 2e-3, -4e-3, 0, 1e-4, 0;
  const auto predicted_mm = ball_sigma_mm(camera, root * root.transpose());
  ASSERT_TRUE(predicted_mm);
  RandomEngine engine = random_stream(8, "cameras");
  std::vector<Camera> cameras;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Vector3d draw(standard_normal(engine), standard_normal(engine), standard_normal(engine));
    cameras.emplace_back(
        with_parameter_vector(camera.parameters(), parameter_vector(camera.parameters()) + root * draw));
  }
  double worst_mm = 0;
  for (double v = 0; v <= 479.5; v += 479.0 / 14)
    for (double u = 0; u <= 639.5; u += 639.0 / 20) {
      const Eigen::Vector3d p_C = *camera.unproject({u, v});
      const auto outline = project_outline(camera, p_C, 0.035, 24);
      bool inside = true;
      for (const Eigen::Vector2d& p : outline)
        inside = inside && p.x() > -0.5 && p.y() > -0.5 && p.x() < 639.5 && p.y() < 479.5;
      if (!inside) continue;
      double sum = 0;
      for (const Camera& other : cameras) {
        std::vector<Eigen::Vector3d> rays;
        for (const Eigen::Vector2d& p : outline) rays.push_back(*other.unproject(p));
        sum += (*sphere_from_rays(rays, 0.035) - p_C).squaredNorm();
      }
      worst_mm = std::max(worst_mm, 1e3 * std::sqrt(sum / 400));
    }
  // 400 draws tell a standard deviation to some 5 %.
  EXPECT_NEAR(*predicted_mm, worst_mm, 0.15 * worst_mm);
}

TEST(BoardCalibration, ABallsUncertaintyInSimpleCases) {
  const Camera camera(camera_parameters(LensModel::visp, 535, {0.33}));
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(5, 5);
  covariance.diagonal() << 1.0, 1.0, 0.0, 0.0, 0.0;
  // Both focal lengths wrong together by s would put a ball at Z wrong by Z s / f; independent ones half that
  // variance in depth, and sideways motion off the axis: between 0.7 and 3 of it.
  const auto sigma = ball_sigma_mm(camera, covariance);
  ASSERT_TRUE(sigma);
  EXPECT_GT(*sigma, 0.7 * 1000 / 535.0);
  EXPECT_LT(*sigma, 3 * 1000 / 535.0);
  EXPECT_NEAR(*ball_sigma_mm(camera, 4 * covariance), 2 * *sigma, 1e-3 * *sigma);
  EXPECT_EQ(*ball_sigma_mm(camera, 0 * covariance), 0);
  // A principal point wrong by 1 px turns every ray by about 1 / f.
  covariance.diagonal() << 0.0, 0.0, 1.0, 0.0, 0.0;
  CameraParameters pinhole = camera_parameters(LensModel::pinhole, 5350, {});
  const auto shift = ball_sigma_mm(Camera(pinhole), covariance.topLeftCorner(4, 4));
  ASSERT_TRUE(shift);
  EXPECT_NEAR(*shift, 1000 / 5350.0, 0.02);
}

TEST(BoardCalibration, RefusesWhatCannotTellTheFocalLength) {
  const Camera truth(camera_parameters(LensModel::brown, 533, {-0.28, 0.05, 1e-3, -5e-4, 0.09}));
  EXPECT_THROW(calibrate_from_boards(truth.size(), {}), Refusal);
  EXPECT_THROW(calibrate_from_boards(truth.size(), random_views(truth, 2, 0.1, 3)), Refusal);
  // Boards parallel to the picture: focal length and distance cannot be told apart.
  for (const LensModel model : {LensModel::pinhole, LensModel::visp, LensModel::brown}) {
    const Camera camera(model == LensModel::brown ? truth.parameters()
                                                  : camera_parameters(LensModel::pinhole, 533, {}));
    EXPECT_THROW(calibrate_from_boards(truth.size(), random_views(camera, 8, 0.1, 4, 1e-3), only(model)),
                 Refusal);
  }
  // The same picture three times.
  const BoardView view = random_views(truth, 1, 0.1, 6).front();
  EXPECT_THROW(calibrate_from_boards(truth.size(), {view, view, view}), Refusal);
}

TEST(BoardCalibration, RefusesPointsThatAreNoBoard) {
  RandomEngine engine = random_stream(1, "nonsense");
  std::vector<BoardView> views(5);
  for (BoardView& view : views) {
    view.points_m = chessboard.points();
    for (int i = 0; i < 54; ++i)
      view.corners_px.emplace_back(uniform(engine, 0, 639), uniform(engine, 0, 479));
  }
  EXPECT_THROW(calibrate_from_boards({640, 480}, views), Refusal);
  for (BoardView& view : views)
    for (auto& point : view.corners_px) point = {320, 240};
  EXPECT_THROW(calibrate_from_boards({640, 480}, views), Refusal);
}

TEST(Boards, NamesAndFaults) {
  const Board board = parse_board("chessboard:9x6", 0.025);
  EXPECT_EQ(board.columns, 9);
  EXPECT_EQ(board.rows, 6);
  EXPECT_EQ(board.points().size(), 54u);
  EXPECT_EQ(parse_board("acircles:4x11", 0.02).points()[5], Eigen::Vector3d(0.06, 0.02, 0));
  for (const char* text :
       {"", "chessboard", "chessboard:", "chessboard:9", "chessboard:9x", "chessboard:9x-6",
        "chessboard:9x6x3", "chessboard:2x6", "chessboard:9x1000", "charuco:9x6", "9x6"})
    EXPECT_THROW(parse_board(text, 0.025), InputError) << text;
  for (const double square : {0.0, -0.025, std::nan(""), HUGE_VAL})
    EXPECT_THROW(parse_board("chessboard:9x6", square), InputError) << square;
  EXPECT_EQ(test::faults_of([] { parse_board("charuco:9x6", -1); }).size(), 2u);
}

TEST(BoardDetector, PicturesWithoutABoard) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(16, 16), cv::Size(640, 480)})
    for (const int grey : {0, 128, 255}) {
      EXPECT_FALSE(find_board(cv::Mat(size, CV_8UC3, cv::Scalar::all(grey)), chessboard).view);
      EXPECT_FALSE(
          find_board(cv::Mat(size, CV_8UC1, cv::Scalar::all(grey)), parse_board("circles:6x6", 0.03)).view);
    }
  const auto reason = [](int grey) {
    return find_board(cv::Mat(480, 640, CV_8UC1, cv::Scalar(grey)), chessboard).reason;
  };
  EXPECT_THAT(reason(30), testing::HasSubstr("it is dark: hardly a pixel is above grey level 30"));
  EXPECT_THAT(reason(128), testing::Not(testing::HasSubstr("dark")));
}

TEST(BoardDetector, ABoardThatIsTooSmallIsSaidToBe) {
  const Camera camera(test::camera_parameters(LensModel::pinhole, 520, {}));
  RandomEngine engine = random_stream(0, "small");
  const test::PlacedBoard placed{Eigen::Matrix3d::Identity(), {-0.1, -0.06, 2.675}};
  const auto painted = test::painted_chessboard(camera, chessboard, placed);
  EXPECT_THAT(find_board(test::photographed(painted, 1, engine), chessboard).reason,
              testing::HasSubstr("too small"));
}

/// The distances (px) of the corners found in a painted picture from the true ones, each from the nearest.
std::vector<double> corner_errors_px(const Camera& camera, const test::PlacedBoard& placed,
                                     const cv::Mat& painted) {
  RandomEngine engine = random_stream(0, "painted corners");
  const auto view = find_board(test::photographed(painted, 1, engine), chessboard).view;
  std::vector<double> errors;
  if (!view) return errors;
  for (const Eigen::Vector2d& corner : view->corners_px) {
    double nearest = HUGE_VAL;
    for (const Eigen::Vector3d& point : chessboard.points())
      nearest = std::min(nearest, (*camera.project(placed.R_CB * point + placed.p_CB) - corner).norm());
    errors.push_back(nearest);
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

TEST(BoardDetector, CornersOfTiltedAndBentBoardsToAHundredthOfAPixel) {
  // Straight on, tilted, and at the side of a wide lens; sharp and blurred. (Along the pixels' own rows the
  // painted edges would all be wrong by the same part of a sample.)
  const Camera barrel(camera_parameters(LensModel::brown, 533, {-0.28, 0.05, 1e-3, -5e-4, 0.09}));
  const Camera wide(camera_parameters(LensModel::kannala_brandt, 236, {-0.02, 0.003, -0.001, 0.0001}));
  test::PlacedBoard straight, tilted, aside;
  straight.R_CB = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  straight.p_CB = {-0.1, -0.0625, 0.4};
  tilted.R_CB = (Eigen::AngleAxisd(0.6, Eigen::Vector3d(0.6, -0.8, 0)) *
                 Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()))
                    .toRotationMatrix();
  tilted.p_CB = {-0.08, -0.04, 0.35};
  aside.R_CB = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()).toRotationMatrix();
  aside.p_CB = {0.12, -0.06, 0.19};
  for (const auto& [camera, placed] :
       {std::make_pair(barrel, straight), std::make_pair(barrel, tilted), std::make_pair(wide, aside)}) {
    const cv::Mat sharp = test::painted_chessboard(camera, chessboard, placed, 10);
    cv::Mat blurred;
    cv::GaussianBlur(sharp, blurred, {}, 0.7);
    for (const cv::Mat& picture : {sharp, blurred}) {
      const std::vector<double> errors = corner_errors_px(camera, placed, picture);
      ASSERT_EQ(errors.size(), 54u);
      EXPECT_LT(errors[27], 0.015);
      EXPECT_LT(errors.back(), 0.1);
    }
  }
}

TEST(RealBoards, OfABoardCutOffByTheBorderThePartThatIsSeenIsUsed) {
  const auto folder = test::shared_data_dir();
  if (!folder) GTEST_SKIP() << "the pictures of others are not here";
  for (const char* name : {"calibration1.jpg", "calibration5.jpg"}) {
    const auto view = find_board(read_color_image(*folder / "calib_carnd_lane" / name), chessboard).view;
    ASSERT_TRUE(view) << name;
    EXPECT_LT(view->size(), 54u) << name;
    EXPECT_GE(view->size(), 18u) << name;
  }
}

std::vector<BoardView> views_of(const std::filesystem::path& folder, const std::vector<std::string>& names,
                                const Board& board) {
  std::vector<BoardView> views;
  for (const std::string& name : names)
    if (const auto view = find_board(read_color_image(folder / name), board).view) views.push_back(*view);
  return views;
}

TEST(RealBoards, RandomNumbersDrawnBeforeChangeNothing) {
  const auto folder = test::opencv_doc_dir();
  if (!folder) GTEST_SKIP() << "opencv-doc is not installed";
  for (const char* name : {"left01.jpg", "left05.jpg", "left08.jpg", "left12.jpg"}) {
    const cv::Mat picture = read_color_image(*folder / name);
    cv::setRNGSeed(1);
    const auto first = find_board(picture, chessboard).view;
    cv::setRNGSeed(77);
    const auto again = find_board(picture, chessboard).view;
    ASSERT_TRUE(first && again) << name;
    EXPECT_EQ(first->corners_px, again->corners_px) << name;
  }
}

TEST(RealBoards, OpenCvsLeftCamera) {
  const auto folder = test::opencv_doc_dir();
  if (!folder) GTEST_SKIP() << "opencv-doc is not installed";
  std::vector<std::string> names;
  for (int i = 1; i <= 14; ++i)
    if (i != 10) names.push_back((i < 10 ? "left0" : "left") + std::to_string(i) + ".jpg");
  const auto views = views_of(*folder, names, chessboard);
  ASSERT_EQ(views.size(), 13u);
  const auto brown = calibrate_from_boards({640, 480}, views, only(LensModel::brown));
  EXPECT_LE(brown.rms_px, 0.165);
  EXPECT_NEAR(brown.camera.parameters().fx_px, 533.1, 1);
  EXPECT_LT(brown.held_out_rms_px, 0.17);
  double sum = 0;
  for (const CornerResiduals& corners : brown.corners) sum += corners.rms_px() * corners.rms_px();
  EXPECT_NEAR(std::sqrt(sum / 13), brown.rms_px, 1e-12);
  const auto visp = calibrate_from_boards({640, 480}, views, only(LensModel::visp));
  EXPECT_LT(visp.rms_px, 0.21);
  EXPECT_LT(brown.rms_px, visp.rms_px);
}

TEST(RealBoards, CirclesAndFactoryFigures) {
  const auto folder = test::shared_data_dir();
  if (!folder) GTEST_SKIP() << "the pictures of others are not here";
  const Board circles = parse_board("circles:6x6", 0.034);
  std::vector<std::string> names;
  for (int i = 1; i <= 5; ++i) names.push_back("circles-0" + std::to_string(i) + ".jpg");
  const auto small = calibrate_from_boards(
      {320, 240}, views_of(*folder / "calib_visp_circles", names, circles), only(LensModel::brown));
  EXPECT_LT(small.rms_px, 0.28);
  EXPECT_NEAR(small.camera.parameters().fx_px, 271.9, 0.5);
  const Board board = parse_board("chessboard:9x6", 0.0236);
  names.clear();
  for (int i = 1; i <= 8; ++i) names.push_back("franka_image-" + std::to_string(i) + ".png");
  const auto franka = calibrate_from_boards({640, 480}, views_of(*folder / "calib_visp_franka", names, board),
                                            only(LensModel::brown));
  EXPECT_LT(franka.rms_px, 0.24);
  EXPECT_NEAR(franka.camera.parameters().fx_px, 602.4, 1);
}

// A few pictures of one camera are explained by many a camera; a picture that is held out is not.
TEST(RealBoards, OneCameraIsNotTakenForTwoNorTwoForOne) {
  const auto folder = test::shared_data_dir();
  if (!folder) GTEST_SKIP() << "the pictures of others are not here";
  std::vector<std::string> names;
  for (int i = 0; i <= 13; ++i) names.push_back("img" + std::to_string(i) + ".png");
  const auto views =
      views_of(*folder / "calib_pv_lifecam480", names, parse_board("chessboard:10x10", 0.0254));
  ASSERT_EQ(views.size(), 14u);
  EXPECT_LT(calibrate_from_boards({640, 480}, views, only(LensModel::brown)).rms_px, 0.2);

  names.clear();
  for (const std::string side : {"left", "right"})
    for (int i = 1; i <= 5; ++i) names.push_back(side + "0" + std::to_string(i) + ".jpg");
  const auto both = views_of(*folder / "calib_opencv_stereo", names, chessboard);
  ASSERT_EQ(both.size(), 10u);
  EXPECT_THROW(calibrate_from_boards({640, 480}, both, only(LensModel::brown)), Refusal);
}

}  // namespace
}  // namespace ballservo
