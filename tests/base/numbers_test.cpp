#include "calibration/base/numbers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace ballservo {
namespace {

TEST(Numbers, ReadsDecimals) {
  EXPECT_EQ(parse_number("1.5"), 1.5);
  EXPECT_EQ(parse_number(" -2e-3\t"), -2e-3);
  EXPECT_EQ(parse_number("+.5"), 0.5);
  EXPECT_EQ(parse_number("010"), 10.0);
  EXPECT_EQ(parse_integer("010"), 10);
  EXPECT_EQ(parse_integer("-7"), -7);
  EXPECT_EQ(parse_integer("+7"), 7);
}

TEST(Numbers, RefusesEverythingElse) {
  for (const char* text : {"",
                           " ",
                           "nan",
                           "NaN",
                           "inf",
                           "-inf",
                           "infinity",
                           "1e999",
                           "0x10",
                           "1,5",
                           "1.5 2",
                           "1.5m",
                           "--1",
                           "+-1",
                           "+",
                           ".",
                           "1e",
                           ".nan",
                           "1_000",
                           "\xC2\xA0"
                           "1"}) {
    EXPECT_EQ(parse_number(text), std::nullopt) << text;
  }
  for (const char* text : {"", "1.0", "0x10", "0b1", "1e3", "9223372036854775808", "+-1", "1 2", "nan"}) {
    EXPECT_EQ(parse_integer(text), std::nullopt) << text;
  }
}

TEST(Numbers, RoundTripEveryBit) {
  std::mt19937_64 engine(1);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = engine();
    double value = 0;
    std::memcpy(&value, &bits, sizeof value);
    const auto back = parse_number(number_text(value));
    if (!std::isfinite(value)) {
      EXPECT_EQ(number_text(value), "");
    } else {
      ASSERT_TRUE(back) << number_text(value);
      EXPECT_EQ(std::memcmp(&value, &*back, sizeof value), 0) << number_text(value);
    }
  }
  EXPECT_EQ(number_text(std::numeric_limits<double>::infinity()), "");
  EXPECT_EQ(number_text(600.25), "600.25");
}

TEST(NaturalOrder, IsThatOfAPerson) {
  EXPECT_TRUE(natural_less("left2.jpg", "left10.jpg"));
  EXPECT_FALSE(natural_less("left10.jpg", "left2.jpg"));
  EXPECT_TRUE(natural_less("a99999999999999999999998", "a99999999999999999999999"));
  EXPECT_TRUE(natural_less("left", "left1"));
}

TEST(NaturalOrder, IsAStrictWeakOrder) {
  std::mt19937 engine(2);
  std::vector<std::string> names;
  for (int i = 0; i < 60; ++i) {
    std::string name;
    for (int k = 0; k < 4; ++k) name += "01a9.b"[engine() % 6];
    names.push_back(name);
  }
  for (const auto& a : names) {
    EXPECT_FALSE(natural_less(a, a));
    for (const auto& b : names) {
      EXPECT_EQ(a == b, !natural_less(a, b) && !natural_less(b, a)) << a << " " << b;
      for (const auto& c : names) {
        if (natural_less(a, b) && natural_less(b, c)) {
          EXPECT_TRUE(natural_less(a, c)) << a << " " << b << " " << c;
        }
      }
    }
  }
}

}  // namespace
}  // namespace ballservo
