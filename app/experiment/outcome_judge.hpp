// When a run is over, and how it ended; from the truth alone, and by the controller's word where nobody knows
// it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/experiment/run_record.hpp"

namespace ballservo {

/// Ball at rest: within 10 mm, 0.5 degrees and 5 mm/s, held 1 s. Ball that moves: within 50 mm and 2 degrees
/// for 80 % of the run's last 5 s. Where the truth is not known: the controller holds.
struct ReachedRule {
  static constexpr double range_m = 0.010, bearing_rad = 0.5 * 0.017453292519943295, speed_mps = 0.005;
  static constexpr double hold_s = 1.0;
  static constexpr double moving_range_m = 0.050, moving_bearing_rad = 2.0 * 0.017453292519943295;
  static constexpr double moving_window_s = 5.0, moving_share = 0.8;
  static constexpr double tail_s = 0.5;   ///< a run goes on so long after it has reached a resting ball
  static constexpr double fault_s = 1.0;  ///< a controller that stays in its fault state so long has failed
};

class OutcomeJudge {
 public:
  OutcomeJudge(double duration_s, bool ball_moves) : duration_s_(duration_s), ball_moves_(ball_moves) {}

  /// Looks at the next control step. `collision` names what the footprint touches, empty: nothing.
  void look(const StepRecord& step, const std::string& collision);
  bool over() const { return over_; }

  /// The summary of the run so far (all but `time_optimal_s`); `interrupted` where the user stopped it.
  RunSummary summary(const std::vector<StepRecord>& steps, bool interrupted) const;

 private:
  struct Ending {
    Outcome outcome;
    std::string text;  // one sentence for people
  };
  bool within(const StepRecord& step) const;
  void end(Outcome outcome, std::string text);

  double duration_s_;
  bool ball_moves_;
  bool over_ = false;
  std::optional<Ending> ending_;  // while it is not over: reached, and staying for a while
  std::string touched_;
  std::optional<double> within_since_s_, reached_s_, settled_s_, fault_since_s_;
  int ball_contacts_ = 0;
  bool touches_ball_ = false;
};

}  // namespace ballservo
