#include "app/experiment/run_log.hpp"

#include <fmt/format.h>
#include <visp3/core/vpConfig.h>

#include <algorithm>
#include <cctype>
#include <opencv2/core/version.hpp>
#include <string_view>

#include "app/report/picture.hpp"
#include "calibration/base/checksum.hpp"
#include "calibration/base/csv_table.hpp"
#include "calibration/base/statistics.hpp"

namespace ballservo {

std::string log_csv(const std::vector<StepRecord>& steps) {
  std::string csv =
      "step,time_s,x_m,y_m,yaw_rad,v_mps,w_radps,v_command_mps,w_command_radps,state,reason,track_state,"
      "error_1,error_2,range_m,bearing_rad,clearance_m,v_intended_mps,w_intended_radps,shield,in_view,"
      "hidden,pan_rad,pan_command_radps\n";
  for (const StepRecord& s : steps) {
    const ControlOutput& c = s.control;
    const auto if_known = [&s](bool value) { return s.known ? std::optional(value) : std::nullopt; };
    csv += csv_row(s.step, s.time_s, s.pose.x_m, s.pose.y_m, s.pose.yaw_rad, s.twist.v_mps, s.twist.w_radps,
                   c.command.v_mps, c.command.w_radps, control_state_name(c.state), c.reason,
                   track_state_name(c.track_state), c.error_1, c.error_2, s.range_m, s.bearing_rad,
                   s.clearance_m, c.intended.v_mps, c.intended.w_radps, c.shield, if_known(s.in_view),
                   if_known(s.hidden), s.pan.angle_rad, c.pan_radps);
  }
  return csv;
}

namespace {

nlohmann::ordered_json manifest(const RunRecord& run, const Scenario& scenario, const std::string& perception,
                                const std::string& peer, const std::string& log) {
  nlohmann::ordered_json hashes;
  hashes["scenario"] = sha256_hex(scenario.resolved_json);
  hashes["camera_file"] = sha256_of_file(scenario.camera.file);
  if (!scenario.colors.empty() && std::filesystem::exists(scenario.colors))
    hashes["colors_file"] = sha256_of_file(scenario.colors);
  hashes["log.csv"] = sha256_hex(log);
  hashes["tracks.csv"] = sha256_hex(run.tracks_csv);
  nlohmann::ordered_json made = {
      {"program", "ballservo " BALLSERVO_VERSION},
      {"libraries",
       {{"opencv", CV_VERSION},
        {"visp", fmt::format("{}.{}.{}", VISP_VERSION_MAJOR, VISP_VERSION_MINOR, VISP_VERSION_PATCH)},
        {"eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)}}},
      {"command", "servo"},
      {"scenario_file", scenario.file.filename().string()},
      {"perception", perception},
      {"realtime", run.timing.realtime.has_value()},
      {"seed", scenario.seed},
      {"sha256", hashes},
      {"scenario", nlohmann::ordered_json::parse(scenario.resolved_json)}};
  if (!peer.empty()) made["peer"] = peer;
  return made;
}

}  // namespace

void write_run(const OutputFolder& folder, const RunRecord& run, const Scenario& scenario,
               const std::string& perception, const std::string& peer) {
  const std::string log = log_csv(run.steps);
  folder.write("log.csv", log);
  folder.write("tracks.csv", run.tracks_csv);
  folder.write("summary.json", summary_json(run.summary, run.timing).dump(2) + "\n");
  folder.write("manifest.json", manifest(run, scenario, perception, peer, log).dump(2) + "\n");
}

nlohmann::ordered_json summary_json(const RunSummary& summary, const RunTiming& timing) {
  const auto percentiles = [](const std::vector<double>& values) {
    return nlohmann::ordered_json{{"p50", quantile(values, 0.5)}, {"p99", quantile(values, 0.99)}};
  };
  nlohmann::ordered_json json;
  json["outcome"] = outcome_name(summary.outcome);
  json["settled_s"] = summary.settled_s;
  json["time_optimal_s"] = summary.time_optimal_s;
  json["range_error_m"] = summary.range_error_m;
  json["bearing_error_rad"] = summary.bearing_error_rad;
  json["range_rms_m"] = summary.range_rms_m;
  json["bearing_rms_rad"] = summary.bearing_rms_rad;
  json["min_clearance_m"] = summary.min_clearance_m;
  json["out_of_view_s"] = summary.out_of_view_s;
  json["lost_events"] = summary.lost_events;
  json["collision_cause"] = summary.collision_cause.empty() ? nlohmann::ordered_json(nullptr)
                                                            : nlohmann::ordered_json(summary.collision_cause);
  json["steps"] = summary.steps;
  json["duration_s"] = summary.duration_s;
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

namespace {

using nlohmann::ordered_json;

constexpr const char* picture_prefix = "key_frame_";

/// The ball's way through the picture (px); null where it is not known.
ordered_json image_json(const RunRecord& record, const Scenario& scenario) {
  ordered_json truth = ordered_json::array(), measured = ordered_json::array();
  const auto center = [](const std::optional<OutlineEllipse>& outline) {
    return outline ? ordered_json({outline->center_px.x(), outline->center_px.y()}) : ordered_json(nullptr);
  };
  for (const FrameRecord& frame : record.frames) {
    truth.push_back(center(frame.truth));
    measured.push_back(frame.measurement.is_sighting() ? center(frame.measured) : ordered_json(nullptr));
  }
  const Camera& camera = scenario.camera.camera;
  constexpr int corners = 72;
  const auto outline = [&](const std::optional<Eigen::Vector3d>& p_CB) {
    return p_CB ? points_json(project_outline(camera, *p_CB, scenario.target_ball().radius_m(), corners))
                : ordered_json::array();
  };
  const ServoGoal goal = scenario.goal();  // as the robot believes
  ordered_json outlines{
      {"desired", points_json(project_outline(scenario.believed.camera(camera), goal.desired_p_CB(),
                                              goal.ball_radius_m, corners))}};
  if (!record.frames.empty()) {
    outlines["first"] = outline(record.frames.front().truth_p_CB);
    outlines["last"] = outline(record.frames.back().truth_p_CB);
  }
  return {{"truth_px", truth}, {"measured_px", measured}, {"outlines_px", outlines}};
}

ordered_json key_frames(const std::vector<KeyFrame>& frames, const OutputFolder& folder) {
  ordered_json list = ordered_json::array();
  for (const KeyFrame& frame : frames) {
    const std::string name = fmt::format("{}{}.jpg", picture_prefix, list.size() + 1);
    folder.write(name, picture_bytes(frame.picture, ".jpg"));
    list.push_back({{"file", name}, {"caption", frame.caption}});
  }
  return list;
}

}  // namespace

ordered_json points_json(const std::vector<Eigen::Vector2d>& points) {
  ordered_json list = ordered_json::array();
  for (const Eigen::Vector2d& p : points) list.push_back({p.x(), p.y()});
  return list;
}

ordered_json run_report(const RunRecord& record, const Scenario& scenario, const std::string& perception,
                        const OutputFolder& folder) {
  const Room& room = scenario.world.room;
  const Footprint& body = scenario.robot.footprint;
  const ImageSize size = scenario.camera.camera.size();
  ordered_json obstacles = ordered_json::array();
  for (const Obstacle& obstacle : scenario.world.obstacles) {
    const FloorOutline outline = floor_outline(obstacle);
    obstacles.push_back({{"points_m", points_json(outline.points_m)}, {"radius_m", outline.radius_m}});
  }
  std::vector<Eigen::Vector2d> ball_path;
  for (const StepRecord& step : record.steps)
    if (step.known) ball_path.push_back(step.p_WB.head<2>());
  return {{"page", "run"},
          {"title", scenario.file.stem().string()},
          {"law", scenario.law.name},
          {"perception", perception},
          {"truth_known", record.steps.empty() || record.steps.back().known},
          {"distance_m", scenario.goal().distance_m},
          {"reached", {{"range_m", ReachedRule::range_m}, {"bearing_rad", ReachedRule::bearing_rad}}},
          {"room_m", {room.x_min_m, room.y_min_m, room.x_max_m, room.y_max_m}},
          {"obstacles", obstacles},
          {"footprint_m",
           {{"front_m", body.front_m}, {"rear_m", body.rear_m}, {"half_width_m", body.half_width_m}}},
          {"ball", {{"radius_m", scenario.target_ball().radius_m()}, {"path_m", points_json(ball_path)}}},
          {"picture_px", {size.width_px, size.height_px}},
          {"image", image_json(record, scenario)},
          {"key_frames", key_frames(record.key_frames, folder)}};
}

std::string quoted(const std::string& word) {
  const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("_-./=:,+").find(static_cast<char>(c)) != std::string::npos;
  });
  if (plain) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string servo_command(const std::string& scenario, const std::string& output, std::uint64_t seed,
                          const std::string& perception, const std::vector<std::string>& sets) {
  std::string command = fmt::format("ballservo servo {} -o {} --seed {} --perception {}", quoted(scenario),
                                    quoted(output), seed, perception);
  for (const std::string& set : sets) command += " --set " + quoted(set);
  return command;
}

bool is_run_picture(const std::string& name) { return name.rfind(picture_prefix, 0) == 0; }

}  // namespace ballservo
