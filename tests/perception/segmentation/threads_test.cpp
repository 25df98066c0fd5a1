// Rows shared between threads: the same answer with any number of them.
#include <gtest/gtest.h>

#include <array>
#include <opencv2/imgproc.hpp>

#include "perception/detector.hpp"
#include "perception/segmentation/classification.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

constexpr std::array<int, 4> thread_counts{1, 2, 3, 7};

cv::Mat noise(int width, int height, int type) {
  cv::Mat picture(height, width, type);
  auto engine = random_stream(1, "threads_test");
  for (std::size_t i = 0; i < picture.total() * picture.elemSize(); ++i)
    picture.data[i] = static_cast<std::uint8_t>(uniform_index(engine, 256));
  return picture;
}

bool same(const ClassPictures& a, const ClassPictures& b) {
  for (std::size_t k = 0; k < a.size(); ++k) {
    for (int v = 0; v < a[k].size().height; ++v) {
      if (!std::equal(a[k].row(v), a[k].row(v) + a[k].row_words(), b[k].row(v))) return false;
    }
  }
  return a.size() == b.size();
}

TEST(Threads, ColorsAreTheSameWithAnyNumberOfThreads) {
  const ColorLookup colors(test::red_and_green());
  const cv::Mat bgr = noise(203, 97, CV_8UC3);
  ClassPictures alone;
  classify(bgr, colors, alone);
  testing::internal::CaptureStderr();
  for (const int threads : thread_counts) {
    ClassPictures shared;
    classify(bgr, colors, shared, threads);
    EXPECT_TRUE(same(alone, shared)) << threads;
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "nor is anything said of more than there are";
}

TEST(Threads, BallsAreTheSameWithAnyNumberOfThreads) {
  const ImageSize size{640, 360};  // large enough to be shared
  cv::Mat bgr = test::grey_picture(size.width_px, size.height_px);
  test::paint_shaded_disc(bgr, {200, 180}, 40, test::red);
  test::paint_shaded_disc(bgr, {420, 175}, 25, test::green);
  cv::add(bgr, noise(size.width_px, size.height_px, CV_8UC3) * (1 / 40.0), bgr);
  std::vector<BallObservation> alone;
  for (const int threads : thread_counts) {
    DetectorOptions options;
    options.radii = {{0.05, 0}, {0.05, 0}};
    options.threads = threads;
    Detector detector(std::make_shared<const RayTable>(test::pinhole(size, 600)), test::red_and_green(),
                      options);
    const std::vector<BallObservation>& balls = detector.detect(bgr);
    if (threads == 1) alone = balls;
    ASSERT_EQ(balls.size(), alone.size());
    EXPECT_FALSE(balls.empty());
    for (std::size_t i = 0; i < balls.size(); ++i) {
      EXPECT_EQ(balls[i].position->p_C, alone[i].position->p_C) << threads;
      EXPECT_EQ(balls[i].position->covariance_m2, alone[i].position->covariance_m2) << threads;
      EXPECT_EQ(balls[i].quality, alone[i].quality) << threads;
    }
  }
}

}  // namespace
}  // namespace ballservo
