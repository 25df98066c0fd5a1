#include "app/comparison/comparison_statistics.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ballservo {
namespace {

constexpr std::size_t kept_differences = 400;
constexpr double chi2_95_of_3 = 7.815;  // of 3 degrees of freedom

double largest_or_nan(const std::vector<double>& values) {
  return values.empty() ? not_known : *std::max_element(values.begin(), values.end());
}

void add_pair(const MethodList& methods, std::string_view a, std::string_view b,
              std::vector<MethodPair>& pairs) {
  const auto place_a = place_of(methods, a), place_b = place_of(methods, b);
  if (place_a && place_b) pairs.push_back({*place_a, *place_b});
}

// What runs on line, and the paper's one step, against each of the others.
std::vector<MethodPair> tested_pairs(const MethodList& methods) {
  std::vector<MethodPair> pairs;
  for (const FitMethod* method : methods) {
    if (method->name != "sphere_one_step") add_pair(methods, method->name, "sphere_one_step", pairs);
    if (method->name.rfind("paper_", 0) == 0 && method->name != "paper_one_step")
      add_pair(methods, method->name, "paper_one_step", pairs);
  }
  return pairs;
}

// Every n-th, so that a long condition is kept as a short one is.
std::vector<double> thinned(const std::vector<double>& values) {
  const std::size_t stride =
      std::max<std::size_t>(1, (values.size() + kept_differences - 1) / kept_differences);
  std::vector<double> kept;
  for (std::size_t i = 0; i < values.size(); i += stride) kept.push_back(values[i]);
  return kept;
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

// What one method's answers over a condition's frames add up to.
class ConditionStatistics::Errors {
 public:
  void add(const std::optional<MethodFit>& fit, const FrameTruth& truth) {
    ++frames_;
    balls_ += truth.has_ball ? 1 : 0;
    const bool found = fit && at_the_ball(*fit, truth);
    if (truth.has_ball && !truth.outline) truth_known_ = false;
    if (fit) {
      times_.push_back(fit->time_us);
      false_balls_ += fit->others + (found ? 0 : 1);
    }
    if (!found) return;
    ++found_;
    if (fit->iterations) iterations_.push_back(*fit->iterations);
    if (fit->converged) unconverged_.push_back(*fit->converged ? 0 : 1);
    if (truth.outline) {
      outline_px_.centers.push_back((fit->outline.center_px - truth.outline->center_px).norm());
      outline_px_.radii.push_back(fit->outline.radius_px - truth.outline->radius_px);
      outline_px_.radius_sizes.push_back(std::abs(outline_px_.radii.back()));
    }
    if (!truth.p_CB) return;
    const Eigen::Vector3d error_m = fit->p_C - *truth.p_CB;
    add_position(1000 * error_m, truth);
    if (!fit->covariance_m2) return;
    covariance_.nees.push_back(error_m.dot(fit->covariance_m2->ldlt().solve(error_m)));
    covariance_.inside_95.push_back(covariance_.nees.back() < chi2_95_of_3 ? 1 : 0);
  }

  MethodStatistics statistics(std::uint64_t seed, const std::string& purpose) const {
    MethodStatistics s;
    s.frames = frames_;
    s.found = found_;
    s.failed = balls_ - found_;
    s.found_ci95 = wilson_ci95(found_, balls_);
    s.false_balls = truth_known_ ? false_balls_ : not_known;
    s.radius_median_px = median(outline_px_.radius_sizes);
    s.nees_mean = mean(covariance_.nees);
    s.inside_95 = mean(covariance_.inside_95);
    s.center_rms_px = root_mean_square(outline_px_.centers);
    s.center_median_px = median(outline_px_.centers);
    s.radius_bias_px = mean(outline_px_.radii);
    s.radius_rms_px = root_mean_square(outline_px_.radii);
    s.position_median_mm = median(position_mm_.distances);
    s.position_median_ci95_mm = bootstrap(position_mm_.distances, median, seed, purpose + "/median");
    s.position_p90_mm = quantile(position_mm_.distances, 0.9);
    s.position_rms_mm = root_mean_square(position_mm_.distances);
    s.depth_bias_mm = mean(position_mm_.depths);
    s.depth_spread_mm = standard_deviation(position_mm_.depths);
    s.depth_rms_mm = root_mean_square(position_mm_.depths);
    s.lateral_bias_mm = mean(position_mm_.outward);
    s.lateral_spread_mm = std::hypot(standard_deviation(position_mm_.x), standard_deviation(position_mm_.y));
    s.time_us_median = median(times_);
    s.iterations_median = median(iterations_);
    s.unconverged = mean(unconverged_);
    std::vector<double> charged = position_mm_.distances;
    charged.resize(charged.size() + static_cast<std::size_t>(s.failed),
                   std::numeric_limits<double>::infinity());
    s.charged_median_mm = position_mm_.distances.empty() ? not_known : median(charged);
    set_bound(s, seed, purpose);
    return s;
  }

 private:
  void add_position(const Eigen::Vector3d& error_mm, const FrameTruth& truth) {
    position_mm_.distances.push_back(error_mm.norm());
    position_mm_.depths.push_back(error_mm.z());
    position_mm_.x.push_back(error_mm.x());
    position_mm_.y.push_back(error_mm.y());
    const Eigen::Vector2d across = truth.p_CB->head<2>();
    if (across.norm() > 0) position_mm_.outward.push_back(error_mm.head<2>().dot(across.normalized()));
    if (!truth.bound_m) return;
    position_mm_.bounds.push_back(1000 * *truth.bound_m);
    position_mm_.bounded.push_back(error_mm.norm());
  }

  void set_bound(MethodStatistics& s, std::uint64_t seed, const std::string& purpose) const {
    s.bound_rms_mm = root_mean_square(position_mm_.bounds);
    s.rms_over_bound = root_mean_square(position_mm_.bounded) / s.bound_rms_mm;
    s.rms_over_bound_ci95 = bootstrap(position_mm_.bounded, root_mean_square, seed, purpose + "/rms");
    s.rms_over_bound_ci95.low /= s.bound_rms_mm;
    s.rms_over_bound_ci95.high /= s.bound_rms_mm;
  }

  int frames_ = 0, balls_ = 0, found_ = 0, false_balls_ = 0;
  bool truth_known_ = true;
  struct {
    std::vector<double> centers, radii, radius_sizes;
  } outline_px_;
  struct {
    /// `outward`: across the axis, away from it. `bounds` and `bounded`: of frames that have a bound, it and
    /// the distance.
    std::vector<double> distances, depths, x, y, outward, bounds, bounded;
  } position_mm_;
  struct {
    std::vector<double> nees, inside_95;
  } covariance_;
  std::vector<double> times_, iterations_, unconverged_;
};

// The differences of two fits, frame by frame.
class ConditionStatistics::Differences {
 public:
  void add(const MethodFit& a, const MethodFit& b) {
    centers_px_.push_back((a.outline.center_px - b.outline.center_px).norm());
    radii_px_.push_back(std::abs(a.outline.radius_px - b.outline.radius_px));
    breaks_ += apart_px(a, b) > break_px ? 1 : 0;
    const double apart_mm = 1000 * (a.p_C - b.p_C).norm();
    if (std::isfinite(apart_mm)) positions_mm_.push_back(apart_mm);  // not where no diameter is known
  }
  const std::vector<double>& centers_px() const { return centers_px_; }
  PairStatistics statistics(std::uint64_t seed, const std::string& purpose) const {
    PairStatistics s;
    s.frames = static_cast<int>(centers_px_.size());
    s.breaks = breaks_;
    s.center_median_px = median(centers_px_);
    s.center_median_ci95_px = bootstrap(centers_px_, median, seed, purpose + "/centers apart");
    s.center_max_px = largest_or_nan(centers_px_);
    s.radius_median_px = median(radii_px_);
    s.radius_max_px = largest_or_nan(radii_px_);
    s.position_median_mm = median(positions_mm_);
    s.position_median_ci95_mm = bootstrap(positions_mm_, median, seed, purpose + "/positions apart");
    s.position_max_mm = largest_or_nan(positions_mm_);
    return s;
  }

 private:
  int breaks_ = 0;
  std::vector<double> centers_px_, radii_px_, positions_mm_;
};

// Which of two methods is nearer to the truth, frame by frame.
class ConditionStatistics::Duel {
 public:
  explicit Duel(const MethodPair& pair) { test_.pair = pair; }
  void add(const ComparisonRecord& frame) {
    const auto &a = frame.fits[test_.pair.a], &b = frame.fits[test_.pair.b];
    const bool found_a = a && at_the_ball(*a, frame.truth), found_b = b && at_the_ball(*b, frame.truth);
    test_.only_a += found_a && !found_b ? 1 : 0;
    test_.only_b += found_b && !found_a ? 1 : 0;
    if (!found_a || !found_b) return;
    ++test_.frames;
    if (!frame.truth.p_CB) return;
    differences_mm_.push_back(1000 *
                              ((a->p_C - *frame.truth.p_CB).norm() - (b->p_C - *frame.truth.p_CB).norm()));
  }
  const MethodPair& pair() const { return test_.pair; }
  PairedTest test(std::uint64_t seed, const std::string& purpose) const {
    PairedTest test = test_;
    test.difference_median_mm = median(differences_mm_);
    test.difference_ci95_mm = bootstrap(differences_mm_, median, seed, purpose);
    test.wilcoxon_p = differences_mm_.empty() ? not_known : wilcoxon_p(differences_mm_);
    test.mcnemar_p = mcnemar_p(test.only_a, test.only_b);
    return test;
  }

 private:
  PairedTest test_{};
  std::vector<double> differences_mm_;
};

ConditionStatistics::ConditionStatistics(std::string name, const MethodList& methods, std::uint64_t seed)
    : name_(std::move(name)),
      methods_(methods),
      seed_(seed),
      pairs_(converged_pairs(methods)),
      errors_(methods.size()),
      differences_(pairs_.size()) {
  for (const MethodPair& pair : tested_pairs(methods)) duels_.emplace_back(pair);
}

ConditionStatistics::~ConditionStatistics() = default;

void ConditionStatistics::add(const ComparisonRecord& frame) {
  for (std::size_t m = 0; m < methods_.size(); ++m) errors_[m].add(frame.fits[m], frame.truth);
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const auto &a = frame.fits[pairs_[k].a], &b = frame.fits[pairs_[k].b];
    if (a && b && at_the_ball(*a, frame.truth) && at_the_ball(*b, frame.truth)) differences_[k].add(*a, *b);
  }
  for (Duel& duel : duels_) duel.add(frame);
}

std::string ConditionStatistics::purpose_of(const MethodPair& pair) const {
  return fmt::format("{}/{}/{}", name_, methods_[pair.a]->name, methods_[pair.b]->name);
}

ConditionSummary ConditionStatistics::summary() const {
  ConditionSummary summary;
  for (std::size_t m = 0; m < methods_.size(); ++m)
    summary.methods.push_back(errors_[m].statistics(seed_, name_ + "/" + methods_[m]->name));
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    summary.pairs.push_back(differences_[k].statistics(seed_, purpose_of(pairs_[k])));
    summary.centers_apart_px.push_back(thinned(differences_[k].centers_px()));
  }
  std::vector<double> p;
  for (const Duel& duel : duels_) {
    summary.tests.push_back(duel.test(seed_, purpose_of(duel.pair())));
    p.push_back(summary.tests.back().wilcoxon_p);
  }
  const std::vector<double> adjusted = holm(p);
  for (std::size_t k = 0; k < adjusted.size(); ++k) summary.tests[k].holm_p = adjusted[k];
  return summary;
}

}  // namespace ballservo
