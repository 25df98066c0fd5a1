// The edge along one outline.
#include "perception/outline/edge_points.hpp"

#include <gtest/gtest.h>

#include "perception/outline/camera_response.hpp"
#include "perception/outline/paper_refinement.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

constexpr ImageSize size{320, 240};
constexpr double radius_px = 40;

/// The share of the segments in which an edge is found between a disc and the grey around it, that differ in
/// green alone.
double share_found(std::uint8_t inside, std::uint8_t around) {
  const Camera camera = test::pinhole(size, 400);
  const RayTable rays(camera);
  cv::Mat bgr(size.height_px, size.width_px, CV_8UC3, cv::Scalar::all(around));
  test::paint_disc(bgr, *camera.project({0, 0, 1}), radius_px, {around, inside, around});
  EdgeMeter meter;
  OutlineEdges edges;
  meter.measure(bgr, rays, *cone_near_circle({{0, 0}, radius_px}, 400), CameraResponse::linear(), edges);
  EXPECT_GT(edges.segments, 16);
  return static_cast<double>(edges.points.size()) / edges.segments;
}

TEST(EdgeMeter, InTheDarkAFainterEdgeWillDo) {
  EXPECT_EQ(share_found(152, 140), 1);
  EXPECT_EQ(share_found(147, 140), 0);  // a shadow's edge, a texture
  EXPECT_EQ(share_found(47, 40), 1);
  EXPECT_EQ(share_found(13, 10), 0);
}

// A disc before a band of its own brightness and darker surroundings: brightness alone has its edge at the
// band's far side.
TEST(EdgeMeter, WhereColoursAreCoarseLumasEdgeCountsOnlyBesideTheColours) {
  const Camera camera = test::pinhole(size, 400);
  const RayTable rays(camera);
  const Eigen::Vector2d center_px = *camera.project({0, 0, 1});
  cv::Mat bgr(size.height_px, size.width_px, CV_8UC3, cv::Scalar(30, 80, 30));
  test::paint_disc(bgr, center_px, radius_px + 2, {50, 130, 50});
  test::paint_disc(bgr, center_px, radius_px, {40, 60, 205});
  EdgeMeter meter;
  OutlineEdges edges;
  meter.measure(bgr, rays, *cone_near_circle({{0, 0}, radius_px}, 400), CameraResponse::srgb(true), edges);
  ASSERT_GT(edges.points.size(), 30u);
  double sum_px = 0;
  for (const EdgePoint& point : edges.points) sum_px += (*camera.project(point.ray) - center_px).norm();
  EXPECT_NEAR(sum_px / static_cast<double>(edges.points.size()), radius_px, 0.5);
}

// What was smeared is told by its blur, of which luma says little where it differs by little.
TEST(EdgeMeter, WhereColoursAreCoarseTheBlurIsThatOfTheColours) {
  const Camera camera = test::pinhole(size, 400);
  cv::Mat bgr(size.height_px, size.width_px, CV_8UC3, cv::Scalar(95, 95, 95));
  test::paint_disc(bgr, *camera.project({0, 0, 1}), radius_px, {30, 110, 90});
  cv::GaussianBlur(bgr, bgr, {}, 2.5);
  EdgeMeter meter;
  OutlineEdges edges;
  meter.measure(bgr, RayTable(camera), *cone_near_circle({{0, 0}, radius_px}, 400),
                CameraResponse::srgb(true), edges);
  EXPECT_GT(edges.blur_px, 2);
}

}  // namespace
}  // namespace ballservo
