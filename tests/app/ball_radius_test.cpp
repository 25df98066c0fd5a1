// A ball's radius from rendered pictures at known distances, from painted ones on a board, and what happens
// when they contradict each other.
#include "calibration/ball/ball_radius.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/base/random.hpp"
#include "calibration/boards/board.hpp"
#include "calibration/boards/board_detector.hpp"
#include "servo/simulation/rendering/camera_renderer.hpp"
#include "tests/perception/painted_ball.hpp"
#include "tests/simulation/dark_room.hpp"

namespace ballservo {
namespace {

const Eigen::MatrixXd unknown;

/// The only ball that the detector sees, its radius taken for 1.
UnitBall seen_ball(Detector& detector, const cv::Mat& bgr) {
  const auto& balls = detector.detect(bgr);
  EXPECT_EQ(balls.size(), 1u);
  if (balls.size() != 1 || !balls[0].position) return {{0, 0, 30}, Eigen::Matrix3d::Identity()};
  return {balls[0].position->p_C, balls[0].position->covariance_m2};
}

std::vector<std::string> names(std::size_t count) {
  std::vector<std::string> result;
  for (std::size_t i = 0; i < count; ++i) result.push_back("picture" + std::to_string(i) + ".png");
  return result;
}

TEST(BallRadius, FromRenderedPicturesAtMeasuredDistances) {
  constexpr double diameter_m = 0.0683, tape_sigma_m = 0.002;
  constexpr int sets = 6, frames = 6;
  const Camera camera = test::lens(LensModel::brown);
  DetectorOptions options;
  options.response = ResponseChoice::linear;  // one channel before black does not tell it
  options.radii.assign(2, BallRadius{1, 0});
  Detector detector(std::make_shared<const RayTable>(camera), test::red_and_green(), options);
  const RadiusReader reader(camera, unknown);
  double squares = 0;
  for (int set = 0; set < sets; ++set) {
    RandomEngine engine = random_stream(1, "radius", static_cast<std::uint64_t>(set));
    std::vector<RadiusReading> readings;
    for (int frame = 0; frame < frames; ++frame) {
      const Eigen::Vector3d direction(uniform(engine, -0.35, 0.35), uniform(engine, -0.25, 0.25), 1);
      const double distance_m = uniform(engine, 0.6, 1.4);
      const Eigen::Isometry3d X_WC = test::level_view();
      World world = test::dark_room();
      Ball ball = test::white_ball(X_WC * (distance_m * direction.normalized()), diameter_m);
      ball.material = test::luminous({0.7, 0.03, 0.03});
      world.balls = {ball};
      const CameraRenderer renderer(camera, world, SensorOptions{});
      const cv::Mat bgr = renderer.render({{X_WC, 0}}, 5, static_cast<std::uint64_t>(set * frames + frame));
      const double measured_m = distance_m + tape_sigma_m * standard_normal(engine);
      const auto reading = reader.at_distance(seen_ball(detector, bgr), measured_m, tape_sigma_m);
      ASSERT_TRUE(reading);
      readings.push_back(*reading);
    }
    const RadiusEstimate estimate = combine_radii(readings, names(readings.size()));
    EXPECT_LT(2 * estimate.sigma_m, 0.0002);
    const double deviation = (estimate.radius_m - diameter_m / 2) / estimate.sigma_m;
    EXPECT_LT(std::abs(deviation), 4) << "set " << set;
    squares += deviation * deviation;
  }
  EXPECT_LT(squares / sets, 2.6);  // chi squared of 6 degrees of freedom: above in 2 of 100 cases
  EXPECT_GT(squares / sets, 0.1);
}

/// A chessboard on a table and a red ball on it, as a camera above sees them; 4 x 4 samples a pixel.
cv::Mat board_picture(const Camera& camera, const Board& board, const Eigen::Isometry3d& X_CB,
                      const Eigen::Vector3d& p_C, double radius_m) {
  const CameraParameters& p = camera.parameters();
  const Eigen::Isometry3d X_BC = X_CB.inverse();
  const double cosine = std::sqrt(1 - std::pow(radius_m / p_C.norm(), 2));
  const Eigen::Vector3d axis = p_C.normalized();
  const double s = board.square_m;
  const auto color_at = [&](double u, double v) -> cv::Vec3d {
    const Eigen::Vector3d ray((u - p.cx_px) / p.fx_px, (v - p.cy_px) / p.fy_px, 1);
    if (ray.dot(axis) >= cosine * ray.norm()) return {40, 40, 210};
    const Eigen::Vector3d direction = X_BC.linear() * ray, origin = X_BC.translation();
    const Eigen::Vector3d at = origin - origin.z() / direction.z() * direction;
    const int i = static_cast<int>(std::floor(at.x() / s)), j = static_cast<int>(std::floor(at.y() / s));
    const bool on_squares = i >= -1 && j >= -1 && i < board.columns && j < board.rows;
    return on_squares && (i + j) % 2 == 0 ? cv::Vec3d(30, 30, 30) : cv::Vec3d(200, 200, 200);
  };
  cv::Mat bgr(p.size.height_px, p.size.width_px, CV_8UC3);
  for (int v = 0; v < bgr.rows; ++v)
    for (int u = 0; u < bgr.cols; ++u) {
      cv::Vec3d sum;
      for (int k = 0; k < 16; ++k)
        sum += color_at(u - 0.375 + 0.25 * (k % 4), v - 0.375 + 0.25 * (k / 4)) / 16;
      bgr.at<cv::Vec3b>(v, u) = cv::Vec3b(sum);
    }
  cv::GaussianBlur(bgr, bgr, {}, 0.6);
  return bgr;
}

/// The board frame's pose for a camera that looks at the board's middle from above.
Eigen::Isometry3d view_of_board(double azimuth_rad, double elevation_rad, double distance_m) {
  const Eigen::Vector3d middle(0.1, 0.0625, 0);
  // z of the board frame points into the board, away from the camera.
  const Eigen::Vector3d from(std::cos(elevation_rad) * std::cos(azimuth_rad),
                             std::cos(elevation_rad) * std::sin(azimuth_rad), -std::sin(elevation_rad));
  Eigen::Matrix3d R_BC;
  R_BC.col(2) = -from;
  R_BC.col(0) = R_BC.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
  R_BC.col(1) = R_BC.col(2).cross(R_BC.col(0));
  Eigen::Isometry3d X_BC = Eigen::Isometry3d::Identity();
  X_BC.linear() = R_BC;
  X_BC.translation() = middle + distance_m * from;
  return X_BC.inverse();
}

TEST(BallRadius, FromABallThatLiesOnTheBoard) {
  constexpr double radius_m = 0.0215;
  const Board board = parse_board("chessboard:9x6", 0.025);
  const Camera camera = test::pinhole({640, 480}, 620);
  Detector detector = test::detector_for(camera, 1);
  const RadiusReader reader(camera, unknown);
  std::vector<RadiusReading> on_face;
  for (const auto& [azimuth, elevation] : {std::pair(1.6, 0.9), std::pair(1.2, 1.1), std::pair(2.1, 1.0)}) {
    const Eigen::Isometry3d X_CB = view_of_board(azimuth, elevation, 0.5);
    const Eigen::Vector3d p_C = X_CB * Eigen::Vector3d(0.1, 0.185, -radius_m);
    const cv::Mat bgr = board_picture(camera, board, X_CB, p_C, radius_m);
    const auto corners = find_board(bgr, board).view;
    ASSERT_TRUE(corners) << azimuth;
    const UnitBall ball = seen_ball(detector, bgr);
    const auto reading = reader.on_board(ball, *corners, 0);
    ASSERT_TRUE(reading);
    EXPECT_NEAR(reading->radius_m, radius_m, 4 * reading->sigma_m) << azimuth;
    on_face.push_back(*reading);
    // Were it a ball on the table below a board 5 mm thick, it would be larger by as much as the plane is
    // further.
    const auto below = reader.on_board(ball, *corners, 0.005);
    ASSERT_TRUE(below);
    EXPECT_GT(below->radius_m, reading->radius_m + 1e-4);
  }
  const RadiusEstimate estimate = combine_radii(on_face, names(3));
  EXPECT_LT(estimate.sigma_m, 0.0003);
  EXPECT_NEAR(estimate.radius_m, radius_m, 3 * estimate.sigma_m);
}

TEST(BallRadius, TheFocalLengthsErrorIsEverybodysAndDoesNotAverageOut) {
  const Camera camera = test::pinhole({640, 480}, 500);
  Eigen::Vector4d root(5, 5, 0, 0);  // fx and fy err together, by 1 %
  const RadiusReader reader(camera, root * root.transpose());
  UnitBall ball{{0, 0, 30}, 1e-3 * Eigen::Matrix3d::Identity(), 0};
  const auto reading = reader.at_distance(ball, 1.0, 0);
  ASSERT_TRUE(reading);
  EXPECT_NEAR(reading->radius_m, 1.0 / 30, 1e-12);
  EXPECT_NEAR(reading->by_camera_m.norm(), 0.01 * reading->radius_m, 2e-4 * reading->radius_m);
  const RadiusEstimate one = combine_radii({*reading}, names(1));
  const RadiusEstimate many = combine_radii(std::vector<RadiusReading>(50, *reading), names(50));
  EXPECT_NEAR(many.sigma_m, reading->by_camera_m.norm(), 0.01 * many.sigma_m);
  EXPECT_NEAR(one.sigma_m, std::hypot(reading->sigma_m, reading->by_camera_m.norm()), 1e-9);
  // Nor does what light and background do to all outlines alike: half a percent of 16.7 px.
  ball.common_sigma_px = 0.005 * 500 / 30;
  const auto lit = reader.at_distance(ball, 1.0, 0);
  ASSERT_TRUE(lit);
  EXPECT_NEAR(lit->common_m, 0.005 * lit->radius_m, 1e-4 * lit->radius_m);
  const RadiusEstimate all = combine_radii(std::vector<RadiusReading>(500, *lit), names(500));
  EXPECT_NEAR(all.sigma_m, std::hypot(lit->common_m, lit->by_camera_m.norm()), 0.01 * all.sigma_m);
}

RadiusReading reading_of(double radius_m, double sigma_m) { return {radius_m, sigma_m, 0, {}}; }

TEST(BallRadius, ContradictingPicturesAreRefusedWithTheirFigures) {
  const std::vector<RadiusReading> good(7, reading_of(0.035, 1e-5));
  std::vector<RadiusReading> readings = good;
  readings.push_back(reading_of(0.040, 1e-5));
  const RadiusEstimate estimate = combine_radii(readings, names(8));
  EXPECT_FALSE(estimate.used.back());
  EXPECT_NEAR(estimate.radius_m, 0.035, 1e-12);
  for (int more = 0; more < 3; ++more) readings.push_back(reading_of(0.040 + 0.001 * more, 1e-5));
  for (const auto& bad :
       {readings, std::vector<RadiusReading>{reading_of(0.035, 1e-5), reading_of(0.040, 1e-5)}}) {
    try {
      combine_radii(bad, names(bad.size()));
      FAIL();
    } catch (const Refusal& refusal) {
      const std::string text = refusal.what();
      EXPECT_NE(text.find("picture1.png: diameter 0.0"), std::string::npos) << text;
      EXPECT_NE(text.find("disagrees"), std::string::npos) << text;
    }
  }
  // What is rough and says so contradicts nobody; scatter beyond the errors widens the sigma.
  EXPECT_NO_THROW(combine_radii({reading_of(0.035, 0.003), reading_of(0.040, 0.003)}, names(2)));
  const auto scattered =
      combine_radii({reading_of(0.0350, 1e-6), reading_of(0.0351, 1e-6), reading_of(0.0352, 1e-6)}, names(3));
  EXPECT_NEAR(scattered.sigma_m, 1e-4 / std::sqrt(3.0), 1e-8);
  EXPECT_GT(scattered.chi2_per_dof, 100);
}

TEST(BallRadius, ABallBehindTheBoardHasNone) {
  const Board board = parse_board("chessboard:9x6", 0.025);
  const Camera camera = test::pinhole({640, 480}, 620);
  const Eigen::Isometry3d X_CB = view_of_board(1.6, 0.9, 0.5);
  BoardView points{"", board.points(), {}};
  for (const Eigen::Vector3d& point : points.points_m)
    points.corners_px.push_back(*camera.project(X_CB * point));
  const RadiusReader reader(camera, unknown);
  // From above the plane recedes upwards in the picture: above the horizon no ball touches it from this side.
  EXPECT_TRUE(reader.on_board({{0, 0, 20}, Eigen::Matrix3d::Identity()}, points, 0));
  EXPECT_FALSE(
      reader.on_board({X_CB.linear() * Eigen::Vector3d(0, 0, -20), Eigen::Matrix3d::Identity()}, points, 0));
  points.corners_px.assign(points.corners_px.size(), Eigen::Vector2d(100, 100));
  EXPECT_FALSE(reader.on_board({{0, 0, 20}, Eigen::Matrix3d::Identity()}, points, 0));
}

}  // namespace
}  // namespace ballservo
