#include "app/offline/comparison_statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "calibration/files/numbers.hpp"

namespace ballservo {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? nan : sum / static_cast<double>(values.size());
}

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? nan : std::sqrt(sum / static_cast<double>(values.size()));
}

double largest(const std::vector<double>& values) {
  return values.empty() ? nan : *std::max_element(values.begin(), values.end());
}

std::size_t index_of(const std::vector<FitMethod>& methods, FitMethod method) {
  return static_cast<std::size_t>(std::find(methods.begin(), methods.end(), method) - methods.begin());
}

std::string optional_text(const std::optional<double>& value) { return value ? number_text(*value) : ""; }

}  // namespace

double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return nan;
  std::sort(values.begin(), values.end());
  const double place = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

MethodStatistics method_statistics(const ConditionResult& condition, std::size_t method) {
  MethodStatistics statistics;
  statistics.frames = static_cast<int>(condition.frames.size());
  std::vector<double> centers, radii, positions, depths, laterals, times;
  for (const ComparisonFrame& frame : condition.frames) {
    const auto& fit = frame.fits[method];
    if (fit) times.push_back(fit->time_us);
    if (!fit || !at_the_ball(*fit, frame.truth)) continue;
    ++statistics.found;
    centers.push_back((fit->outline.center_px - frame.truth.outline->center_px).norm());
    radii.push_back(fit->outline.radius_px - frame.truth.outline->radius_px);
    const Eigen::Vector3d error_mm = 1000 * (fit->p_C - frame.truth.p_CB);
    positions.push_back(error_mm.norm());
    depths.push_back(error_mm.z());
    const Eigen::Vector2d across = frame.truth.p_CB.head<2>();
    if (across.norm() > 0) laterals.push_back(error_mm.head<2>().dot(across.normalized()));
  }
  statistics.failed = statistics.frames - statistics.found;
  statistics.center_rms_px = root_mean_square(centers);
  statistics.radius_bias_px = mean(radii);
  statistics.radius_rms_px = root_mean_square(radii);
  statistics.position_median_mm = quantile(positions, 0.5);
  statistics.position_p90_mm = quantile(positions, 0.9);
  statistics.position_rms_mm = root_mean_square(positions);
  statistics.depth_bias_mm = mean(depths);
  statistics.lateral_bias_mm = mean(laterals);
  statistics.time_us_median = quantile(times, 0.5);
  return statistics;
}

std::vector<MethodPair> one_step_pairs(const std::vector<FitMethod>& methods) {
  constexpr std::array<MethodPair, 2> all{{{FitMethod::paper_one_step, FitMethod::paper_converged},
                                           {FitMethod::sphere_one_step, FitMethod::sphere_converged}}};
  std::vector<MethodPair> pairs;
  for (const MethodPair& pair : all) {
    if (index_of(methods, pair.a) < methods.size() && index_of(methods, pair.b) < methods.size())
      pairs.push_back(pair);
  }
  return pairs;
}

void PairDifferences::add(const PairDifferences& other) {
  center_px.insert(center_px.end(), other.center_px.begin(), other.center_px.end());
  radius_px.insert(radius_px.end(), other.radius_px.begin(), other.radius_px.end());
  position_mm.insert(position_mm.end(), other.position_mm.begin(), other.position_mm.end());
}

PairStatistics PairDifferences::statistics() const {
  return {static_cast<int>(center_px.size()),
          quantile(center_px, 0.5),
          largest(center_px),
          quantile(radius_px, 0.5),
          largest(radius_px),
          quantile(position_mm, 0.5),
          largest(position_mm)};
}

PairDifferences pair_differences(const Comparison& comparison, const ConditionResult& condition,
                                 const MethodPair& pair) {
  const std::size_t a = index_of(comparison.methods, pair.a), b = index_of(comparison.methods, pair.b);
  PairDifferences differences;
  for (const ComparisonFrame& frame : condition.frames) {
    const auto &fit_a = frame.fits[a], &fit_b = frame.fits[b];
    if (!fit_a || !fit_b || !at_the_ball(*fit_a, frame.truth) || !at_the_ball(*fit_b, frame.truth)) continue;
    differences.center_px.push_back((fit_a->outline.center_px - fit_b->outline.center_px).norm());
    differences.radius_px.push_back(std::abs(fit_a->outline.radius_px - fit_b->outline.radius_px));
    differences.position_mm.push_back(1000 * (fit_a->p_C - fit_b->p_C).norm());
  }
  return differences;
}

