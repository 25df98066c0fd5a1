// Ten seeds through rendered frames: minutes of work.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

class StaticBallSeed : public testing::TestWithParam<std::uint64_t> {};

TEST_P(StaticBallSeed, IsReachedThroughRenderedFrames) {
  const RunRecord record = test::run(test::static_ball(GetParam()), PerceptionLevel::image, GetParam());
  EXPECT_EQ(record.summary.outcome, Outcome::reached) << record.summary.outcome_text;
  EXPECT_LE(std::abs(record.summary.range_error_m), 0.005);
  EXPECT_LE(std::abs(record.summary.bearing_error_rad), 0.2 * 0.017453292519943295);
}

INSTANTIATE_TEST_SUITE_P(Seeds, StaticBallSeed, testing::Range<std::uint64_t>(0, 10));

}  // namespace
}  // namespace ballservo
