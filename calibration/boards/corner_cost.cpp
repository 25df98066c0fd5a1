#include "calibration/boards/corner_cost.hpp"

#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include <cmath>

#include "calibration/camera/lens/lens_models.hpp"

namespace ballservo {
namespace {

/// Projected minus found position of one corner (px).
template <class Lens>
struct CornerResidual {
  Eigen::Vector3d point;
  Eigen::Vector2d corner_px;

  template <class T>
  bool operator()(const T* camera, const T* pose, T* residual) const {
    const T on_board[3] = {T(point.x()), T(point.y()), T(point.z())};
    T p[3];
    ceres::AngleAxisRotatePoint(pose, on_board, p);
    const Ray3<T> ray{p[0] + pose[3], p[1] + pose[4], p[2] + pose[5]};
    if (Lens::perspective && !(scalar_part(ray.z) > 0)) return false;
    const Position2<T> m = Lens::distort(camera + 4, ray);
    residual[0] = camera[2] + camera[0] * m.x - corner_px.x();
    residual[1] = camera[3] + camera[1] * m.y - corner_px.y();
    return std::isfinite(scalar_part(residual[0])) && std::isfinite(scalar_part(residual[1]));
  }
};

}  // namespace

std::unique_ptr<ceres::CostFunction> corner_cost(LensModel model, const Eigen::Vector3d& point,
                                                 const Eigen::Vector2d& corner_px) {
  return with_lens(model, [&](auto lens) -> std::unique_ptr<ceres::CostFunction> {
    using Lens = decltype(lens);
    using Residual = CornerResidual<Lens>;
    return std::make_unique<ceres::AutoDiffCostFunction<Residual, 2, 4 + lens_coefficient_count<Lens>, 6>>(
        new Residual{point, corner_px});
  });
}

}  // namespace ballservo
