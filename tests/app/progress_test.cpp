#include "app/io/progress.hpp"

#include <gtest/gtest.h>

namespace ballservo {
namespace {

TEST(Progress, SaysNoTimeLeftBeforeItCanBeKnown) {
  EXPECT_FALSE(time_left_s(1.4, 2, 486));    // the first pictures, while the program is still warming up
  EXPECT_FALSE(time_left_s(1.4, 200, 486));  // soon, and soon over
  EXPECT_FALSE(time_left_s(5, 2, 486));
  EXPECT_FALSE(time_left_s(60, 0, 486));
  EXPECT_FALSE(time_left_s(60, 486, 486));
  EXPECT_DOUBLE_EQ(time_left_s(6, 54, 486).value(), 48);
  EXPECT_DOUBLE_EQ(time_left_s(60, 1, 101).value(), 6000);  // long work is not silent for hours
}

}  // namespace
}  // namespace ballservo
