#include "app/offline/comparison_statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ballservo {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kept_differences = 400;

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

double spread(const std::vector<double>& values) {
  if (values.size() < 2) return nan;
  const double middle = mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - middle) * (value - middle);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double median(const std::vector<double>& values) { return quantile(values, 0.5); }

double largest(const std::vector<double>& values) {
  return values.empty() ? nan : *std::max_element(values.begin(), values.end());
}

std::size_t index_of(const MethodList& methods, std::string_view name) {
  const auto it = std::find_if(methods.begin(), methods.end(),
                               [&](const FitMethod* method) { return method->name == name; });
  return static_cast<std::size_t>(it - methods.begin());
}

void add_pair(const MethodList& methods, std::string_view a, std::string_view b,
              std::vector<MethodPair>& pairs) {
  const MethodPair pair{index_of(methods, a), index_of(methods, b)};
  if (pair.a < methods.size() && pair.b < methods.size()) pairs.push_back(pair);
}

// What one method's answers over a condition's frames add up to.
class Errors {
 public:
  void add(const std::optional<MethodFit>& fit, const FrameTruth& truth) {
    ++frames_;
    if (fit) times_.push_back(fit->time_us);
    if (!fit || !at_the_ball(*fit, truth)) return;
    ++found_;
    if (fit->iterations) iterations_.push_back(*fit->iterations);
    if (fit->converged) unconverged_.push_back(*fit->converged ? 0 : 1);
    if (truth.outline) {
      centers_.push_back((fit->outline.center_px - truth.outline->center_px).norm());
      radii_.push_back(fit->outline.radius_px - truth.outline->radius_px);
    }
    if (truth.p_CB) add_position(1000 * (fit->p_C - *truth.p_CB), truth);
  }

  MethodStatistics statistics(std::uint64_t seed, const std::string& purpose) const {
    MethodStatistics s;
    s.frames = frames_;
    s.found = found_;
    s.failed = frames_ - found_;
    s.found_ci95 = wilson(found_, frames_);
    s.center_rms_px = root_mean_square(centers_);
    s.center_median_px = median(centers_);
    s.radius_bias_px = mean(radii_);
    s.radius_rms_px = root_mean_square(radii_);
    s.position_median_mm = median(positions_);
    s.position_median_ci95_mm = bootstrap(positions_, median, seed, purpose + "/median");
    s.position_p90_mm = quantile(positions_, 0.9);
    s.position_rms_mm = root_mean_square(positions_);
    s.depth_bias_mm = mean(depths_);
    s.depth_spread_mm = spread(depths_);
    s.depth_rms_mm = root_mean_square(depths_);
    s.lateral_bias_mm = mean(outward_);
    s.lateral_spread_mm = std::hypot(spread(x_), spread(y_));
    s.time_us_median = median(times_);
    s.iterations_median = median(iterations_);
    s.unconverged = mean(unconverged_);
    std::vector<double> charged = positions_;
    charged.resize(charged.size() + static_cast<std::size_t>(s.failed),
                   std::numeric_limits<double>::infinity());
    s.charged_median_mm = positions_.empty() ? nan : median(charged);
    set_bound(s, seed, purpose);
    return s;
  }

 private:
  void add_position(const Eigen::Vector3d& error_mm, const FrameTruth& truth) {
    positions_.push_back(error_mm.norm());
    depths_.push_back(error_mm.z());
    x_.push_back(error_mm.x());
    y_.push_back(error_mm.y());
    const Eigen::Vector2d across = truth.p_CB->head<2>();
    if (across.norm() > 0) outward_.push_back(error_mm.head<2>().dot(across.normalized()));
    if (!truth.bound_m) return;
    bounds_mm_.push_back(1000 * *truth.bound_m);
    bounded_mm_.push_back(error_mm.norm());
  }

  void set_bound(MethodStatistics& s, std::uint64_t seed, const std::string& purpose) const {
    s.bound_rms_mm = root_mean_square(bounds_mm_);
    s.rms_over_bound = root_mean_square(bounded_mm_) / s.bound_rms_mm;
    s.rms_over_bound_ci95 = bootstrap(bounded_mm_, root_mean_square, seed, purpose + "/rms");
    s.rms_over_bound_ci95.low /= s.bound_rms_mm;
    s.rms_over_bound_ci95.high /= s.bound_rms_mm;
  }

  int frames_ = 0, found_ = 0;
  std::vector<double> centers_, radii_, positions_, depths_, x_, y_, outward_, times_, iterations_,
      unconverged_, bounds_mm_, bounded_mm_;
};

