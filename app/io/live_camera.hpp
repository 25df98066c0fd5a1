// A camera on this machine, read by a thread of its own so that the newest picture is the one that is seen.
#pragma once

#include <memory>

#include "app/io/image_source.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {

/// Opens camera `number` (V4L2); a camera that cannot be opened or is too large becomes a fault, and null is
/// returned. `next` waits for a picture newer than the last: drivers queue stale ones, and reading may hang
/// when the camera is unplugged, so it throws InputError after five seconds without any, and ends the
/// sequence on Ctrl-C.
std::unique_ptr<FrameSequence> open_live_camera(int number, double max_pixels, FaultList& faults);

}  // namespace ballservo
