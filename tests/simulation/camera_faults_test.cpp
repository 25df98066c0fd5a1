// The shares and the bursts of dropped frames, and the level of the light.
#include "servo/simulation/robot/camera_faults.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ballservo {
namespace {

constexpr double rate_hz = 30;

CameraFault dropped(double rate, double burst_frames) {
  CameraFault fault;
  fault.rate = rate;
  fault.burst_frames = burst_frames;
  return fault;
}

struct Losses {
  double share = 0, mean_burst = 0;
};

Losses losses(const CameraFault& fault, int frames) {
  CameraFaults faults({fault}, 7);
  int lost = 0, bursts = 0;
  bool before = false;
  for (int k = 0; k < frames; ++k) {
    const bool now = faults.drops(k / rate_hz);
    lost += now;
    bursts += now && !before;
    before = now;
  }
  return {static_cast<double>(lost) / frames, bursts > 0 ? static_cast<double>(lost) / bursts : 0.0};
}

TEST(CameraFaults, DropsTheShareOfFramesInBurstsOfTheLengthThatIsAsked) {
  for (const auto& [rate, burst] : {std::pair{0.1, 1.0}, {0.1, 8.0}, {0.5, 4.0}, {0.8, 10.0}}) {
    const Losses found = losses(dropped(rate, burst), 100000);
    // Frames of a burst hang together: the share's sigma is that of frames / burst independent ones.
    EXPECT_NEAR(found.share, rate, 5 * std::sqrt(rate * (1 - rate) * 2 * burst / 100000)) << rate;
    EXPECT_NEAR(found.mean_burst, burst, 0.1 * burst) << rate;
  }
  EXPECT_EQ(losses(dropped(0.0, 1.0), 1000).share, 0.0);
  EXPECT_EQ(losses(dropped(1.0, 1.0), 1000).share, 1.0);
}

TEST(CameraFaults, LastsFromItsBeginningToItsEnd) {
  CameraFault gap = dropped(1.0, 1.0);
  gap.from_s = 2;
  gap.until_s = 3;
  CameraFaults faults({gap}, 0);
  EXPECT_FALSE(faults.drops(1.999));
  EXPECT_TRUE(faults.drops(2.0));
  EXPECT_TRUE(faults.drops(2.999));
  EXPECT_FALSE(faults.drops(3.0));
}

TEST(CameraFaults, LevelsMultiplyWhereTheyMeet) {
  CameraFault dark, bright;
  dark.kind = bright.kind = CameraFault::Kind::exposure;
  dark.level = 0.25;
  dark.from_s = 1;
  bright.level = 2;
  bright.from_s = 2;
  bright.until_s = 3;
  const CameraFaults faults({dark, bright}, 0);
  EXPECT_EQ(faults.level(0.5), 1.0);
  EXPECT_EQ(faults.level(1.5), 0.25);
  EXPECT_EQ(faults.level(2.5), 0.5);
  EXPECT_EQ(faults.level(3.5), 0.25);
}

TEST(CameraFaults, TheSameSeedLosesTheSameFrames) {
  CameraFaults a({dropped(0.3, 3)}, 1), b({dropped(0.3, 3)}, 1), other({dropped(0.3, 3)}, 2);
  int differ = 0;
  for (int k = 0; k < 300; ++k) {
    const bool lost = a.drops(k / rate_hz);
    EXPECT_EQ(lost, b.drops(k / rate_hz));
    differ += lost != other.drops(k / rate_hz);
  }
  EXPECT_GT(differ, 50);
}

}  // namespace
}  // namespace ballservo
