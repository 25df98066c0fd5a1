#include "app/experiment/run_log.hpp"

#include <fmt/format.h>

#include <cmath>

#include "calibration/base/csv_table.hpp"
#include "calibration/base/statistics.hpp"

namespace ballservo {

std::string log_csv(const std::vector<StepRecord>& steps) {
  std::string csv =
      "step,time_s,x_m,y_m,yaw_rad,v_mps,w_radps,v_command_mps,w_command_radps,state,reason,track_state,"
      "error_1,"
      "error_2,range_m,bearing_rad,clearance_m,v_intended_mps,w_intended_radps,shield,in_view,hidden\n";
  for (const StepRecord& s : steps) {
    const ControlOutput& c = s.control;
    csv += csv_row(s.step, s.time_s, s.pose.x_m, s.pose.y_m, s.pose.yaw_rad, s.twist.v_mps, s.twist.w_radps,
                   c.command.v_mps, c.command.w_radps, control_state_name(c.state), c.reason,
                   track_state_name(c.track_state), c.error_1, c.error_2, s.range_m, s.bearing_rad,
                   s.clearance_m, c.intended.v_mps, c.intended.w_radps, c.shield, s.in_view, s.hidden);
  }
  return csv;
}

nlohmann::ordered_json summary_json(const RunSummary& summary, const RunTiming& timing) {
  const auto known = [](double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
  };
  const auto percentiles = [&known](const std::vector<double>& values) {
    return nlohmann::ordered_json{{"p50", known(quantile(values, 0.5))},
                                  {"p99", known(quantile(values, 0.99))}};
  };
  nlohmann::ordered_json json;
  json["outcome"] = outcome_name(summary.outcome);
  json["settled_s"] = known(summary.settled_s);
  json["time_optimal_s"] = known(summary.time_optimal_s);
  json["range_error_m"] = known(summary.range_error_m);
  json["bearing_error_rad"] = known(summary.bearing_error_rad);
  json["range_rms_m"] = known(summary.range_rms_m);
  json["bearing_rms_rad"] = known(summary.bearing_rms_rad);
  json["min_clearance_m"] = known(summary.min_clearance_m);
  json["out_of_view_s"] = known(summary.out_of_view_s);
  json["lost_events"] = summary.lost_events;
  json["collision_cause"] = summary.collision_cause.empty() ? nlohmann::ordered_json(nullptr)
                                                            : nlohmann::ordered_json(summary.collision_cause);
  json["steps"] = summary.steps;
  json["duration_s"] = known(summary.duration_s);
  json["ball_contacts"] = summary.ball_contacts;
  json["outcome_text"] = summary.outcome_text;
  json["timing"] = {{"image_to_command_ms", percentiles(timing.image_to_command_ms)},
                    {"control_us", percentiles(timing.control_us)}};
  if (timing.realtime) {
    const RealtimeTiming& wall = *timing.realtime;
    json["timing"]["realtime"] = {{"frame_age_ms", percentiles(wall.frame_age_ms)},
                                  {"control_period_ms", percentiles(wall.control_period_ms)},
                                  {"guard_period_ms", percentiles(wall.guard_period_ms)},
                                  {"frames_late", wall.frames_late},
                                  {"frames_skipped", wall.frames_skipped},
                                  {"steps_skipped", wall.steps_skipped},
                                  {"guard_rests", wall.guard_rests}};
  }
  return json;
}

}  // namespace ballservo
