// On line nothing is taken from the heap once every buffer has had its size: counted below operator new.
#include <gtest/gtest.h>

#include "perception/tracking/tracker.hpp"
#include "tests/perception/painted_ball.hpp"
#include "tests/support/allocation_counter.hpp"

namespace ballservo {
namespace {

const ImageSize size{320, 240};

/// Pictures with balls of two colours, alone, touching, cut by the border and half covered, clutter of their
/// colour, and with none; some in much noise.
std::vector<cv::Mat> pictures() {
  std::vector<cv::Mat> result;
  for (int k = 0; k < 24; ++k) {
    cv::Mat bgr = test::grey_picture(size.width_px, size.height_px);
    const bool hidden = k % 12 >= 8;
    if (k % 3 != 0) cv::rectangle(bgr, cv::Rect(200, 20, 70, 9), cv::Scalar(test::red), cv::FILLED);
    if (k % 4 == 1) cv::rectangle(bgr, cv::Rect(30, 150, 40, 50), cv::Scalar(test::green), cv::FILLED);
    if (k % 3 == 2) cv::rectangle(bgr, cv::Rect(40, 60, 130, 90), cv::Scalar(24, 24, 130), cv::FILLED);
    if (!hidden) {
      test::paint_disc(bgr, {60.0 + 7 * k, 100}, 18, test::red);
      test::paint_disc(bgr, {90.0 + 5 * k, 130}, 15, test::red);
      test::paint_disc(bgr, {310.0 - 6 * k, 190}, 20, test::green);
      if (k % 4 == 2)
        cv::rectangle(bgr, cv::Rect(50 + 7 * k, 90, 14, 40), cv::Scalar(test::grey), cv::FILLED);
    }
    RandomEngine engine = random_stream(static_cast<std::uint64_t>(k), "detection_allocation_test");
    if (k % 5 == 4) test::add_noise(bgr, 10, engine);
    result.push_back(bgr);
  }
  return result;
}

TEST(PerceptionAllocation, DetectionTakesNoMemory) {
  const auto all = pictures();
  for (const BallFit fit : {BallFit::sphere, BallFit::paper}) {
    Detector detector = test::detector_for(test::pinhole(size, 400), 0.05, fit);
    std::size_t found = 0;
    for (const cv::Mat& bgr : all) found += detector.detect(bgr).size();
    EXPECT_GT(found, 24u);
    const long before = test::allocations();
    for (const cv::Mat& bgr : all) {
      detector.detect(bgr);
      detector.detect(bgr, {40, 60, 130, 120});
    }
    EXPECT_EQ(test::allocations() - before, 0);
  }
}

TEST(PerceptionAllocation, TrackingTakesNoMemory) {
  const auto all = pictures();
  Tracker tracker(test::detector_for(test::pinhole(size, 400), 0.05));
  double time_s = 0;
  std::size_t coasting = 0, confirmed = 0;
  const auto follow = [&] {
    for (const cv::Mat& bgr : all) {
      for (const Track& track : tracker.update(bgr, time_s += 1.0 / 30)) {
        coasting += track.state == TrackState::coasting;
        confirmed += track.state == TrackState::confirmed;
      }
    }
  };
  // Until each picture has had its turn to be looked at as a whole.
  for (int turn = 0; turn < newcomers_every; ++turn) follow();
  EXPECT_GT(coasting, 4u);
  EXPECT_GT(confirmed, 20u);
  const long before = test::allocations();
  for (int turn = 0; turn < newcomers_every; ++turn) follow();
  EXPECT_EQ(test::allocations() - before, 0);
}

}  // namespace
}  // namespace ballservo
