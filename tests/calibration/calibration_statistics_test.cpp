// Label slow: whether a calibration's uncertainties tell its errors, over many calibrations of known cameras.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/ball/camera_difference.hpp"
#include "calibration/boards/board_detector.hpp"
#include "calibration/boards/lens_choice.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "calibration/pictures/image_file.hpp"
#include "tests/calibration/board_examples.hpp"
#include "tests/calibration/camera_examples.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using test::camera_parameters;
using test::chessboard;

const Camera barrel(camera_parameters(LensModel::brown, 533, {-0.28, 0.05, 1e-3, -5e-4, 0.09}));

/// Errors of estimates, each over the sigma that it promises.
class Spread {
 public:
  explicit Spread(const Camera& truth) : truth_(truth) {
    squares_ = Eigen::VectorXd::Zero(parameter_vector(truth.parameters()).size());
    for (const double v : {60.0, 240.0, 420.0}) {
      for (const double u : {60.0, 320.0, 580.0}) {
        balls_.push_back(*truth.unproject({u, v}));
        outlines_.push_back(project_outline(truth, balls_.back(), 0.035, 24));
      }
    }
  }

  void add(const BoardAdjustment& fit, const BoardCovariance& covariance) {
    const Eigen::VectorXd error = parameter_vector(fit.parameters) - parameter_vector(truth_.parameters());
    squares_ += error.cwiseAbs2().cwiseQuotient(covariance.parameters.diagonal());
    const Camera camera(fit.parameters);
    const CameraUncertainty uncertainty(camera, covariance.parameters);
    double worst_m2 = 0;
    for (std::size_t i = 0; i < balls_.size(); ++i) {
      std::vector<Eigen::Vector3d> rays;
      for (const Eigen::Vector2d& p : outlines_[i]) rays.push_back(*camera.unproject(p));
      const double predicted_m2 = uncertainty.ball_covariance(balls_[i], 0.035)->trace();
      ball_squares_ += (*sphere_from_rays(rays, 0.035) - balls_[i]).squaredNorm() / predicted_m2;
      worst_m2 = std::max(worst_m2, predicted_m2);
    }
    worst_ball_m2_ += worst_m2;
    ++trials_;
  }

  /// RMS over the trials of each parameter's error over its sigma.
  Eigen::VectorXd ratios() const { return (squares_ / trials_).cwiseSqrt(); }
  /// The same for the positions of balls all over the picture.
  double ball_ratio() const {
    return std::sqrt(ball_squares_ / (trials_ * static_cast<double>(balls_.size())));
  }
  double worst_ball_mm() const { return 1e3 * std::sqrt(worst_ball_m2_ / trials_); }

 private:
  Camera truth_;
  Eigen::VectorXd squares_;
  std::vector<Eigen::Vector3d> balls_;
  std::vector<std::vector<Eigen::Vector2d>> outlines_;
  double ball_squares_ = 0, worst_ball_m2_ = 0;
  int trials_ = 0;
};

std::vector<test::PlacedBoard> boards_in_view(const Camera& camera, int count, std::uint64_t seed,
                                              double near_m, double far_m, double margin_px) {
  RandomEngine engine = random_stream(seed, "places");
  std::vector<test::PlacedBoard> boards;
  for (int i = 0; i < count; ++i)
    boards.push_back(test::random_place(camera, chessboard, engine, 0.6, near_m, far_m, margin_px));
  return boards;
}

/// How often estimates lie within 1.96 of their sigmas.
class Coverage {
 public:
  void add(const BoardAdjustment& fit, const BoardCovariance& covariance, const CameraParameters& truth) {
    const Eigen::VectorXd error = parameter_vector(fit.parameters) - parameter_vector(truth);
    for (Eigen::Index i = 0; i < error.size(); ++i) {
      inside_ += std::abs(error(i)) < 1.96 * std::sqrt(covariance.parameters(i, i));
      naive_ += std::abs(error(i)) < 1.96 * std::sqrt(covariance.of_independent_corners(i, i));
      ++count_;
    }
  }
  double share() const { return inside_ / count_; }
  double share_of_independent_corners() const { return naive_ / count_; }

 private:
  double inside_ = 0, naive_ = 0, count_ = 0;
};

class EveryLensCalibrated : public testing::TestWithParam<test::CameraExample> {};

