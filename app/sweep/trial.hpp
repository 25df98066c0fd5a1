// One trial of a sweep: its row of trials.csv, and its trace, from which reports draw.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "app/experiment/run_record.hpp"
#include "app/scenario/scenario.hpp"

namespace ballservo {

/// How one seed of a scenario went.
struct Trial {
  std::string scenario_hash;
  std::uint64_t seed = 0;
  bool feasible = true;  ///< false: this seed's world cannot be; then nothing below was measured
  std::string why;       ///< why infeasible, or the sentence that says how the run ended
  RunSummary summary;
  std::string last_state, last_reason;                ///< the controller's, at the end
  std::vector<std::pair<std::string, double>> drawn;  ///< what the seed drew, by key path

  bool reached() const { return feasible && summary.outcome == Outcome::reached; }
  bool collided() const { return feasible && summary.outcome == Outcome::collision; }
  std::string outcome_text() const;  ///< "infeasible", or the outcome's name
  /// What went wrong, for counting alike failures: a collision's cause, or the controller's last word.
  std::string cause() const;
};

/// Column names of trials.csv, in order; what seeds draw follows as "drawn.KEY".
std::string trials_csv_header(const std::vector<std::string>& drawn_keys);
std::string trial_row(const Trial& trial);

/// Reads trials.csv as written by this program (any order of rows). Throws InputError with every fault.
std::vector<Trial> parse_trials(const std::string& csv, const std::string& name);

/// One line of traces.jsonl, without its end: what a trial looked like from above (world, to the millimetre):
/// the paths of the robot's axle and of the target at the same moments, some 4 a second; the walls; what
/// stands on the floor.
std::string trace_line(const Scenario& scenario, const RunRecord& run);

/// Which trial a line of traces.jsonl is of. InputError about `name` for a line that is none.
std::uint64_t seed_of_trace(const std::string& line, const std::string& name);

}  // namespace ballservo
