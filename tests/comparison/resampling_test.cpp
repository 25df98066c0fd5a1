#include "app/comparison/resampling.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

// The median of 40 exponential values lies at log 2: intervals of many samples hold it about 95 % of the
// time.
TEST(Bootstrap, HoldsTheTruthAsOftenAsItSays) {
  int held = 0;
  constexpr int rounds = 300;
  for (int round = 0; round < rounds; ++round) {
    RandomEngine engine = random_stream(1, "bootstrap", static_cast<std::uint64_t>(round));
    std::vector<double> values;
    for (int k = 0; k < 40; ++k) values.push_back(-std::log(1 - uniform01(engine)));
    const ConfidenceInterval interval = bootstrap(values, median, static_cast<std::uint64_t>(round), "test");
    held += interval.low <= std::log(2) && std::log(2) <= interval.high ? 1 : 0;
  }
  EXPECT_GT(held, 0.90 * rounds);
  EXPECT_LT(held, 0.99 * rounds);
  EXPECT_TRUE(std::isnan(bootstrap(
                             {1, 2, 3}, [](const std::vector<double>&) { return 0.0; }, 1, "few")
                             .low));
}

TEST(Wilcoxon, TellsAShiftFromNone) {
  // 1 to 12, all positive: the smallest p there is for 12 pairs, exactly 2^-11; the approximation is near.
  std::vector<double> up, both;
  for (int k = 1; k <= 12; ++k) {
    up.push_back(k);
    both.push_back(k % 2 == 0 ? k : -k);
  }
  EXPECT_LT(wilcoxon_p(up), 0.003);
  EXPECT_GT(wilcoxon_p(both), 0.5);
  EXPECT_EQ(wilcoxon_p({1, 2, 3}), 1);
  EXPECT_EQ(wilcoxon_p(std::vector<double>(50, 0.0)), 1);
}

TEST(McNemar, IsExact) {
  EXPECT_NEAR(mcnemar_p(0, 6), 2.0 / 64, 1e-12);
  EXPECT_NEAR(mcnemar_p(8, 0), 2.0 / 256, 1e-12);
  EXPECT_EQ(mcnemar_p(4, 4), 1);
  EXPECT_EQ(mcnemar_p(0, 0), 1);
}

TEST(Holm, StepsDown) {
  const std::vector<double> adjusted = holm({0.01, 0.04, 0.03, std::nan("")});
  EXPECT_NEAR(adjusted[0], 0.03, 1e-12);
  EXPECT_NEAR(adjusted[1], 0.06, 1e-12);
  EXPECT_NEAR(adjusted[2], 0.06, 1e-12);
  EXPECT_TRUE(std::isnan(adjusted[3]));
}

}  // namespace
}  // namespace ballservo
