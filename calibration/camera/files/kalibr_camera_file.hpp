// Kalibr's camchain YAML: one or several cameras called cam0, cam1, ...
#pragma once

#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {

/// camera_model `pinhole` with distortion_model `none`, `radtan` (k1 k2 p1 p2: `brown` with k3 = 0, `pinhole`
/// where all are 0) or `equidistant` (`kannala_brandt`). Other camera models (omni, ds, eucm) and
/// distortions (fov) are refused by name, and so is writing a `brown` whose k3 is not 0. FILE:cam1 names one
/// camera of several. Poses, delays and topics describe a use of
/// the camera, not its lens, and are left aside. A written camera is cam0,
/// Kalibr's first, whatever its name.
CameraFileFormat kalibr_camera_format();

}  // namespace ballservo