INSTANTIATE_TEST_SUITE_P(Models, EveryLensCalibrated, testing::ValuesIn(test::camera_examples()),
                         [](const auto& example) { return example.param.name; });

TEST_P(EveryLensCalibrated, TheCovarianceTellsTheErrors) {
  // The squared Mahalanobis distance of the estimate from the truth has the mean of its dimension.
  const Camera truth(GetParam().parameters);
  if (truth.parameters().model == LensModel::brown8)
    GTEST_SKIP() << "its numerator and denominator trade places: not near enough to linear for this test";
  constexpr int trials = 12;
  constexpr double noise_px = 0.1;
  double distance = 0, rms = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const auto result = calibrate_from_boards(
        truth.size(), test::random_views(truth, 10, noise_px, 100 + static_cast<std::uint64_t>(trial)),
        test::only(truth.parameters().model));
    const Eigen::VectorXd error =
        parameter_vector(result.camera.parameters()) - parameter_vector(truth.parameters());
    const Eigen::VectorXd weighted = result.covariance.parameters.ldlt().solve(error);
    distance += error.dot(weighted) / static_cast<double>(error.size()) / trials;
    rms += result.rms_px / trials;
    EXPECT_GT(result.held_out_rms_px, 0.5 * result.rms_px);
  }
  // Mean of chi^2 / n over 12 trials: standard deviation sqrt(2 / 12 n), at most 0.21 for n = 4.
  EXPECT_GT(distance, 0.45);
  EXPECT_LT(distance, 1.75);
  EXPECT_NEAR(rms, noise_px * std::sqrt(2.0), 0.02);
}

TEST(CalibrationStatistics, SigmasCoverErrorsThatAreAlikeWithinABoard) {
  constexpr std::uint64_t trials = 100;
  for (const std::size_t boards : {8u, 14u}) {
    Coverage rolling, zooming;
    for (std::uint64_t trial = 0; trial < trials; ++trial) {
      auto views = test::random_views(barrel, static_cast<int>(boards), 0.1, 2000 + trial);
      test::shear_views(views, barrel.size(), 0.4, trial);
      if (const auto fit = fit_lens(views, barrel.size(), LensModel::brown))
        rolling.add(*fit, *board_covariance(views, *fit), barrel.parameters());
      // An autofocus that changes the focal length by 0.3 %.
      RandomEngine engine = random_stream(trial, "autofocus");
      views.clear();
      for (std::uint64_t v = 0; v < boards; ++v) {
        CameraParameters focused = barrel.parameters();
        const double factor = 1 + 0.003 * standard_normal(engine);
        focused.fx_px *= factor, focused.fy_px *= factor;
        views.push_back(test::random_views(Camera(focused), 1, 0.1, 5000 + 100 * trial + v).front());
      }
      if (const auto fit = fit_lens(views, barrel.size(), LensModel::brown))
        zooming.add(*fit, *board_covariance(views, *fit), barrel.parameters());
    }
    for (const auto& [name, coverage] :
         {std::pair{"rolling shutter", rolling}, std::pair{"focus", zooming}}) {
      std::printf("%s, %zu boards: %.1f %% within 1.96 sigma (independent corners: %.1f %%)\n", name, boards,
                  100 * coverage.share(), 100 * coverage.share_of_independent_corners());
      EXPECT_GT(coverage.share(), 0.90) << name;
      EXPECT_LT(coverage.share(), 0.99) << name;
    }
  }
}

