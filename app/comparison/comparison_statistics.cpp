#include "app/comparison/comparison_statistics.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "app/comparison/resampling.hpp"

namespace ballservo {
namespace {

constexpr double chi2_95_of_3 = 7.815;  // of 3 degrees of freedom

double largest_or_nan(const std::vector<double>& values) {
  return values.empty() ? not_known : *std::max_element(values.begin(), values.end());
}

void add_pair(const MethodList& methods, std::string_view a, std::string_view b,
              std::vector<MethodPair>& pairs) {
  const auto place_a = place_of(methods, a), place_b = place_of(methods, b);
  if (place_a && place_b) pairs.push_back({*place_a, *place_b});
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

// What one method's answers over a condition's frames add up to.
class ConditionStatistics::Errors {
 public:
  void add(const std::optional<MethodFit>& fit, const FrameTruth& truth) {
    ++frames_;
    balls_ += truth.has_ball ? 1 : 0;
    const bool found = fit && at_the_ball(*fit, truth);
    if (truth.has_ball && !truth.outline) truth_known_ = false;
    if (fit) {
      times_us_.push_back(fit->time_us);
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

  Figures figures(std::uint64_t seed, const std::string& purpose) const {
    const int failed = balls_ - found_;
    const std::vector<double>& distances_mm = position_mm_.distances;
    // A failure counts as an error without bound.
    std::vector<double> charged_mm = distances_mm;
    charged_mm.resize(charged_mm.size() + static_cast<std::size_t>(failed),
                      std::numeric_limits<double>::infinity());
    const double bound_mm = root_mean_square(position_mm_.bounds),
                 false_balls = truth_known_ ? false_balls_ : not_known;
    const ConfidenceInterval found = wilson_ci95(found_, balls_),
                             median_mm = bootstrap(distances_mm, median, seed, purpose + "/median"),
                             rms_mm =
                                 bootstrap(position_mm_.bounded, root_mean_square, seed, purpose + "/rms");
    return {{"frames", frames_},
            {"found", found_},
            {"failed", failed},
            {"center_rms_px", root_mean_square(outline_px_.centers)},
            {"radius_bias_px", mean(outline_px_.radii)},
            {"radius_rms_px", root_mean_square(outline_px_.radii)},
            {"position_median_mm", median(distances_mm)},
            {"position_p90_mm", quantile(distances_mm, 0.9)},
            {"position_rms_mm", root_mean_square(distances_mm)},
            {"depth_bias_mm", mean(position_mm_.depths)},
            {"lateral_bias_mm", mean(position_mm_.outward)},
            {"found_low", found.low},
            {"found_high", found.high},
            {"center_median_px", median(outline_px_.centers)},
            {"position_median_low_mm", median_mm.low},
            {"position_median_high_mm", median_mm.high},
            {"depth_spread_mm", standard_deviation(position_mm_.depths)},
            {"depth_rms_mm", root_mean_square(position_mm_.depths)},
            {"lateral_spread_mm",
             std::hypot(standard_deviation(position_mm_.x), standard_deviation(position_mm_.y))},
            {"charged_median_mm", distances_mm.empty() ? not_known : median(charged_mm)},
            {"bound_rms_mm", bound_mm},
            {"rms_over_bound", root_mean_square(position_mm_.bounded) / bound_mm},
            {"rms_over_bound_low", rms_mm.low / bound_mm},
            {"rms_over_bound_high", rms_mm.high / bound_mm},
            {"iterations_median", median(iterations_)},
            {"unconverged", mean(unconverged_)},
            {"radius_median_px", median(outline_px_.radius_sizes)},
            {"false_balls", false_balls},
            {"false_per_1000", 1000 * false_balls / frames_},
            {"nees_mean", mean(covariance_.nees)},
            {"inside_95", mean(covariance_.inside_95)}};
  }
  double median_time_us() const { return median(times_us_); }

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
  std::vector<double> times_us_, iterations_, unconverged_;
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
  Figures figures(std::uint64_t seed, const std::string& purpose) const {
    const ConfidenceInterval center_px = bootstrap(centers_px_, median, seed, purpose + "/centers apart"),
                             position_mm =
                                 bootstrap(positions_mm_, median, seed, purpose + "/positions apart");
    return {{"frames", centers_px_.size()},
            {"center_median_px", median(centers_px_)},
            {"center_max_px", largest_or_nan(centers_px_)},
            {"radius_median_px", median(radii_px_)},
            {"radius_max_px", largest_or_nan(radii_px_)},
            {"position_median_mm", median(positions_mm_)},
            {"position_max_mm", largest_or_nan(positions_mm_)},
            {"breaks", breaks_},
            {"center_median_low_px", center_px.low},
            {"center_median_high_px", center_px.high},
            {"position_median_low_mm", position_mm.low},
            {"position_median_high_mm", position_mm.high}};
  }

 private:
  int breaks_ = 0;
  std::vector<double> centers_px_, radii_px_, positions_mm_;
};

// Which of two methods is nearer to the truth, frame by frame.
class ConditionStatistics::Duel {
 public:
  explicit Duel(const MethodPair& pair) : pair_(pair) {}
  void add(const ComparisonRecord& frame) {
    const auto &a = frame.fits[pair_.a], &b = frame.fits[pair_.b];
    const bool found_a = a && at_the_ball(*a, frame.truth), found_b = b && at_the_ball(*b, frame.truth);
    only_a_ += found_a && !found_b ? 1 : 0;
    only_b_ += found_b && !found_a ? 1 : 0;
    if (!found_a || !found_b) return;
    ++both_;
    if (!frame.truth.p_CB) return;
    differences_mm_.push_back(1000 *
                              ((a->p_C - *frame.truth.p_CB).norm() - (b->p_C - *frame.truth.p_CB).norm()));
  }
  const MethodPair& pair() const { return pair_; }
  // All but `holm_p`, which needs the condition's other tests.
  Figures figures(std::uint64_t seed, const std::string& purpose) const {
    const ConfidenceInterval difference_mm = bootstrap(differences_mm_, median, seed, purpose);
    return {{"frames", both_},
            {"difference_median_mm", median(differences_mm_)},
            {"difference_low_mm", difference_mm.low},
            {"difference_high_mm", difference_mm.high},
            {"wilcoxon_p", differences_mm_.empty() ? not_known : wilcoxon_p(differences_mm_)},
            {"holm_p", not_known},
            {"only_a", only_a_},
            {"only_b", only_b_},
            {"mcnemar_p", mcnemar_p(only_a_, only_b_)}};
  }

 private:
  MethodPair pair_;
  int both_ = 0, only_a_ = 0, only_b_ = 0;  // frames in which both, or only one of them, found the ball
  std::vector<double> differences_mm_;      // of |error a| - |error b|: negative where a is the better
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
  for (std::size_t m = 0; m < methods_.size(); ++m) {
    summary.methods.push_back(errors_[m].figures(seed_, name_ + "/" + methods_[m]->name));
    summary.times_us.push_back(errors_[m].median_time_us());
  }
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    summary.pairs.push_back(differences_[k].figures(seed_, purpose_of(pairs_[k])));
    summary.centers_apart_px.push_back(differences_[k].centers_px());
  }
  std::vector<double> p;
  for (const Duel& duel : duels_) {
    summary.tests.push_back(duel.figures(seed_, purpose_of(duel.pair())));
    p.push_back(summary.tests.back()["wilcoxon_p"]);
  }
  const std::vector<double> adjusted = holm(p);
  for (std::size_t k = 0; k < adjusted.size(); ++k) summary.tests[k]["holm_p"] = adjusted[k];
  return summary;
}

}  // namespace ballservo
