#include "app/comparison/frame_record.hpp"

#include <algorithm>
#include <cmath>

#include "app/comparison/found.hpp"
#include "calibration/base/statistics.hpp"

namespace nlohmann {

template <class T>
struct adl_serializer<std::optional<T>> {
  static void to_json(json& to, const std::optional<T>& value) { to = value ? json(*value) : json(); }
  static void from_json(const json& from, std::optional<T>& value) {
    if (!from.is_null()) from.get_to(value.emplace());
  }
};

// Column by column; what is not finite becomes null.
template <int rows, int columns>
struct adl_serializer<Eigen::Matrix<double, rows, columns>> {
  static void to_json(json& to, const Eigen::Matrix<double, rows, columns>& matrix) {
    to = json::array();
    for (const double value : matrix.reshaped()) to.push_back(std::isfinite(value) ? json(value) : json());
  }
  static void from_json(const json& from, Eigen::Matrix<double, rows, columns>& matrix) {
    std::size_t place = 0;
    for (double& value : matrix.reshaped()) {
      const json& number = from.at(place++);
      value = number.is_null() ? ballservo::not_known : number.get<double>();
    }
  }
};

}  // namespace nlohmann

namespace ballservo {

// As a vector, which may hold what is no number.
void to_json(nlohmann::json& to, const OutlineEllipse& outline) {
  to = Eigen::Vector3d(outline.center_px.x(), outline.center_px.y(), outline.radius_px);
}
void from_json(const nlohmann::json& from, OutlineEllipse& outline) {
  const auto values = from.get<Eigen::Vector3d>();
  outline = {values.head<2>(), values.z()};
}
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(MethodFit, outline, p_C, iterations, residual_px, step_px, next_step_px,
                                   arc, condition, converged, covariance_m2, others, time_us)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FrameTruth, source, frame, has_ball, outline, p_CB, visible_fraction,
                                   bound_m, bound_depth_m)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(VoteFacts, votes, points, quality)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ComparisonRecord, truth, facts, passes, fits)

bool at_the_ball(const MethodFit& fit, const FrameTruth& truth) {
  return truth.outline ? is_found(fit.outline, *truth.outline) : truth.has_ball;
}

double apart_px(const MethodFit& a, const MethodFit& b) {
  return std::max((a.outline.center_px - b.outline.center_px).norm(),
                  std::abs(a.outline.radius_px - b.outline.radius_px));
}

nlohmann::json json_of(const ComparisonRecord& record) { return record; }

ComparisonRecord record_from_json(const nlohmann::json& json) { return json.get<ComparisonRecord>(); }

}  // namespace ballservo
