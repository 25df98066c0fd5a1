#include <gtest/gtest.h>

#include <algorithm>

#include "calibration/base/random.hpp"
#include "servo/avoidance/sonar.hpp"

namespace ballservo {
namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();

SensorStamps all_at(double time_s) {
  SensorStamps stamps;
  stamps.frame_s = stamps.step_s = time_s;
  stamps.array_heard_s = {time_s, time_s};
  stamps.looked_s.fill(time_s);
  return stamps;
}

TEST(Guard, LetsEverythingPassWhenAllIsWell) {
  const GuardVerdict verdict = guard(10, all_at(10), {});
  EXPECT_FALSE(verdict.stop);
  EXPECT_TRUE(verdict.forward && verdict.backward);
  EXPECT_EQ(verdict.reason, "");
}

// A thousand random instants: the rules, said once more in other words.
TEST(Guard, KeepsItsRulesAtAnyInstant) {
  RandomEngine engine = random_stream(0, "guard");
  int stops = 0, passes = 0;
  for (int k = 0; k < 1000; ++k) {
    const double now_s = uniform(engine, 0, 100);
    SensorStamps stamps = all_at(now_s);
    stamps.frame_s -= uniform(engine, 0, 0.25);
    stamps.step_s -= uniform(engine, 0, 0.11);
    for (double& heard_s : stamps.array_heard_s) heard_s -= uniform(engine, 0, 0.14);
    for (double& looked_s : stamps.looked_s) looked_s -= uniform(engine, 0, 0.72);
    const GuardVerdict verdict = guard(now_s, stamps, {});
    EXPECT_EQ(verdict.stop, now_s - stamps.frame_s > 0.2 || now_s - stamps.step_s > 0.1);
    const double silence_s =
        now_s - *std::min_element(stamps.array_heard_s.begin(), stamps.array_heard_s.end());
    double oldest_look_s = 0;
    for (const int ahead : {2, 3, 4, 5})
      oldest_look_s = std::max(oldest_look_s, now_s - stamps.looked_s[ahead]);
    if (verdict.forward) {
      EXPECT_LE(silence_s, 0.12);
      EXPECT_LE(oldest_look_s, 0.7);
    } else {
      EXPECT_TRUE(verdict.stop || silence_s > 0.12 || oldest_look_s > 0.7);
    }
    stops += verdict.stop ? 1 : 0;
    passes += verdict.forward ? 1 : 0;
    EXPECT_EQ(verdict.reason.empty(), verdict.forward && verdict.backward);
  }
  EXPECT_GT(stops, 50);
  EXPECT_GT(passes, 200);
}

TEST(Guard, StopsOnClocksAndStampsThatCannotBe) {
  EXPECT_TRUE(guard(nan, all_at(10), {}).stop);
  EXPECT_TRUE(guard(10, SensorStamps{}, {}).stop);
  SensorStamps stamps = all_at(10);
  stamps.frame_s = nan;
  EXPECT_TRUE(guard(10, stamps, {}).stop);
  stamps.frame_s = 11;
  EXPECT_TRUE(guard(10, stamps, {}).stop);
  stamps = all_at(10);
  stamps.looked_s[4] = nan;
  EXPECT_FALSE(guard(10, stamps, {}).forward);
}

TEST(Guard, AsksNothingOfSonarsWhereThereAreNone) {
  SensorStamps stamps;
  stamps.frame_s = stamps.step_s = 10;
  GuardOptions options;
  options.sonars = false;
  EXPECT_TRUE(guard(10.1, stamps, options).forward);
  EXPECT_TRUE(guard(10.11, stamps, options).stop) << "the controller is silent";
}

TEST(SonarWatch, BelievesWhatIsInTimeAndNothingElse) {
  SonarWatch watch;
  EXPECT_TRUE(watch.hear({1.0, 3, 2.0, true}, 1.05, 0));
  EXPECT_EQ(watch.stamps().looked_s[3], 1.0);
  EXPECT_FALSE(watch.hear({1.0, 4, 2.0, true}, 1.5, 0));
  EXPECT_EQ(watch.stamps().looked_s[4], SensorStamps::never);
  EXPECT_EQ(watch.stamps().array_heard_s[0], 1.5) << "late, but not silent";
  EXPECT_FALSE(watch.hear({2.0, 5, 2.0, true}, 1.9, 0)) << "from the future";
  EXPECT_FALSE(watch.hear({1.9, 16, 2.0, true}, 1.9, 0));
  EXPECT_FALSE(watch.hear({1.9, 5, nan, true}, 1.9, 0));
  EXPECT_FALSE(watch.hear({nan, 5, 2.0, true}, 1.9, 0));
}

TEST(SonarWatch, FindsAStuckSonarWhileTheRobotMoves) {
  SonarWatch watch;
  for (int k = 0; k < 20; ++k) {
    const double now_s = 0.32 * k;
    EXPECT_TRUE(watch.hear({now_s, 3, 2.0, true}, now_s, 0.0)) << "the robot rests: nothing need change";
  }
  int believed = 0;
  for (int k = 0; k < 20; ++k) {
    const double now_s = 10 + 0.32 * k;
    believed += watch.hear({now_s, 5, 2.0, true}, now_s, 0.02 * k) ? 1 : 0;
    EXPECT_TRUE(watch.hear({now_s, 4, 2.0 - 0.02 * k, true}, now_s, 0.02 * k));
    EXPECT_TRUE(watch.hear({now_s, 2, 5.0, false}, now_s, 0.02 * k)) << "open space looks the same";
  }
  EXPECT_LE(believed, 4);
  EXPECT_TRUE(watch.hear({20, 5, 1.9, true}, 20, 0.5)) << "it changes again";
  EXPECT_TRUE(watch.hear({20.3, 5, 1.8, true}, 20.3, 0.6)) << "and goes on changing";
}

}  // namespace
}  // namespace ballservo