// Two halves of one camera's pictures differ by what their sigmas allow.
TEST(CalibrationStatistics, HalvesOfRealSetsAgreeWithinTheirSigmas) {
  const auto folder = test::shared_data_dir();
  if (!folder) GTEST_SKIP() << "the pictures of others are not here";
  struct Set {
    const char *folder, *begins, *board;
    double square_m;
  };
  constexpr int draws = 12;
  for (const Set& set : {Set{"calib_opencv_stereo", "left", "chessboard:9x6", 0.025},
                         Set{"calib_opencv_stereo", "right", "chessboard:9x6", 0.025},
                         Set{"calib_visp_franka", "franka_image", "chessboard:9x6", 0.0236},
                         Set{"calib_carnd_lane", "calibration", "chessboard:9x6", 0.025},
                         Set{"calib_pv_lifecam480", "img", "chessboard:10x10", 0.0254}}) {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(*folder / set.folder))
      if (entry.path().filename().string().rfind(set.begins, 0) == 0 &&
          (entry.path().extension() == ".jpg" || entry.path().extension() == ".png"))
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<BoardView> views;
    ImageSize size;
    for (const std::filesystem::path& file : files) {
      const cv::Mat picture = read_color_image(file);
      if (views.empty()) size = {picture.cols, picture.rows};
      if (const auto view = find_board(picture, parse_board(set.board, set.square_m)).view)
        views.push_back(*view);
    }
    RandomEngine engine = random_stream(7, "halves");
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(9);
    double independent = 0;
    int halves = 0;
    for (int draw = 0; draw < draws; ++draw) {
      for (std::size_t i = views.size(); i > 1; --i)
        std::swap(views[i - 1], views[uniform_index(engine, static_cast<std::uint32_t>(i))]);
      const auto middle = views.begin() + static_cast<std::ptrdiff_t>(views.size() / 2);
      const std::vector<BoardView> half[] = {{views.begin(), middle}, {middle, views.end()}};
      const auto one = fit_lens(half[0], size, LensModel::brown),
                 other = fit_lens(half[1], size, LensModel::brown);
      if (!one || !other) continue;
      const auto a = board_covariance(half[0], *one), b = board_covariance(half[1], *other);
      if (!a || !b) continue;
      const Eigen::VectorXd apart = parameter_vector(one->parameters) - parameter_vector(other->parameters);
      squares += apart.cwiseAbs2().cwiseQuotient(a->parameters.diagonal() + b->parameters.diagonal());
      independent +=
          apart(0) * apart(0) / (a->of_independent_corners(0, 0) + b->of_independent_corners(0, 0));
      ++halves;
    }
    ASSERT_GE(halves, draws / 2) << set.folder;
    std::printf("%s %s: chi^2 of fx %.2f (independent corners %.1f), all parameters %.2f to %.2f\n",
                set.folder, set.begins, squares(0) / halves, independent / halves,
                squares.minCoeff() / halves, squares.maxCoeff() / halves);
    // Draws share their boards, so that their mean is hardly surer than one draw of a chi^2.
    EXPECT_LT(squares.maxCoeff() / halves, 4) << set.folder;
  }
}

TEST(CalibrationStatistics, TheSpreadIsThePredictedSigma) {
  constexpr int trials = 1000;
  constexpr double noise_px = 0.15;
  const auto boards = boards_in_view(barrel, 15, 1, 0.15, 0.6, 0);
  Spread spread(barrel);
  for (int trial = 0; trial < trials; ++trial) {
    RandomEngine engine = random_stream(static_cast<std::uint64_t>(trial), "corner noise");
    std::vector<BoardView> views;
    for (const test::PlacedBoard& board : boards)
      views.push_back(test::noisy_view(barrel, chessboard, board, noise_px, engine, "board"));
    const auto fit = fit_lens(views, barrel.size(), LensModel::brown);
    ASSERT_TRUE(fit);
    spread.add(*fit, *board_covariance(views, *fit));
  }
  const Eigen::VectorXd ratios = spread.ratios();
  const auto names = parameter_names(LensModel::brown);
  // 1000 trials tell a standard deviation to 2.2 %. Corners err on their own here, and the sigmas, which
  // allow for more, are wider by up to a third.
  for (Eigen::Index i = 0; i < ratios.size(); ++i) {
    std::printf("%s: error / predicted sigma = %.3f\n", names[static_cast<std::size_t>(i)].c_str(),
                ratios(i));
    EXPECT_GT(ratios(i), 0.65) << names[static_cast<std::size_t>(i)];
    EXPECT_LT(ratios(i), 1.05) << names[static_cast<std::size_t>(i)];
  }
  std::printf("ball at 1 m: %.3f, of %.2f mm\n", spread.ball_ratio(), spread.worst_ball_mm());
  EXPECT_GT(spread.ball_ratio(), 0.65);
  EXPECT_LT(spread.ball_ratio(), 1.05);
}

