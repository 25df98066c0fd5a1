// A camera's settings: read, set, held, and what the camera makes of it, on a device that answers as V4L2
// does.
#include "app/io/camera_controls.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <atomic>
#include <future>
#include <memory>
#include <thread>

#include "app/commands/command.hpp"
#include "app/io/live_camera.hpp"
#include "app/live/footage_session.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;
using namespace std::chrono_literals;

/// As many webcams: exposure and white balance are fixed while their automatics are on, gain can't be set.
struct FakeDevice {
  std::map<std::uint32_t, int> values = {{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY},
                                         {V4L2_CID_EXPOSURE_ABSOLUTE, 157},
                                         {V4L2_CID_GAIN, 16},
                                         {V4L2_CID_AUTO_WHITE_BALANCE, 1},
                                         {V4L2_CID_WHITE_BALANCE_TEMPERATURE, 4600}};

  int ask(unsigned long request, void* argument) {
    auto* const id = static_cast<std::uint32_t*>(argument);  // both structs begin with it
    if (values.count(*id) == 0) return -1;
    if (request == VIDIOC_QUERYCTRL) {
      static_cast<v4l2_queryctrl*>(argument)->maximum = 5000;
      return 0;
    }
    auto* const control = static_cast<v4l2_control*>(argument);
    if (request == VIDIOC_G_CTRL) return control->value = values[*id], 0;
    const bool fixed =
        *id == V4L2_CID_GAIN ||
        (*id == V4L2_CID_EXPOSURE_ABSOLUTE && values[V4L2_CID_EXPOSURE_AUTO] != V4L2_EXPOSURE_MANUAL) ||
        (*id == V4L2_CID_WHITE_BALANCE_TEMPERATURE && values[V4L2_CID_AUTO_WHITE_BALANCE] == 1);
    if (request != VIDIOC_S_CTRL || fixed) return -1;
    return values[*id] = control->value, 0;
  }
};

CameraControls controls_of(const std::shared_ptr<FakeDevice>& device) {
  return CameraControls(
      [device](unsigned long request, void* argument) { return device->ask(request, argument); });
}

TEST(CameraMode, IsReadFromTheName) {
  const auto mode = parse_camera_mode("3@1280x720@59.94");
  ASSERT_TRUE(mode);
  EXPECT_EQ(mode->number, 3);
  EXPECT_EQ(mode->size, (ImageSize{1280, 720}));
  EXPECT_EQ(mode->rate_hz, 59.94);
  EXPECT_EQ(parse_camera_mode("0")->size, ImageSize{});
  for (const char* text : {"", "256", "-1", "0@", "0@640", "0@0x480", "0@640x480@", "0@640x480@0",
                           "0@640x480@1.2.3", "0@@30", "0@640x480@30@1", "0 @640x480"})
    EXPECT_FALSE(parse_camera_mode(text)) << text;
}

TEST(CameraMode, WhatTheCameraGivesInsteadIsSaid) {
  const CameraMode asked = *parse_camera_mode("0@1280x720@30");
  EXPECT_EQ(other_mode(asked, 1280, 720, 29.97), "");
  EXPECT_EQ(other_mode(*parse_camera_mode("0"), 640, 480, 15), "");
  EXPECT_EQ(other_mode(asked, 640, 480, 30), "640 x 480 pixels at 30 Hz");
  EXPECT_EQ(other_mode(asked, 1280, 720, 10), "1280 x 720 pixels at 10 Hz");
}

TEST(CameraControls, AreReadFromTheDevice) {
  const CameraControls controls = controls_of(std::make_shared<FakeDevice>());
  const auto all = controls.all();
  ASSERT_EQ(all.size(), 5u);
  EXPECT_EQ(all[0].name, "auto_exposure");
  EXPECT_EQ(all[1].name, "exposure");
  EXPECT_EQ(all[1].value, 157);
  EXPECT_EQ(all[1].maximum, 5000);
  EXPECT_FALSE(is_held(controls.values()));
  EXPECT_TRUE(CameraControls(open_v4l2_device(-1)).all().empty());
}

TEST(CameraControls, WhatTheCameraIgnoresIsSaid) {
  const CameraControls controls = controls_of(std::make_shared<FakeDevice>());
  EXPECT_THAT(controls.set({{"exposure", 300}}), HasSubstr("exposure 300: it stays at 157")) << "automatic";
  EXPECT_EQ(controls.set({{"exposure", 300}, {"auto_exposure", 1}}), "") << "the automatic is set first";
  EXPECT_THAT(controls.set({{"gain", 5}}), HasSubstr("it stays at 16"));
  EXPECT_THAT(controls.set({{"focus", 5}}), HasSubstr("the camera has none"));
  EXPECT_NE(controls.set({{"exposure", std::nan("")}}), "");
}

