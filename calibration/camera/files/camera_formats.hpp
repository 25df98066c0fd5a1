// The formats of camera files.
#pragma once

#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {

/// ViSP's camera XML (vpXmlParserCamera): one or several cameras, each with one or several models, of which
/// the one with distortion is meant. perspectiveProjWithoutDistortion is `pinhole`,
/// perspectiveProjWithDistortion `visp` (kdu is the definition; kud, ViSP's separate approximation of the
/// other direction, is written as the least-squares best over the picture and only compared on reading),
/// ProjWithKannalaBrandtDistortion `kannala_brandt` (its fifth coefficient is unused in ViSP too).
CameraFileFormat visp_camera_format();

/// The kud that comes closest to undoing kdu over the picture of a `visp` camera, in the sense of least
/// squares in pixels.
double best_kud(const CameraParameters& parameters);

/// ROS' camera_info YAML, as camera_calibration writes it and camera_info_manager reads it. plumb_bob is
/// `brown` (`pinhole` where all its coefficients are 0), rational_polynomial `brown8`, equidistant
/// `kannala_brandt`. Rectification, projection, binning and region of interest describe a use of the camera,
/// not its lens: they are checked and left aside.
CameraFileFormat ros_camera_format();

/// OpenCV's camera YAML, as its calibration programs write it through cv::FileStorage: camera_matrix,
/// distortion_coefficients, image_width and image_height, in the spellings of OpenCV's own programs
/// (calibration, interactive-calibration, and those of OpenCV 2). 4, 5 coefficients are `brown` (`pinhole`
/// where all are 0), 8 `brown8`; 12 and 14 (thin prism, tilted sensor) only where the additional ones are 0;
/// with `fisheye_model: 1` the 4 are `kannala_brandt`. A FileStorage may hold anything besides, which is left
/// aside, but for keys that speak of the lens. Read without cv::FileStorage, which takes words for numbers
/// and missing keys for 0.
CameraFileFormat opencv_camera_format();

/// Kalibr's camchain YAML: one or several cameras called cam0, cam1, ... (FILE:cam1 names one). camera_model
/// `pinhole` with distortion_model `none`, `radtan` (k1 k2 p1 p2: `brown` with k3 = 0, `pinhole` where all
/// are 0) or `equidistant` (`kannala_brandt`). Other camera models (omni, ds, eucm) and distortions (fov) are
/// refused by name, and so is writing a `brown` whose k3 is not 0. Poses, delays and topics describe a use of
/// the camera, not its lens, and are left aside. A written camera is cam0, Kalibr's first, whatever its name.
CameraFileFormat kalibr_camera_format();

}  // namespace ballservo
