// report.html of one closed-loop run.
#pragma once

#include <string>

#include "app/experiment/outcome_judge.hpp"
#include "app/experiment/run_record.hpp"
#include "calibration/camera/camera.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// What the report needs beside the record.
struct RunReportInput {
  std::string title, law, perception;
  const World* world = nullptr;
  const Ball* target = nullptr;
  const Camera* camera = nullptr;
  Footprint footprint;
  ServoGoal goal;
  ReachedRule rule;
  bool video = false;         ///< video.mp4 lies beside the page
  std::string scenario_json;  ///< as resolved
};

/// One page, loading nothing from the network: how it ended, top view, image trace, errors and commands over
/// time, key frames, states.
std::string run_report_html(const RunRecord& record, const RunReportInput& input);

}  // namespace ballservo
