#include "calibration/camera/camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "calibration/base/fault.hpp"
#include "calibration/camera/lens/lens_domain.hpp"
#include "calibration/camera/lens/lens_models.hpp"

namespace ballservo {
namespace {

constexpr double half_pi = 1.5707963267948966;
constexpr int max_side_px = 65536;

void check(const CameraParameters& parameters, const std::string& place) {
  FaultList faults;
  const auto fault = [&](const char* name, auto found, std::string allowed) {
    faults.add(fmt::format("{}: {}", place, name), fmt::format("{}", found), std::move(allowed));
  };
  const auto [width_px, height_px] = parameters.size;
  for (const auto& [name, side_px] : {std::pair{"image width", width_px}, {"image height", height_px}})
    if (side_px < 1 || side_px > max_side_px) fault(name, side_px, fmt::format("1 to {} (px)", max_side_px));
  for (const auto& [name, focal_px] : {std::pair{"fx_px", parameters.fx_px}, {"fy_px", parameters.fy_px}})
    if (!std::isfinite(focal_px) || focal_px <= 0) fault(name, focal_px, "a finite number above 0 (px)");
  const double margin_px = std::clamp(std::max(width_px, height_px), 1, max_side_px);
  for (const auto& [name, position_px, side_px] :
       {std::tuple{"cx_px", parameters.cx_px, width_px}, {"cy_px", parameters.cy_px, height_px}})
    if (!(position_px >= -margin_px && position_px <= side_px + margin_px))
      fault(name, position_px,
            fmt::format("{} to {} (px): no further from the picture than its larger side", -margin_px,
                        side_px + margin_px));
  const auto names = coefficient_names(parameters.model);
  for (std::size_t i = 0; i < parameters.coefficients.size(); ++i) {
    const double value = parameters.coefficients[i];
    if (i < names.size() && !std::isfinite(value)) fault(names[i].c_str(), value, "a finite number");
    if (i >= names.size() && value != 0)
      fault("coefficients", fmt::format("{} as number {}", value, i + 1),
            fmt::format("{} coefficients for the model {}", names.size(), lens_model_name(parameters.model)));
  }
  faults.throw_if_any();
}

}  // namespace

std::string_view lens_model_name(LensModel model) {
  return with_lens(model, [](auto lens) { return decltype(lens)::name; });
}

std::optional<LensModel> lens_model_from_name(std::string_view name) {
  for (const LensModel model : all_lens_models)
    if (lens_model_name(model) == name) return model;
  return std::nullopt;
}

int coefficient_count(LensModel model) {
  return with_lens(model, [](auto lens) { return lens_coefficient_count<decltype(lens)>; });
}

std::vector<std::string> coefficient_names(LensModel model) {
  return with_lens(model, [](auto lens) {
    const auto& names = decltype(lens)::coefficient_names;
    return std::vector<std::string>(names.begin(), names.end());
  });
}

Camera::Camera(const CameraParameters& parameters, const std::string& place) : parameters_(parameters) {
  check(parameters, place);
  domain_ = find_lens_domain(parameters.model, parameters.coefficients.data());
}

double Camera::focal_px() const { return std::sqrt(parameters_.fx_px * parameters_.fy_px); }

bool Camera::may_appear(const Eigen::Vector3d& p_C) const {
  if (!p_C.allFinite()) return false;
  if (max_angle_rad() == half_pi) return p_C.z() > 0;
  if (max_angle_rad() < half_pi && !(p_C.z() > 0)) return false;
  return std::atan2(std::hypot(p_C.x(), p_C.y()), p_C.z()) < max_angle_rad();
}

std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& p_C) const {
  if (!may_appear(p_C)) return std::nullopt;
  const auto position = with_lens(parameters_.model, [&](auto lens) {
    return decltype(lens)::distort(parameters_.coefficients.data(), Ray3<double>{p_C.x(), p_C.y(), p_C.z()});
  });
  const Eigen::Vector2d pixel(parameters_.cx_px + parameters_.fx_px * position.x,
                              parameters_.cy_px + parameters_.fy_px * position.y);
  if (!pixel.allFinite()) return std::nullopt;
  return pixel;
}

std::optional<Eigen::Vector3d> Camera::unproject(const Eigen::Vector2d& pixel_px,
                                                 std::optional<Eigen::Vector3d> nearby_ray) const {
  const Eigen::Vector2d position((pixel_px.x() - parameters_.cx_px) / parameters_.fx_px,
                                 (pixel_px.y() - parameters_.cy_px) / parameters_.fy_px);
  const auto ray =
      parameters_.model == LensModel::pinhole  // nothing to solve
          ? Eigen::Vector3d(position.x(), position.y(), 1)
          : solve_ray(parameters_.model, parameters_.coefficients.data(), domain_, position, nearby_ray);
  if (!ray) return std::nullopt;
  const Eigen::Vector3d unit = ray->normalized();
  if (!unit.allFinite() || !may_appear(unit)) return std::nullopt;
  return unit;
}

std::optional<Eigen::Matrix<double, 2, 3>> Camera::project_jacobian(const Eigen::Vector3d& p_C) const {
  if (!may_appear(p_C)) return std::nullopt;
  using T = Dual<3>;
  const Ray3<T> ray{T::variable(p_C.x(), 0), T::variable(p_C.y(), 1), T::variable(p_C.z(), 2)};
  const auto position = with_lens(parameters_.model, [&](auto lens) {
    using Lens = decltype(lens);
    return Lens::distort(lens_constants<Lens, T>(parameters_.coefficients.data()).data(), ray);
  });
  Eigen::Matrix<double, 2, 3> jacobian;
  jacobian.row(0) = parameters_.fx_px * position.x.v;
  jacobian.row(1) = parameters_.fy_px * position.y.v;
  if (!jacobian.allFinite()) return std::nullopt;
  return jacobian;
}

Camera long_lens_camera(ImageSize size) {
  CameraParameters parameters;
  parameters.size = size;
  parameters.fx_px = parameters.fy_px = 1e4 * size.width_px;
  parameters.cx_px = 0.5 * (size.width_px - 1);
  parameters.cy_px = 0.5 * (size.height_px - 1);
  return Camera(parameters, "picture");
}

}  // namespace ballservo
