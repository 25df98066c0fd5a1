#include "calibration/camera/files/camera_covariance.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <nlohmann/json.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"
#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {
namespace {

constexpr std::size_t max_covariance_file_bytes = 1u << 20;

Eigen::Map<const Eigen::VectorXd> as_vector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

/// Nothing where it was written for another camera.
std::optional<Eigen::MatrixXd> from_json(const nlohmann::json& json, const std::string& place,
                                         const Camera& camera) {
  const auto names = json.at("parameters").get<std::vector<std::string>>();
  const auto values = json.at("values").get<std::vector<double>>();
  const auto rows = json.at("covariance").get<std::vector<std::vector<double>>>();
  const std::size_t count = names.size();
  if (count < 4 || count > 12 || values.size() != count || rows.size() != count)
    throw InputError(place,
                     fmt::format("{} parameters, {} values, {} rows", count, values.size(), rows.size()),
                     "4 to 12, as many of each");
  Eigen::MatrixXd covariance(count, count);
  for (std::size_t i = 0; i < count; ++i) {
    if (rows[i].size() != count)
      throw InputError(place + ": covariance", fmt::format("a row of {} numbers", rows[i].size()),
                       fmt::format("{}", count));
    covariance.row(static_cast<Eigen::Index>(i)) = as_vector(rows[i]).transpose();
  }
  const Eigen::MatrixXd correlation = correlation_of(covariance);
  if (!covariance.allFinite() || !correlation.allFinite() || covariance.diagonal().minCoeff() < 0 ||
      (correlation - correlation.transpose()).cwiseAbs().maxCoeff() > 1e-9 ||
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation).eigenvalues().minCoeff() < -1e-6)
    throw InputError(place + ": covariance", "a matrix that is no covariance",
                     "finite, symmetric, positive semi-definite");
  if (names != parameter_names(camera.parameters().model)) return std::nullopt;
  const Eigen::ArrayXd own = parameter_vector(camera.parameters());
  if (!((as_vector(values).array() - own).abs() <= 1e-9 * (1e-3 + own.abs())).all()) return std::nullopt;
  return covariance;
}

}  // namespace

std::vector<std::string> parameter_names(LensModel model) {
  std::vector<std::string> names{"fx_px", "fy_px", "cx_px", "cy_px"};
  for (std::string& name : coefficient_names(model)) names.push_back(std::move(name));
  return names;
}

Eigen::VectorXd parameter_vector(const CameraParameters& parameters) {
  const int count = coefficient_count(parameters.model);
  Eigen::VectorXd vector = Eigen::VectorXd::Zero(4 + count);
  vector.head<4>() << parameters.fx_px, parameters.fy_px, parameters.cx_px, parameters.cy_px;
  for (int i = 0; i < count; ++i) vector(4 + i) = parameters.coefficients[static_cast<std::size_t>(i)];
  return vector;
}

CameraParameters with_parameter_vector(CameraParameters parameters, const Eigen::VectorXd& vector) {
  parameters.fx_px = vector(0), parameters.fy_px = vector(1);
  parameters.cx_px = vector(2), parameters.cy_px = vector(3);
  for (Eigen::Index i = 4; i < vector.size(); ++i)
    parameters.coefficients[static_cast<std::size_t>(i - 4)] = vector(i);
  return parameters;
}

Eigen::MatrixXd correlation_of(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  Eigen::MatrixXd correlation = covariance;
  for (Eigen::Index i = 0; i < correlation.rows(); ++i)
    for (Eigen::Index j = 0; j < correlation.cols(); ++j)
      if (sigma(i) > 0 && sigma(j) > 0) correlation(i, j) /= sigma(i) * sigma(j);
  return correlation;
}

std::string covariance_file_name(const std::string& camera_file) {
  return split_camera_name(camera_file).file.string() + ".covariance.json";
}

std::string camera_covariance_text(const Camera& camera, const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd values = parameter_vector(camera.parameters());
  nlohmann::ordered_json json;
  json["parameters"] = parameter_names(camera.parameters().model);
  json["values"] = std::vector<double>(values.data(), values.data() + values.size());
  auto& rows = json["covariance"] = nlohmann::ordered_json::array();
  for (const auto& row : covariance.rowwise()) rows.push_back(std::vector<double>(row.begin(), row.end()));
  return json.dump(2) + "\n";
}

std::optional<Eigen::MatrixXd> read_camera_covariance(const std::string& camera_file, const Camera& camera) {
  const std::string place = covariance_file_name(camera_file);
  std::error_code ignored;
  if (!std::filesystem::exists(place, ignored)) return std::nullopt;
  const std::string text = read_file_bytes(place, max_covariance_file_bytes);
  try {
    const CameraFileName name = split_camera_name(camera_file);
    if (!name.scaled_to) return from_json(nlohmann::json::parse(text), place, camera);
    const Camera own =
        read_camera(name.file.string() + (name.camera_name.empty() ? "" : ":" + name.camera_name));
    const auto known = from_json(nlohmann::json::parse(text), place, own);
    if (!known) return std::nullopt;
    Eigen::VectorXd scale = Eigen::VectorXd::Ones(known->rows());
    scale(0) = scale(2) = static_cast<double>(camera.size().width_px) / own.size().width_px;
    scale(1) = scale(3) = static_cast<double>(camera.size().height_px) / own.size().height_px;
    return scale.asDiagonal() * *known * scale.asDiagonal();
  } catch (const nlohmann::json::parse_error& error) {
    throw InputError(place, fmt::format("no JSON at byte {}", error.byte),
                     "a covariance as `calibrate camera` writes it");
  } catch (const nlohmann::json::exception&) {
    throw InputError(place, "JSON of another kind", "a covariance as `calibrate camera` writes it");
  }
}

}  // namespace ballservo
