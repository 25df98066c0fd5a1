// Can one step tell by itself whether it was enough? From what the fit knows without converging.
//
// The first rule looks at the step that would follow on the same points: it costs a small linear system, no
// look at the picture, and is what one step leaves, to first order. It is the one that runs on line. The
// second is what can be had for nothing: a Gauss-Newton step is exact where the residual is linear, and
// moving a circle by d bends its distance to a point by about d^2 / (2 r). The third is a logistic regression
// (Cox 1958) on the second, the points' scatter, the arc that they cover, and how well they determine the
// fit.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "app/comparison/estimators/methods.hpp"
#include "app/comparison/frame_record.hpp"

namespace ballservo {

/// How a rule did on one half of the conditions.
struct CertificateScore {
  int frames = 0, breaks = 0;  ///< a break: one step and the converged fit lie more than break_px apart
  int caught = 0, false_alarms = 0;
  double area = 0;  ///< under the ROC: 1 is perfect, 0.5 is chance; NaN without breaks or without others

  double caught_rate() const;
  double false_alarm_rate() const;
};

/// A rule that raises an alarm where its score exceeds a threshold.
struct CertificateRule {
  std::string name;   ///< "next_step", "bend", "logistic"
  std::string words;  ///< the rule written out
  double threshold = 0;
  CertificateScore trained, tested;
  std::vector<double> roc_false_alarms, roc_caught;  ///< on the conditions tested
};

/// The certificate of one pair of one step and converged fit.
struct Certificate {
  std::string one_step, converged;  ///< methods
  std::vector<CertificateRule> rules;
  /// What one more step where the first rule says so would do on the conditions tested: the share of frames
  /// that take it, the breaks before and after, and how far apart the two fits are at most.
  double second_step_rate = 0;
  int breaks_before = 0, breaks_after = 0;
  double largest_before_px = 0, largest_after_px = 0;
};

/// Collects frames and makes the certificates: rules are made on every other condition and tested on the
/// rest. Of very many frames every second, fourth... is kept.
class CertificateStudy {
 public:
  explicit CertificateStudy(const MethodList& methods);
  void add(std::size_t condition, const ComparisonRecord& record);
  std::vector<Certificate> certificates() const;

 private:
  // 1, log bend, log residual / radius, arc, log condition
  using Features = Eigen::Matrix<double, 5, 1>;
  struct Sample {
    bool tested = false;
    Features x;
    double log_next = 0;
    double apart_px = 0, apart_after_px = 0;  // from the converged fit, of one step and of two
    bool breaks() const { return apart_px > break_px; }
  };
  struct Pair {
    std::size_t one, two, converged;
    std::vector<Sample> samples;
    std::size_t seen = 0, stride = 1;

    void keep(const Sample& sample);
  };
  Certificate certificate(const Pair& pair) const;
  static Features regression(const std::vector<Sample>& samples);

  MethodList methods_;
  std::vector<Pair> pairs_;
};

/// certificate.csv: one row a rule.
std::string certificate_csv(const std::vector<Certificate>& certificates);

}  // namespace ballservo