PairedTest paired_test(const MethodPair& pair, const std::vector<ComparisonRecord>& frames,
                       std::uint64_t seed, const std::string& purpose) {
  PairedTest test;
  test.pair = pair;
  std::vector<double> differences_mm;
  for (const ComparisonRecord& frame : frames) {
    const auto &a = frame.fits[pair.a], &b = frame.fits[pair.b];
    const bool found_a = a && at_the_ball(*a, frame.truth), found_b = b && at_the_ball(*b, frame.truth);
    test.only_a += found_a && !found_b ? 1 : 0;
    test.only_b += found_b && !found_a ? 1 : 0;
    if (!found_a || !found_b) continue;
    ++test.frames;
    if (!frame.truth.p_CB) continue;
    differences_mm.push_back(1000 *
                             ((a->p_C - *frame.truth.p_CB).norm() - (b->p_C - *frame.truth.p_CB).norm()));
  }
  test.difference_median_mm = median(differences_mm);
  test.difference_ci95_mm = bootstrap(differences_mm, median, seed, purpose);
  test.wilcoxon_p = differences_mm.empty() ? nan : wilcoxon_p(differences_mm);
  test.mcnemar_p = mcnemar_p(test.only_a, test.only_b);
  return test;
}

// Every n-th, so that a long condition is kept as a short one is.
void thin(std::vector<double>& values) {
  const std::size_t stride = (values.size() + kept_differences - 1) / kept_differences;
  if (stride < 2) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < values.size(); i += stride) values[kept++] = values[i];
  values.resize(kept);
}

}  // namespace

std::vector<MethodPair> converged_pairs(const MethodList& methods) {
  std::vector<MethodPair> pairs;
  add_pair(methods, "paper_one_step", "paper_converged", pairs);
  add_pair(methods, "sphere_one_step", "sphere_converged", pairs);
  add_pair(methods, "sphere_steps_2", "sphere_converged", pairs);
  for (const int steps : {2, 3, 5, 10}) {
    add_pair(methods, fmt::format("paper_steps_{}", steps), "paper_converged", pairs);
    add_pair(methods, fmt::format("paper_steps_{}_reselect", steps), "paper_converged", pairs);
  }
  add_pair(methods, "paper_robust", "paper_converged", pairs);
  add_pair(methods, "sphere_robust", "sphere_converged", pairs);
  return pairs;
}

std::vector<MethodPair> tested_pairs(const MethodList& methods) {
  std::vector<MethodPair> pairs;
  for (const FitMethod* method : methods) {
    if (method->name != "sphere_one_step") add_pair(methods, method->name, "sphere_one_step", pairs);
    if (method->name.rfind("paper_", 0) == 0 && method->name != "paper_one_step")
      add_pair(methods, method->name, "paper_one_step", pairs);
  }
  return pairs;
}

void PairDifferences::add(const MethodFit& a, const MethodFit& b) {
  center_px.push_back((a.outline.center_px - b.outline.center_px).norm());
  radius_px.push_back(std::abs(a.outline.radius_px - b.outline.radius_px));
  const double apart_mm = 1000 * (a.p_C - b.p_C).norm();
  if (std::isfinite(apart_mm)) position_mm.push_back(apart_mm);  // not where no diameter is known
}

PairStatistics PairDifferences::statistics() const {
  return {static_cast<int>(center_px.size()),
          median(center_px),
          largest(center_px),
          median(radius_px),
          largest(radius_px),
          median(position_mm),
          largest(position_mm)};
}

ConditionSummary summarize(std::size_t index, const std::string& name,
                           const std::vector<ComparisonRecord>& frames, const MethodList& methods,
                           std::uint64_t seed) {
  ConditionSummary summary;
  summary.index = index;
  std::vector<Errors> errors(methods.size());
  const std::vector<MethodPair> pairs = converged_pairs(methods);
  summary.differences.resize(pairs.size());
  std::vector<double> votes, qualities, second;
  for (const ComparisonRecord& frame : frames) {
    for (std::size_t m = 0; m < methods.size(); ++m) errors[m].add(frame.fits[m], frame.truth);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto &a = frame.fits[pairs[k].a], &b = frame.fits[pairs[k].b];
      if (a && b && at_the_ball(*a, frame.truth) && at_the_ball(*b, frame.truth))
        summary.differences[k].add(*a, *b);
    }
    if (frame.truth.bound_m) summary.bounds_mm.push_back(1000 * *frame.truth.bound_m);
    if (frame.facts) {
      votes.push_back(frame.facts->votes);
      qualities.push_back(frame.facts->quality);
    }
    if (frame.passes > 0) second.push_back(frame.passes > 1 ? 1 : 0);
  }
  for (std::size_t m = 0; m < methods.size(); ++m)
    summary.methods.push_back(errors[m].statistics(seed, name + "/" + methods[m]->name));
  for (PairDifferences& differences : summary.differences) {
    summary.pairs.push_back(differences.statistics());
    thin(differences.center_px);
    thin(differences.radius_px);
    thin(differences.position_mm);
  }
  std::vector<double> p;
  for (const MethodPair& pair : tested_pairs(methods)) {
    summary.tests.push_back(paired_test(
        pair, frames, seed, fmt::format("{}/{}/{}", name, methods[pair.a]->name, methods[pair.b]->name)));
    p.push_back(summary.tests.back().wilcoxon_p);
  }
  const std::vector<double> adjusted = holm(p);
  for (std::size_t k = 0; k < adjusted.size(); ++k) summary.tests[k].holm_p = adjusted[k];
  thin(summary.bounds_mm);
  summary.votes_median = median(votes);
  summary.quality_median = median(qualities);
  summary.second_pass_rate = mean(second);
  return summary;
}

}  // namespace ballservo
