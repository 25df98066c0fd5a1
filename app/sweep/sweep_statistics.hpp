// What a sweep's trials say together, and what two sweeps over the same seeds say of each other, and
// what the page is drawn from.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/sweep/sweep.hpp"
#include "calibration/base/statistics.hpp"

namespace ballservo {

struct SweepCounts {
  long trials = 0, infeasible = 0, reached = 0, collisions = 0, collisions_inside_assumptions = 0;
  long feasible() const { return trials - infeasible; }
};
SweepCounts count_trials(const std::vector<Trial>& trials);

/// Two sweeps, paired by their seeds.
struct SweepComparison {
  std::string other;  ///< the other sweep's folder, as the user named it
  std::string other_law, other_perception;
  MatchedCounts reached, no_collision;  ///< first: this sweep; second: the other
  long unmatched = 0;                   ///< seeds of one sweep alone, or infeasible in either
  long other_worlds = 0;                ///< pairs whose seed drew something else in the other sweep
  /// A figure's paired differences (this sweep's less the other's), where both know it.
  struct Difference {
    std::string name;
    long pairs = 0;
    double median = 0;
    ConfidenceInterval median_ci95{0, 0};
  };
  std::vector<Difference> differences;
};
SweepComparison compare_sweeps(const Sweep& sweep, const Sweep& other, const std::string& other_name);

/// summary.json: the contract's keys first. What is not known is null.
nlohmann::ordered_json sweep_summary_json(const Sweep& sweep, const Shard& shard, bool interrupted,
                                          const SweepComparison* against);

/// The contents of report.json: what depends on what a seed draws, and the worst trials with the commands
/// that show them again.
nlohmann::ordered_json sweep_report(const Sweep& sweep, const SweepComparison* against);

/// The command that runs one seed of a sweep again, with a film: for pasting into a shell.
std::string trial_command(const nlohmann::json& description, std::uint64_t seed);

}  // namespace ballservo
