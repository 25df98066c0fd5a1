#include "app/io/camera_controls.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include "calibration/base/system_file.hpp"

namespace ballservo {
namespace {

struct KnownControl {
  const char* name;
  std::uint32_t id;
  std::optional<int> off{};  // of an automatic: its value when it changes nothing
};

/// Each automatic before what it changes.
constexpr KnownControl known_controls[] = {
    {"auto_exposure", V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL},
    {"auto_rate", V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0},
    {"exposure", V4L2_CID_EXPOSURE_ABSOLUTE},
    {"auto_gain", V4L2_CID_AUTOGAIN, 0},
    {"gain", V4L2_CID_GAIN},
    {"auto_white_balance", V4L2_CID_AUTO_WHITE_BALANCE, 0},
    {"white_balance_k", V4L2_CID_WHITE_BALANCE_TEMPERATURE},
    {"auto_focus", V4L2_CID_FOCUS_AUTO, 0},
    {"focus", V4L2_CID_FOCUS_ABSOLUTE},
    {"saturation", V4L2_CID_SATURATION},
    {"gamma", V4L2_CID_GAMMA},
};

}  // namespace

bool is_held(const std::map<std::string, double>& settings) {
  return std::all_of(std::begin(known_controls), std::end(known_controls), [&](const KnownControl& known) {
    const auto found = settings.find(known.name);
    return !known.off || found == settings.end() || found->second == *known.off;
  });
}

V4l2Device open_v4l2_device(int number) {
  const int descriptor = ::open(fmt::format("/dev/video{}", number).c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return [](unsigned long, void*) { return -1; };
  return [device = std::make_shared<Descriptor>(descriptor)](unsigned long request, void* argument) {
    return ::ioctl(device->number(), request, argument);
  };
}

CameraControls::CameraControls(V4l2Device device) : device_(std::move(device)) {}

std::vector<CameraControl> CameraControls::all() const {
  std::vector<CameraControl> present;
  for (const KnownControl& known : known_controls) {
    v4l2_queryctrl range{};
    range.id = known.id;
    v4l2_control now{known.id, 0};
    if (device_(VIDIOC_QUERYCTRL, &range) != 0 || (range.flags & V4L2_CTRL_FLAG_DISABLED) != 0 ||
        device_(VIDIOC_G_CTRL, &now) != 0)
      continue;
    present.push_back({known.name, static_cast<double>(now.value), static_cast<double>(range.minimum),
                       static_cast<double>(range.maximum), static_cast<double>(range.step)});
  }
  return present;
}

std::map<std::string, double> CameraControls::values() const {
  std::map<std::string, double> values;
  for (const CameraControl& control : all()) values[control.name] = control.value;
  return values;
}

std::string CameraControls::set(const std::map<std::string, double>& wanted) const {
  for (const KnownControl& known : known_controls) {
    const auto found = wanted.find(known.name);
    if (found == wanted.end() || !(std::abs(found->second) < 1e9)) continue;
    v4l2_control control{known.id, static_cast<std::int32_t>(std::lround(found->second))};
    device_(VIDIOC_S_CTRL, &control);  // whether it obeyed, reading it tells
  }
  const std::map<std::string, double> now = values();
  std::string ignored;
  for (const auto& [name, value] : wanted) {
    const auto found = now.find(name);
    if (found != now.end() && found->second == value) continue;
    ignored += fmt::format("{}{} {:g}: ", ignored.empty() ? "" : "; ", name, value);
    ignored += found == now.end() ? "the camera has none" : fmt::format("it stays at {:g}", found->second);
  }
  return ignored;
}

std::string CameraControls::hold() const {
  std::map<std::string, double> held = values();
  for (const KnownControl& known : known_controls) {
    if (const auto found = held.find(known.name); known.off && found != held.end())
      found->second = *known.off;
  }
  return set(held);
}

}  // namespace ballservo
