// Label slow: whether a calibration's uncertainties tell its errors, over many calibrations of known cameras.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/ball/camera_difference.hpp"
#include "calibration/boards/board_detector.hpp"
#include "calibration/boards/lens_choice.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "tests/calibration/board_examples.hpp"
#include "tests/calibration/camera_examples.hpp"

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
  // 1000 trials tell a standard deviation to 2.2 %.
  for (Eigen::Index i = 0; i < ratios.size(); ++i) {
    std::printf("%s: error / predicted sigma = %.3f\n", names[static_cast<std::size_t>(i)].c_str(),
                ratios(i));
    EXPECT_NEAR(ratios(i), 1, 0.1) << names[static_cast<std::size_t>(i)];
  }
  std::printf("ball at 1 m: %.3f, of %.2f mm\n", spread.ball_ratio(), spread.worst_ball_mm());
  EXPECT_NEAR(spread.ball_ratio(), 1, 0.1);
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
