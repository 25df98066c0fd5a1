// Two balls of one colour that cross keep their identities; a ball that was hidden keeps its own.
#include <gtest/gtest.h>

#include "tests/perception/tracking/crossing_run.hpp"

namespace ballservo {
namespace {

constexpr std::uint64_t seeds = 8;  // crossing_statistics_test has a hundred of each

TEST(Crossing, BallsThatPassBesideEachOtherKeepTheirIdentities) {
  for (std::uint64_t seed = 0; seed < seeds; ++seed)
    EXPECT_TRUE(test::keeps_identities(test::Meeting::gap, seed)) << seed;
}

TEST(Crossing, SoDoBallsThatHideEachOther) {
  for (std::uint64_t seed = 0; seed < seeds; ++seed)
    EXPECT_TRUE(test::keeps_identities(test::Meeting::hiding, seed)) << seed;
}

TEST(Crossing, ABallThatWasBehindAWallIsTheSameBall) {
  for (std::uint64_t seed = 0; seed < seeds / 2; ++seed) EXPECT_TRUE(test::is_known_again(seed)) << seed;
}

}  // namespace
}  // namespace ballservo
