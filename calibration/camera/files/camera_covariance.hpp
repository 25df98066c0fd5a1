// How well a camera's parameters are known: the covariance that `calibrate camera` writes beside the camera
// file.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calibration/camera/camera.hpp"

namespace ballservo {

/// Names of a model's parameters in the order of every covariance: "fx_px", "fy_px", "cx_px", "cy_px",
/// "k1"... (coefficients have no unit).
std::vector<std::string> parameter_names(LensModel model);
/// The parameters in that order, and back.
Eigen::VectorXd parameter_vector(const CameraParameters& parameters);
CameraParameters with_parameter_vector(CameraParameters parameters, const Eigen::VectorXd& vector);

/// The matrix of correlations: parameters differ in size by orders of magnitude. Rows without variance stay.
Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance);

/// "camera.yaml" -> "camera.yaml.covariance.json"; of FILE:NAME, FILE's.
std::string covariance_file_name(const std::string& camera_file);

/// JSON with the parameters' names, values and covariance.
std::string camera_covariance_text(const Camera& camera, const Eigen::MatrixXd& covariance);

/// What stands beside a camera file (FILE or FILE:NAME); nothing where no such file is, or where it was
/// written for other parameters than `camera` has (the camera file was changed since). InputError for a
/// damaged file: not JSON, wrong sizes, not symmetric and positive semi-definite.
std::optional<Eigen::MatrixXd> read_camera_covariance(const std::string& camera_file, const Camera& camera);

}  // namespace ballservo
