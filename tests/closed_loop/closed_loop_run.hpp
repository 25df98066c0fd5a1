// Runs of the project's own scenarios, for the closed-loop tests.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "app/experiment/run_log.hpp"
#include "app/experiment/runner.hpp"
#include "app/scenario/scenario.hpp"
#include "calibration/color/color_file.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo::test {

inline Scenario static_ball(std::uint64_t seed, const std::vector<std::string>& sets = {}) {
  return load_scenario(project_data_dir() / "scenarios" / "static_ball.yaml", sets, seed);
}

inline RunRecord run(const Scenario& scenario, PerceptionLevel level) {
  RunOptions options;
  options.perception = level;
  if (level == PerceptionLevel::image) {
    options.colors = std::make_shared<ColorTable>(read_color_file(scenario.colors));
  }
  return run_closed_loop(scenario, options);
}

/// Everything of a run that the same seed must give again, as bytes.
inline std::string bytes_of(const RunRecord& record) {
  return log_csv(record.steps) + record.tracks_csv + summary_json(record.summary, {}).dump();
}

}  // namespace ballservo::test
