// What a camera lets one set: exposure, gain, white balance, focus, and the automatics that change them.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace ballservo {

/// Asks a V4L2 device, as ioctl does on its descriptor: 0, or -1 where it refuses.
using V4l2Device = std::function<int(unsigned long request, void* argument)>;

/// The device /dev/videoN, opened beside whoever reads its pictures; one that refuses everything where it
/// can't be opened.
V4l2Device open_v4l2_device(int number);

struct CameraControl {
  std::string name;  ///< "exposure", as in colours files
  double value = 0, minimum = 0, maximum = 0, step = 1;
};

/// Whether all automatics among the settings are off.
bool is_held(const std::map<std::string, double>& settings);

class CameraControls {
 public:
  explicit CameraControls(V4l2Device device);

  /// Those that the camera has, each automatic before what it changes, as they are now.
  std::vector<CameraControl> all() const;
  std::map<std::string, double> values() const;

  /// Sets those that are named, in the order of `all`, and reads them back. What the camera has not, refuses,
  /// or has made something else of is returned in words; empty: it obeyed.
  std::string set(const std::map<std::string, double>& wanted) const;
  /// Switches the automatics off; what they change stays as it is now. Returned as by `set`.
  std::string hold() const;

 private:
  V4l2Device device_;
};

}  // namespace ballservo
