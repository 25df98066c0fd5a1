#include "app/comparison/certificate.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "app/comparison/resampling.hpp"
#include "calibration/base/csv_table.hpp"
#include "perception/outline/ball_fitter.hpp"

namespace ballservo {
namespace {

// So that on other conditions 95 % are left, and 5 % are not reached.
constexpr double caught_in_training = 0.97, alarms_in_training = 0.025;
constexpr double least_bend_px = 1e-6;
constexpr double shrinkage = 1e-3;  // of the regression's weights, so that separable data have a solution
constexpr int most_roc_points = 200;
constexpr std::size_t most_samples = 200000;

struct Scored {
  double score;
  bool breaks;
};

CertificateScore rate(const std::vector<Scored>& scored, double threshold) {
  CertificateScore s;
  std::vector<double> others;
  for (const Scored& it : scored) {
    ++s.frames;
    s.breaks += it.breaks ? 1 : 0;
    if (it.score > threshold) ++(it.breaks ? s.caught : s.false_alarms);
    if (!it.breaks) others.push_back(it.score);
  }
  // The area is the chance that a break scores higher than another frame (Mann and Whitney 1947).
  std::sort(others.begin(), others.end());
  double pairs = 0;
  for (const Scored& it : scored) {
    if (!it.breaks) continue;
    const auto below = std::lower_bound(others.begin(), others.end(), it.score);
    const auto above = std::upper_bound(others.begin(), others.end(), it.score);
    pairs += static_cast<double>(below - others.begin()) + 0.5 * static_cast<double>(above - below);
  }
  const double all = static_cast<double>(others.size()) * s.breaks;
  s.area = all > 0 ? pairs / all : not_known;
  return s;
}

// The threshold that catches enough of the breaks, or, where fewer false alarms than may be had are needed
// for that, the lower one that has them. Above all scores where there are no breaks.
double choose_threshold(const std::vector<Scored>& scored) {
  std::vector<double> breaks, others;
  for (const Scored& it : scored) (it.breaks ? breaks : others).push_back(it.score);
  if (breaks.empty()) return std::numeric_limits<double>::infinity();
  std::sort(breaks.begin(), breaks.end());
  const auto missed = static_cast<std::size_t>((1 - caught_in_training) * static_cast<double>(breaks.size()));
  double threshold = std::nextafter(breaks[missed], -std::numeric_limits<double>::infinity());
  if (!others.empty()) threshold = std::min(threshold, quantile(others, 1 - alarms_in_training));
  return threshold;
}

void draw_roc(std::vector<Scored> scored, CertificateRule& rule) {
  std::sort(scored.begin(), scored.end(), [](const Scored& a, const Scored& b) { return a.score > b.score; });
  const auto breaks = static_cast<double>(
      std::count_if(scored.begin(), scored.end(), [](const Scored& s) { return s.breaks; }));
  const double others = static_cast<double>(scored.size()) - breaks;
  if (!(breaks > 0) || !(others > 0)) return;
  double caught = 0, alarms = 0;
  const std::size_t stride = scored.size() / most_roc_points + 1;
  rule.roc_false_alarms = {0};
  rule.roc_caught = {0};
  for (std::size_t k = 0; k < scored.size(); ++k) {
    ++(scored[k].breaks ? caught : alarms);
    if (k % stride != 0 && k + 1 < scored.size()) continue;
    rule.roc_false_alarms.push_back(alarms / others);
    rule.roc_caught.push_back(caught / breaks);
  }
}

// With the threshold as given, or chosen.
CertificateRule make_rule(std::string name, const std::vector<Scored>& training,
                          const std::vector<Scored>& testing, std::optional<double> threshold) {
  CertificateRule rule;
  rule.name = std::move(name);
  rule.threshold = threshold.value_or(choose_threshold(training));
  rule.trained = rate(training, rule.threshold);
  rule.tested = rate(testing, rule.threshold);
  if (!threshold) draw_roc(testing, rule);
  return rule;
}

}  // namespace

double CertificateScore::caught_rate() const {
  return breaks > 0 ? static_cast<double>(caught) / breaks : not_known;
}
double CertificateScore::false_alarm_rate() const {
  return frames > breaks ? static_cast<double>(false_alarms) / (frames - breaks) : not_known;
}

CertificateStudy::CertificateStudy(const MethodList& methods) : methods_(methods) {
  for (const std::string family : {"paper", "sphere"}) {
    const auto one = place_of(methods, family + "_one_step"), two = place_of(methods, family + "_steps_2"),
               converged = place_of(methods, family + "_converged");
    if (one && two && converged) pairs_.push_back({*one, *two, *converged, {}});
  }
}

void CertificateStudy::add(std::size_t condition, const ComparisonRecord& record) {
  for (Pair& pair : pairs_) {
    const auto &one = record.fits[pair.one], &two = record.fits[pair.two],
               &converged = record.fits[pair.converged];
    if (!one || !two || !converged || !one->step_px || !one->next_step_px || !one->residual_px || !one->arc ||
        !one->condition)
      continue;
    if (!at_the_ball(*one, record.truth) && !at_the_ball(*converged, record.truth)) continue;
    const double radius_px = one->outline.radius_px;
    const double bend_px = std::max(least_bend_px, *one->step_px * *one->step_px / (2 * radius_px));
    Sample sample;
    sample.tested = condition % 2 == 1;
    sample.x << 1, std::log10(bend_px), std::log10(std::max(1e-6, *one->residual_px / radius_px)), *one->arc,
        std::log10(std::max(1.0, *one->condition));
    sample.log_next = std::log10(std::max(least_bend_px, *one->next_step_px));
    sample.apart_px = apart_px(*one, *converged);
    sample.apart_after_px = apart_px(*two, *converged);
    if (sample.x.allFinite() && std::isfinite(sample.apart_px) && std::isfinite(sample.apart_after_px))
      pair.keep(sample);
  }
}

void CertificateStudy::Pair::keep(const Sample& sample) {
  if (seen++ % stride != 0) return;
  samples.push_back(sample);
  if (samples.size() < most_samples) return;
  for (std::size_t k = 0; 2 * k < samples.size(); ++k) samples[k] = samples[2 * k];
  samples.resize((samples.size() + 1) / 2);
  stride *= 2;
}

// By Newton's method on the log-likelihood with a small quadratic penalty; breaks and others count alike,
// however rare one of them is.
CertificateStudy::Features CertificateStudy::regression(const std::vector<Sample>& samples) {
  using Matrix = Eigen::Matrix<double, Features::RowsAtCompileTime, Features::RowsAtCompileTime>;
  const auto breaks = static_cast<double>(
      std::count_if(samples.begin(), samples.end(), [](const Sample& s) { return s.breaks(); }));
  const double others = static_cast<double>(samples.size()) - breaks;
  Features w = Features::Zero();
  for (int iteration = 0; iteration < 50 && breaks > 0 && others > 0; ++iteration) {
    Features slope = -shrinkage * w;
    Matrix curvature = shrinkage * Matrix::Identity();
    for (const Sample& sample : samples) {
      const Features& x = sample.x;
      const double p = 1 / (1 + std::exp(-std::clamp(w.dot(x), -40.0, 40.0)));
      const double count = 0.5 / (sample.breaks() ? breaks : others);
      slope += count * ((sample.breaks() ? 1 : 0) - p) * x;
      curvature += count * std::max(1e-9, p * (1 - p)) * x * x.transpose();
    }
    const Features step = curvature.ldlt().solve(slope);
    w += step;
    if (step.norm() < 1e-9 * (1 + w.norm())) break;
  }
  return w;
}

Certificate CertificateStudy::certificate(const Pair& pair) const {
  Certificate certificate;
  certificate.one_step = methods_[pair.one]->name;
  certificate.converged = methods_[pair.converged]->name;
  std::vector<Sample> training;
  std::copy_if(pair.samples.begin(), pair.samples.end(), std::back_inserter(training),
               [](const Sample& s) { return !s.tested; });
  const Features w = regression(training);
  const auto regressed = [&](const Sample& s) {
    return std::inner_product(w.begin(), w.end(), s.x.begin(), 0.0);
  };
  const auto rule_of = [&](const char* name, const auto& score, std::optional<double> threshold = {}) {
    std::vector<Scored> halves[2];
    for (const Sample& s : pair.samples) halves[s.tested ? 1 : 0].push_back({score(s), s.breaks()});
    return make_rule(name, halves[0], halves[1], threshold);
  };
  const auto next_step = [](const Sample& s) { return s.log_next; };
  CertificateRule next = rule_of("next_step", next_step);
  CertificateRule on_line = rule_of("on_line", next_step, std::log10(enough_next_step_px));
  on_line.words =
      fmt::format("as on line: one more step where it would be longer than {:g} px", enough_next_step_px);
  CertificateRule bend = rule_of("bend", [](const Sample& s) { return s.x[1]; });
  CertificateRule logistic = rule_of("logistic", regressed);
  next.words =
      fmt::format("one more step where it would be longer than {:.2g} px", std::pow(10, next.threshold));
  bend.words = fmt::format("one more step where step^2 / (2 r) > {:.2g} px", std::pow(10, bend.threshold));
  logistic.words = fmt::format(
      "one more step where {:.2f} {:+.2f} log10(step^2 / 2 r) {:+.2f} log10(residual / r) {:+.2f} arc "
      "{:+.2f} log10(condition) > {:.2f}",
      w[0], w[1], w[2], w[3], w[4], logistic.threshold);
  for (const Sample& s : pair.samples) {
    if (!s.tested) continue;
    const double after_px = s.log_next > next.threshold ? s.apart_after_px : s.apart_px;
    certificate.breaks_after += after_px > break_px ? 1 : 0;
    certificate.largest_before_px = std::max(certificate.largest_before_px, s.apart_px);
    certificate.largest_after_px = std::max(certificate.largest_after_px, after_px);
  }
  const CertificateScore& tested = next.tested;
  certificate.breaks_before = tested.breaks;
  certificate.second_step_rate =
      tested.frames > 0 ? static_cast<double>(tested.caught + tested.false_alarms) / tested.frames
                        : not_known;
  certificate.rules = {std::move(next), std::move(on_line), std::move(bend), std::move(logistic)};
  for (CertificateRule& rule : certificate.rules)
    if (std::isinf(rule.threshold))
      rule.words = "never: no break in the conditions that this rule and others like it are made on";
  return certificate;
}

std::vector<Certificate> CertificateStudy::certificates() const {
  std::vector<Certificate> all;
  for (const Pair& pair : pairs_) all.push_back(certificate(pair));
  return all;
}

std::string certificate_csv(const std::vector<Certificate>& certificates) {
  std::string csv =
      "one_step,converged,tolerance_px,rule,threshold,trained_frames,trained_breaks,trained_caught,"
      "trained_false_alarms,tested_frames,tested_breaks,tested_caught,tested_false_alarms,tested_roc_area,"
      "second_step_rate,breaks_before,breaks_after,largest_before_px,largest_after_px\n";
  for (const Certificate& c : certificates) {
    for (const CertificateRule& rule : c.rules) {
      const CertificateScore &a = rule.trained, &b = rule.tested;
      const auto of_first = [&](auto value) {  // which tried one more step
        return &rule == &c.rules.front() ? std::optional(value) : std::nullopt;
      };
      csv += csv_row(c.one_step, c.converged, break_px, rule.name, rule.threshold, a.frames, a.breaks,
                     a.caught, a.false_alarms, b.frames, b.breaks, b.caught, b.false_alarms, b.area,
                     of_first(c.second_step_rate), of_first(c.breaks_before), of_first(c.breaks_after),
                     of_first(c.largest_before_px), of_first(c.largest_after_px));
    }
  }
  return csv;
}

}  // namespace ballservo
