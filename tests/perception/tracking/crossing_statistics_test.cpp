// Label slow: how often identities are kept, over a hundred scenes of each kind.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/perception/tracking/crossing_run.hpp"

namespace ballservo {
namespace {

constexpr int scenes = 100;

template <class Keeps>
void expect_kept(const char* what, const Keeps& keeps) {
  int kept = 0;
  for (std::uint64_t seed = 1000; seed < 1000 + scenes; ++seed) kept += keeps(seed);
  std::printf("%s: %d of %d kept\n", what, kept, scenes);
  EXPECT_GE(kept, 95);
}

TEST(CrossingStatistics, BesideEachOther) {
  expect_kept("passing with a gap",
              [](std::uint64_t seed) { return test::keeps_identities(test::Meeting::gap, seed); });
}

TEST(CrossingStatistics, HidingEachOther) {
  expect_kept("one hides the other",
              [](std::uint64_t seed) { return test::keeps_identities(test::Meeting::hiding, seed); });
}

TEST(CrossingStatistics, BehindAWall) {
  expect_kept("hidden by a wall", [](std::uint64_t seed) { return test::is_known_again(seed); });
}

}  // namespace
}  // namespace ballservo
