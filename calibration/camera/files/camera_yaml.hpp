// What the camera files in YAML (ROS, OpenCV, Kalibr) have in common.
#pragma once

#include <string>
#include <vector>

#include "calibration/base/strict_yaml.hpp"
#include "calibration/camera/camera.hpp"

namespace ballservo {

/// Ends the reading of a document: the camera's own faults join those of the document (unknown keys too), so
/// that all are seen at once. Throws InputError for any; `place` stands for the file.
Camera finished_camera(StrictYaml& yaml, CameraParameters parameters, const std::string& place);

/// A fault where a camera of another name than the document's is wanted (empty: any).
void check_camera_name(YamlNode& root, const std::string& wanted);

/// A picture's size as a list of two numbers.
void read_sides(YamlNode& node, const std::string& key, ImageSize& size);

/// Sets model and coefficients from k1 k2 p1 p2 [k3] (missing ones are 0): `brown`, or `pinhole` where all
/// are 0.
void set_brown(CameraParameters& parameters, const std::vector<double>& coefficients);

/// Takes a row-major 3 x 3 matrix at `key` as camera matrix; faults for skew, a last row that is not 0 0 1,
/// and focal lengths that are not above 0.
void set_camera_matrix(YamlNode& node, const std::string& key, const std::vector<double>& matrix,
                       CameraParameters& parameters);

/// The 3 x 3 camera matrix, row by row.
std::vector<double> camera_matrix(const CameraParameters& parameters);
/// The model's coefficients; those of `brown` for a `pinhole`.
std::vector<double> coefficients(const CameraParameters& parameters);

/// "[1.0, 2.5]", numbers that every YAML reader takes for floats, with the same double: "535.0", "1.0e-05".
/// (To PyYAML, which ROS' and Kalibr's tools use, 535 is an integer and 1e-05 a text.)
std::string yaml_floats(const std::vector<double>& values);

/// Text in double quotes; control characters are left out.
std::string yaml_quoted(const std::string& text);

}  // namespace ballservo
