// A camera on this machine, read by a thread of its own so that the newest picture is the one that is seen.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/io/image_source.hpp"
#include "calibration/base/image_size.hpp"

namespace ballservo {

/// A camera as it is named: "0", "0@1280x720", "0@1280x720@60".
struct CameraMode {
  int number = 0;
  ImageSize size{};    ///< 0: as the camera stands
  double rate_hz = 0;  ///< 0: as the camera stands
};
/// Nothing for a text that names none.
std::optional<CameraMode> parse_camera_mode(const std::string& text);

/// What a camera that was asked for a mode gives instead; empty: it obeyed.
std::string other_mode(const CameraMode& asked, double width_px, double height_px, double rate_hz);

/// Opens a camera (V4L2); throws InputError for one that cannot be opened, is too large or gives another size
/// or rate than it was asked for. `next` waits for a picture newer than the last: drivers queue stale ones,
/// and reading may hang when the camera is unplugged, so it throws InputError after five seconds without any,
/// and ends the sequence on Ctrl-C.
std::unique_ptr<FrameSequence> open_live_camera(const CameraMode& mode, double max_pixels);

}  // namespace ballservo