TEST(CameraControls, HoldFixesThemAsTheyAre) {
  const auto device = std::make_shared<FakeDevice>();
  const CameraControls controls = controls_of(device);
  const auto before = controls.values();
  EXPECT_EQ(controls.hold(), "");
  EXPECT_TRUE(is_held(controls.values()));
  EXPECT_EQ(controls.values().at("exposure"), before.at("exposure"));
  EXPECT_EQ(controls.values().at("white_balance_k"), before.at("white_balance_k"));
}

/// Shows one picture over and over until it is unplugged.
class FakeCamera : public FrameSequence {
 public:
  FakeCamera(std::shared_ptr<FakeDevice> device, std::shared_ptr<std::atomic<bool>> unplugged)
      : controls_(controls_of(device)), unplugged_(std::move(unplugged)) {}
  std::optional<Frame> next() override {
    if (unplugged_->exchange(false))
      throw InputError("camera:7", "a camera that has gone", "one that is there");
    std::this_thread::sleep_for(5ms);
    return Frame{cv::Mat(60, 80, CV_8UC3, cv::Scalar(90, 90, 90)), "camera:7", index_, 0.005 * index_++};
  }
  std::string name() const override { return "camera:7"; }
  long length() const override { return 0; }
  const CameraControls* controls() const override { return &controls_; }

 private:
  CameraControls controls_;
  std::shared_ptr<std::atomic<bool>> unplugged_;
  int index_ = 0;
};

TEST(CameraInThePage, IsSetAndHeldAndSetAgainWhenItComesBack) {
  const auto unplugged = std::make_shared<std::atomic<bool>>(false);
  auto device = std::make_shared<FakeDevice>();
  test::TemporaryFolder temporary;
  FootageOptions options;
  options.source = "camera:7";
  options.max_pixels = 1e7;
  options.record = temporary.path() / "kept";
  options.last_s = 30;
  options.open = [&] { return std::make_unique<FakeCamera>(device, unplugged); };
  BallOptions balls;
  balls.taught = false;
  LiveExchange exchange;
  FootageSession session(options, DetectorFactory(balls, CommonOptions()), exchange);
  std::thread thread([&] { session.run(); });
  const auto ask = [&](const Json& what) {
    std::promise<Json> answer;
    exchange.put({what, [&](const Json& said) { answer.set_value(said); }});
    return answer.get_future().get();
  };
  const auto state = [&] {
    while (!exchange.newest()) std::this_thread::sleep_for(1ms);
    return Json::parse(exchange.newest()->state);
  };
  EXPECT_EQ(ask({{"do", "camera"}})["controls"].size(), 5u);
  EXPECT_EQ(state()["camera"], true);
  EXPECT_THAT(ask({{"do", "camera"}, {"name", "exposure"}, {"value", 90}})["ignored"],
              HasSubstr("exposure 90"));
  EXPECT_EQ(ask({{"do", "hold"}})["ignored"], "");
  EXPECT_EQ(ask({{"do", "camera"}, {"name", "exposure"}, {"value", 90}})["ignored"], "");
  EXPECT_EQ(device->values[V4L2_CID_EXPOSURE_ABSOLUTE], 90);

  while (state()["recent_s"].get<double>() <= 0) std::this_thread::sleep_for(1ms);
  for (const char* folder : {"kept", "kept_2"}) {
    Json kept = ask({{"do", "keep"}});
    while (kept.contains("refused")) kept = ask({{"do", "keep"}});  // the one before may not have ended yet
    EXPECT_EQ(recorded_pictures(temporary.path() / folder).size(), kept["pictures"].get<std::size_t>())
        << kept;
  }
  EXPECT_THAT(read_file_bytes(temporary.path() / "kept/settings.json", 10000), HasSubstr("\"exposure\": 90"));

  ask({{"do", "pause"}});  // while another takes its place
  device = std::make_shared<FakeDevice>();
  *unplugged = true;
  ask({{"do", "pause"}});
  const auto end = std::chrono::steady_clock::now() + 20s;
  while (!is_held(controls_of(device).values()) && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(5ms);
  ask({{"do", "end"}});
  thread.join();
  EXPECT_EQ(device->values[V4L2_CID_EXPOSURE_ABSOLUTE], 90);
  EXPECT_EQ(device->values[V4L2_CID_EXPOSURE_AUTO], V4L2_EXPOSURE_MANUAL);
}

}  // namespace
}  // namespace ballservo
