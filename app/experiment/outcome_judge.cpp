#include "app/experiment/outcome_judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/base/statistics.hpp"

namespace ballservo {

std::optional<Outcome> outcome_from_name(std::string_view name) {
  const auto* const found = std::find(std::begin(outcome_names), std::end(outcome_names), name);
  if (found == std::end(outcome_names)) return std::nullopt;
  return static_cast<Outcome>(found - std::begin(outcome_names));
}

bool OutcomeJudge::within(const StepRecord& step) const {
  if (!step.known) return step.control.state == ControlState::hold;
  if (ball_moves_) {
    return std::abs(step.range_error_m) <= ReachedRule::moving_range_m &&
           std::abs(step.bearing_rad) <= ReachedRule::moving_bearing_rad;
  }
  return std::abs(step.range_error_m) <= ReachedRule::range_m &&
         std::abs(step.bearing_rad) <= ReachedRule::bearing_rad &&
         std::abs(step.twist.v_mps) <= ReachedRule::speed_mps;
}

void OutcomeJudge::end(Outcome outcome, std::string text) {
  if (over_) return;
  over_ = true;
  if (!ending_) ending_ = Ending{outcome, std::move(text)};
}

void OutcomeJudge::look(const StepRecord& step, const std::string& collision) {
  const double t = step.time_s;
  const bool rests = std::abs(step.twist.v_mps) < 1e-3 && std::abs(step.twist.w_radps) < 1e-3;
  const bool touches_ball = step.ball_clearance_m <= 0;
  if (touches_ball && !touches_ball_) ++ball_contacts_;
  const bool hit = touches_ball && !touches_ball_ && rests && step.step > 0;
  touches_ball_ = touches_ball;

  const bool fault = step.control.state == ControlState::fault;
  if (!fault) fault_since_s_.reset();
  if (fault && !fault_since_s_) fault_since_s_ = t;

  if (!within(step))
    within_since_s_.reset();
  else if (!within_since_s_)
    within_since_s_ = t;
  if (!ball_moves_ && !ending_ && within_since_s_ && t - *within_since_s_ >= ReachedRule::hold_s - 1e-9) {
    ending_ =
        Ending{Outcome::reached,
               fmt::format("the robot reached the ball{}: it settled at {:.2f} s and held for {} s",
                           step.known ? "" : ", by its own word", *within_since_s_, ReachedRule::hold_s)};
    reached_s_ = t;
    settled_s_ = within_since_s_;
  }

  if (!collision.empty()) {
    ending_.reset();  // whatever was reached before
    touched_ = collision;
    end(Outcome::collision, fmt::format("the robot touched {} at {:.2f} s", collision, t));
  } else if (hit) {
    end(Outcome::hit_by, fmt::format("a ball rolled into the resting robot at {:.2f} s", t));
  } else if (fault_since_s_ && t - *fault_since_s_ >= ReachedRule::fault_s) {
    end(Outcome::fault,
        fmt::format("the controller failed at {:.2f} s: {}", *fault_since_s_, step.control.reason));
  } else if (step.control.state == ControlState::given_up) {
    end(Outcome::lost, fmt::format("the search for the ball ended without it at {:.2f} s", t));
  } else if (reached_s_ && t - *reached_s_ >= ReachedRule::tail_s - 1e-9) {
    end(Outcome::reached, "");
  } else if (t >= duration_s_ - 1e-9) {
    const std::string_view last = step.control.reason;
    end(Outcome::timeout, fmt::format("the robot did not reach the ball within {} s{}", duration_s_,
                                      last.empty() ? "" : fmt::format(", at last: {}", last)));
  }
}

RunSummary OutcomeJudge::summary(const std::vector<StepRecord>& steps, bool interrupted) const {
  RunSummary summary;
  summary.outcome = ending_ ? ending_->outcome : Outcome::timeout;
  if (ending_) summary.outcome_text = ending_->text;
  if (interrupted) {
    summary.outcome = Outcome::interrupted;
    summary.outcome_text = "the run was interrupted";
  }
  summary.steps = static_cast<long>(steps.size());
  summary.ball_contacts = ball_contacts_;
  if (!touched_.empty()) summary.collision_cause = "none_broken";
  if (steps.empty()) return summary;
  const double end_s = steps.back().time_s;
  summary.duration_s = end_s;
  summary.lost_events = steps.back().control.lost_events;

  std::optional<double> settled_s = settled_s_;
  if (ball_moves_) {
    // Backwards: is the share kept over the last seconds, and since when is it kept up to the end?
    double inside = 0, total = 0;
    bool window_seen = false;
    for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
      const bool good = within(*step);
      inside += good ? 1 : 0;
      total += 1;
      if (end_s - step->time_s < ReachedRule::moving_window_s - 1e-9) continue;
      const bool share_kept = inside >= ReachedRule::moving_share * total;
      if (!window_seen && !share_kept) break;
      window_seen = true;
      if (share_kept && good) settled_s = step->time_s;
    }
    if (settled_s && summary.outcome == Outcome::timeout) {
      summary.outcome = Outcome::reached;
      summary.outcome_text = fmt::format("the robot followed the moving ball from {:.2f} s on", *settled_s);
    }
  }
  if (settled_s && summary.outcome != Outcome::collision) summary.settled_s = *settled_s;

  std::vector<double> last_range_m, last_bearing_rad, settled_range_m, settled_bearing_rad;
  summary.min_clearance_m = steps.front().clearance_m;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const StepRecord& step = steps[i];
    summary.min_clearance_m = std::min(summary.min_clearance_m, step.clearance_m);
    if (!step.known) summary.out_of_view_s = std::nan("");
    if (!step.in_view && !step.hidden && i + 1 < steps.size())
      summary.out_of_view_s += steps[i + 1].time_s - step.time_s;
    if (step.time_s >= end_s - 1.0) {
      last_range_m.push_back(step.range_error_m);
      last_bearing_rad.push_back(step.bearing_rad);
    }
    if (std::isfinite(summary.settled_s) && step.time_s >= summary.settled_s) {
      settled_range_m.push_back(step.range_error_m);
      settled_bearing_rad.push_back(step.bearing_rad);
    }
  }
  summary.range_error_m = mean(last_range_m);
  summary.bearing_error_rad = mean(last_bearing_rad);
  summary.range_rms_m = root_mean_square(settled_range_m);
  summary.bearing_rms_rad = root_mean_square(settled_bearing_rad);
  return summary;
}

}  // namespace ballservo