TEST(CalibrationStatistics, SoIsItForPhotographedBoards) {
  constexpr int trials = 30, count = 12;
  Spread spread(barrel);
  double rms_px = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const auto seed = static_cast<std::uint64_t>(trial);
    RandomEngine engine = random_stream(seed, "picture noise");
    std::vector<BoardView> views;
    // Other boards each time: where a corner lies in its pixel makes a part of its error.
    for (const test::PlacedBoard& board : boards_in_view(barrel, count, 100 + seed, 0.2, 0.5, 12)) {
      const cv::Mat painted = test::painted_chessboard(barrel, chessboard, board, 3);
      const auto view = find_board(test::photographed(painted, 12, engine), chessboard).view;
      if (view) views.push_back(*view);
    }
    ASSERT_GE(views.size(), 10u);
    const auto fit = fit_lens(views, barrel.size(), LensModel::brown);
    ASSERT_TRUE(fit);
    spread.add(*fit, *board_covariance(views, *fit));
    rms_px += fit->rms_px / trials;
  }
  const Eigen::VectorXd ratios = spread.ratios();
  std::printf("mean RMS %.4f px; error / predicted sigma of fx_px %.3f, ball %.3f of %.2f mm\n", rms_px,
              ratios(0), spread.ball_ratio(), spread.worst_ball_mm());
  // 30 trials tell a standard deviation to 13 %.
  for (Eigen::Index i = 0; i < ratios.size(); ++i) {
    EXPECT_GT(ratios(i), 0.55) << i;
    EXPECT_LT(ratios(i), 1.45) << i;
  }
}

TEST(CalibrationStatistics, AWideFisheyeFromPaintedBoards) {
  const Camera truth(camera_parameters(LensModel::kannala_brandt, 236, {-0.02, 0.003, -0.001, 0.0001}));
  RandomEngine engine = random_stream(3, "fisheye");
  std::vector<BoardView> views;
  for (const test::PlacedBoard& board : boards_in_view(truth, 40, 3, 0.25, 0.6, 8)) {
    const auto view =
        find_board(test::photographed(test::painted_chessboard(truth, chessboard, board, 12), 1, engine),
                   chessboard)
            .view;
    if (view) views.push_back(*view);
  }
  std::printf("%zu of 40 boards found\n", views.size());
  ASSERT_GE(views.size(), 25u);
  const auto fit = fit_lens(views, truth.size(), LensModel::kannala_brandt);
  ASSERT_TRUE(fit);
  const CameraDifference difference = compare_cameras(truth, {}, Camera(fit->parameters), {});
  std::printf("RMS of the corners %.4f px; over the picture %.4f px, at most %.4f px\n", fit->rms_px,
              difference.shift_px.rms, difference.shift_px.max);
  // Corners good to some thousandths of a pixel; a painted edge's own place is wrong by as much.
  EXPECT_LT(fit->rms_px, 0.015);
  EXPECT_LT(difference.shift_px.rms, 0.02);
}

/// How far the camera that a choice among lenses finds is from the one that made the boards.
struct Choice {
  bool right_lens = false;
  double shift_rms_px = 0;
};

Choice choice_for(const Camera& truth, double noise_px, std::uint64_t seed) {
  const auto candidates =
      lens_candidates(test::random_views(truth, 40, noise_px, seed), truth.size(),
                      {LensModel::pinhole, LensModel::visp, LensModel::brown, LensModel::kannala_brandt});
  const CameraParameters& found = candidates[choose_lens(candidates)].adjustment.parameters;
  return {found.model == truth.parameters().model,
          compare_cameras(truth, {}, Camera(found), {}).shift_px.rms};
}

// As of the corners found in painted boards (AWideFisheyeFromPaintedBoards).
constexpr double finder_noise_px = 0.006;

TEST(CalibrationStatistics, AutoFindsTheLensAndTheNoiseLimitsTheRest) {
  constexpr std::uint64_t sets_a_lens = 5;
  for (const double noise_px : {0.05, finder_noise_px}) {
    int sets = 0, right = 0, near = 0;
    for (const auto& example : test::camera_examples()) {
      if (example.parameters.model == LensModel::brown8) continue;
      for (std::uint64_t set = 0; set < sets_a_lens; ++set) {
        const Choice choice = choice_for(Camera(example.parameters), noise_px, 700 + set);
        ++sets;
        right += choice.right_lens;
        near += choice.shift_rms_px <= 0.02;
      }
    }
    std::printf(
        "noise %.3f px: the right lens in %d, within 0.02 px of the truth over the picture in %d of %d "
        "sets\n",
        noise_px, right, near, sets);
    EXPECT_GE(right, 0.9 * sets);
    if (noise_px == finder_noise_px) {
      EXPECT_GE(near, 0.95 * sets);
    }
  }
}

}  // namespace
}  // namespace ballservo