std::string compare_csv(const Comparison& comparison) {
  std::string csv =
      "condition,method,frames,found,failed,center_rms_px,radius_bias_px,radius_rms_px,position_median_mm,"
      "position_p90_mm,position_rms_mm,depth_bias_mm,lateral_bias_mm\n";
  for (const ConditionResult& condition : comparison.conditions) {
    for (std::size_t m = 0; m < comparison.methods.size(); ++m) {
      const MethodStatistics s = method_statistics(condition, m);
      csv += fmt::format("{},{},{},{},{}", condition.name, fit_method_name(comparison.methods[m]), s.frames,
                         s.found, s.failed);
      for (const double value : {s.center_rms_px, s.radius_bias_px, s.radius_rms_px, s.position_median_mm,
                                 s.position_p90_mm, s.position_rms_mm, s.depth_bias_mm, s.lateral_bias_mm}) {
        csv += ',' + number_text(value);
      }
      csv += '\n';
    }
  }
  return csv;
}

std::string fits_csv(const Comparison& comparison) {
  std::string csv =
      "condition,source,frame,method,found,cx_px,cy_px,r_px,x_m,y_m,z_m,iterations,residual_px\n";
  for (const ConditionResult& condition : comparison.conditions) {
    for (std::size_t f = 0; f < condition.frames.size(); ++f) {
      const ComparisonFrame& frame = condition.frames[f];
      for (std::size_t m = 0; m < comparison.methods.size(); ++m) {
        const auto& fit = frame.fits[m];
        csv += fmt::format("{},rendered,{},{},{}", condition.name, f, fit_method_name(comparison.methods[m]),
                           fit && at_the_ball(*fit, frame.truth) ? 1 : 0);
        if (fit) {
          for (const double value : {fit->outline.center_px.x(), fit->outline.center_px.y(),
                                     fit->outline.radius_px, fit->p_C.x(), fit->p_C.y(), fit->p_C.z()}) {
            csv += ',' + number_text(value);
          }
          csv += fmt::format(",{},{}\n", fit->iterations ? std::to_string(*fit->iterations) : "",
                             optional_text(fit->residual_px));
        } else {
          csv += ",,,,,,,,\n";
        }
      }
    }
  }
  return csv;
}

std::string pairs_csv(const Comparison& comparison) {
  std::string csv =
      "condition,method_a,method_b,frames,center_median_px,center_max_px,radius_median_px,radius_max_px,"
      "position_median_mm,position_max_mm\n";
  for (const ConditionResult& condition : comparison.conditions) {
    for (const MethodPair& pair : one_step_pairs(comparison.methods)) {
      const PairStatistics s = pair_differences(comparison, condition, pair).statistics();
      csv += fmt::format("{},{},{},{},{},{},{},{},{},{}\n", condition.name, fit_method_name(pair.a),
                         fit_method_name(pair.b), s.frames, number_text(s.center_median_px),
                         number_text(s.center_max_px), number_text(s.radius_median_px),
                         number_text(s.radius_max_px), number_text(s.position_median_mm),
                         number_text(s.position_max_mm));
    }
  }
  return csv;
}

std::string timing_csv(const Comparison& comparison) {
  std::string csv = "condition,method,time_us_median\n";
  for (const ConditionResult& condition : comparison.conditions) {
    for (std::size_t m = 0; m < comparison.methods.size(); ++m) {
      csv += fmt::format("{},{},{}\n", condition.name, fit_method_name(comparison.methods[m]),
                         number_text(method_statistics(condition, m).time_us_median));
    }
  }
  return csv;
}

}  // namespace ballservo
