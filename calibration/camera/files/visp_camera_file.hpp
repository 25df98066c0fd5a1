// ViSP's camera XML (vpXmlParserCamera): one or several cameras, each with one or several models.
#pragma once

#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {

/// perspectiveProjWithoutDistortion is `pinhole`, perspectiveProjWithDistortion `visp` (kdu is the
/// definition; kud, ViSP's separate approximation of the other direction, is written as the least-squares
/// best over the picture and only compared on reading), ProjWithKannalaBrandtDistortion `kannala_brandt` (its
/// fifth coefficient is unused in ViSP too). Where a camera has several models the one with distortion is
/// meant.
CameraFileFormat visp_camera_format();

/// The kud that comes closest to undoing kdu over the picture of a `visp` camera, in the sense of least
/// squares in pixels.
double best_kud(const CameraParameters& parameters);

}  // namespace ballservo
