#include "app/comparison/frame_record.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "app/comparison/found.hpp"

namespace ballservo {
namespace {

using nlohmann::json;

// NaN and nothing both become null: neither is a number.
json number(double value) { return std::isfinite(value) ? json(value) : json(); }
template <class T>
json optional_number(const std::optional<T>& value) {
  return value ? number(static_cast<double>(*value)) : json();
}
std::optional<double> optional_from(const json& value) {
  return value.is_null() ? std::nullopt : std::optional<double>(value.get<double>());
}
double number_from(const json& value) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

json outline_json(const OutlineEllipse& outline) {
  return json::array(
      {number(outline.center_px.x()), number(outline.center_px.y()), number(outline.radius_px)});
}
OutlineEllipse outline_from(const json& value) {
  return {{number_from(value.at(0)), number_from(value.at(1))}, number_from(value.at(2))};
}
json vector_json(const Eigen::Vector3d& v) {
  return json::array({number(v.x()), number(v.y()), number(v.z())});
}
Eigen::Vector3d vector_from(const json& value) {
  return {number_from(value.at(0)), number_from(value.at(1)), number_from(value.at(2))};
}

json covariance_json(const std::optional<Eigen::Matrix3d>& covariance) {
  if (!covariance) return {};
  return std::vector<double>(covariance->data(), covariance->data() + 9);
}
std::optional<Eigen::Matrix3d> covariance_from(const json& value) {
  if (value.is_null()) return std::nullopt;
  const auto values = value.get<std::array<double, 9>>();
  return Eigen::Map<const Eigen::Matrix3d>(values.data());
}

json fit_json(const MethodFit& fit) {
  return json::array({outline_json(fit.outline), vector_json(fit.p_C), optional_number(fit.iterations),
                      optional_number(fit.residual_px), optional_number(fit.step_px),
                      optional_number(fit.arc), optional_number(fit.condition),
                      optional_number(fit.converged), number(fit.time_us), optional_number(fit.next_step_px),
                      fit.others, covariance_json(fit.covariance_m2)});
}

MethodFit fit_from(const json& value) {
  MethodFit fit;
  fit.outline = outline_from(value.at(0));
  fit.p_C = vector_from(value.at(1));
  if (!value.at(2).is_null()) fit.iterations = value.at(2).get<int>();
  fit.residual_px = optional_from(value.at(3));
  fit.step_px = optional_from(value.at(4));
  fit.arc = optional_from(value.at(5));
  fit.condition = optional_from(value.at(6));
  if (const auto converged = optional_from(value.at(7))) fit.converged = *converged != 0;
  fit.time_us = number_from(value.at(8));
  fit.next_step_px = optional_from(value.at(9));
  fit.others = value.at(10).get<int>();
  fit.covariance_m2 = covariance_from(value.at(11));
  return fit;
}

}  // namespace

bool at_the_ball(const MethodFit& fit, const FrameTruth& truth) {
  return truth.outline ? is_found(fit.outline, *truth.outline) : truth.has_ball;
}

double apart_px(const MethodFit& a, const MethodFit& b) {
  return std::max((a.outline.center_px - b.outline.center_px).norm(),
                  std::abs(a.outline.radius_px - b.outline.radius_px));
}

json to_json(const ComparisonRecord& record) {
  const FrameTruth& truth = record.truth;
  json fits = json::array();
  for (const auto& fit : record.fits) fits.push_back(fit ? fit_json(*fit) : json());
  json value = {{"source", truth.source},
                {"frame", truth.frame},
                {"visible", optional_number(truth.visible_fraction)},
                {"bound", optional_number(truth.bound_m)},
                {"bound_depth", optional_number(truth.bound_depth_m)},
                {"passes", record.passes},
                {"fits", std::move(fits)}};
  if (!truth.has_ball) value["no_ball"] = true;
  if (truth.outline) value["outline"] = outline_json(*truth.outline);
  if (truth.p_CB) value["p_CB"] = vector_json(*truth.p_CB);
  if (record.facts) value["vote"] = {record.facts->votes, record.facts->points, record.facts->quality};
  return value;
}

ComparisonRecord comparison_record_from_json(const json& value) {
  ComparisonRecord record;
  FrameTruth& truth = record.truth;
  truth.source = value.at("source").get<std::string>();
  truth.frame = value.at("frame").get<int>();
  truth.has_ball = !value.contains("no_ball");
  truth.visible_fraction = optional_from(value.at("visible"));
  truth.bound_m = optional_from(value.at("bound"));
  truth.bound_depth_m = optional_from(value.at("bound_depth"));
  if (value.contains("outline")) truth.outline = outline_from(value.at("outline"));
  if (value.contains("p_CB")) truth.p_CB = vector_from(value.at("p_CB"));
  if (value.contains("vote")) {
    const json& vote = value.at("vote");
    record.facts = VoteFacts{vote.at(0).get<int>(), vote.at(1).get<int>(), vote.at(2).get<double>()};
  }
  record.passes = value.at("passes").get<int>();
  for (const json& fit : value.at("fits"))
    record.fits.push_back(fit.is_null() ? std::nullopt : std::optional<MethodFit>(fit_from(fit)));
  return record;
}

}  // namespace ballservo
