#include "app/comparison/frame_record.hpp"

#include <algorithm>
#include <cmath>

#include "app/comparison/found.hpp"
#include "calibration/base/statistics.hpp"

namespace ballservo {
namespace {

using nlohmann::json;

// The fields of what is noted, in the order of its array.
template <class Outline, class Use>
void fields(Outline& outline, const OutlineEllipse&, Use use) {
  use(outline.center_px.x(), outline.center_px.y(), outline.radius_px);
}
template <class Matrix, class Kind, class Use>
void fields(Matrix& matrix, const Eigen::MatrixBase<Kind>&, Use use) {
  for (auto&& value : matrix.reshaped()) use(value);
}
template <class Fit, class Use>
void fields(Fit& fit, const MethodFit&, Use use) {
  use(fit.outline, fit.p_C, fit.iterations, fit.residual_px, fit.step_px, fit.arc, fit.condition,
      fit.converged, fit.time_us, fit.next_step_px, fit.others, fit.covariance_m2);
}
template <class Truth, class Use>
void fields(Truth& truth, const FrameTruth&, Use use) {
  use(truth.source, truth.frame, truth.has_ball, truth.outline, truth.p_CB, truth.visible_fraction,
      truth.bound_m, truth.bound_depth_m);
}
template <class Facts, class Use>
void fields(Facts& facts, const VoteFacts&, Use use) {
  use(facts.votes, facts.points, facts.quality);
}
template <class Record, class Use>
void fields(Record& record, const ComparisonRecord&, Use use) {
  use(record.truth, record.facts, record.passes, record.fits);
}

// NaN and nothing both become null: neither is a number.
json noted(double value) { return std::isfinite(value) ? json(value) : json(); }
json noted(int value) { return value; }
json noted(bool value) { return value; }
json noted(const std::string& value) { return value; }
template <class T>
json noted(const T& record);
template <class T>
json noted(const std::optional<T>& value) {
  return value ? noted(*value) : json();
}
template <class T>
json noted(const std::vector<T>& values) {
  json list = json::array();
  for (const T& value : values) list.push_back(noted(value));
  return list;
}
template <class T>
json noted(const T& record) {
  json list = json::array();
  fields(record, record, [&](const auto&... field) { (list.push_back(noted(field)), ...); });
  return list;
}

void read_value(const json& from, double& value) { value = from.is_null() ? not_known : from.get<double>(); }
void read_value(const json& from, int& value) { from.get_to(value); }
void read_value(const json& from, bool& value) { from.get_to(value); }
void read_value(const json& from, std::string& value) { from.get_to(value); }
template <class T>
void read_value(const json& from, T& record);
template <class T>
void read_value(const json& from, std::optional<T>& value) {
  if (!from.is_null()) read_value(from, value.emplace());
}
template <class T>
void read_value(const json& from, std::vector<T>& values) {
  for (const json& item : from) read_value(item, values.emplace_back());
}
template <class T>
void read_value(const json& from, T& record) {
  std::size_t place = 0;
  fields(record, record, [&](auto&... field) { (read_value(from.at(place++), field), ...); });
}

}  // namespace

bool at_the_ball(const MethodFit& fit, const FrameTruth& truth) {
  return truth.outline ? is_found(fit.outline, *truth.outline) : truth.has_ball;
}

double apart_px(const MethodFit& a, const MethodFit& b) {
  return std::max((a.outline.center_px - b.outline.center_px).norm(),
                  std::abs(a.outline.radius_px - b.outline.radius_px));
}

json to_json(const ComparisonRecord& record) { return noted(record); }

ComparisonRecord comparison_record_from_json(const json& value) {
  ComparisonRecord record;
  read_value(value, record);
  return record;
}

}  // namespace ballservo
