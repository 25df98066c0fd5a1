#include "app/sweep/trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "calibration/base/csv_table.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

constexpr double trace_step_s = 0.25;
constexpr const char* drawn_prefix = "drawn.";
constexpr CsvLimits trials_limits{std::size_t{1} << 30, 2000000, 1000};

/// The columns that hold a number of the summary.
struct NumberColumn {
  const char* name;
  double RunSummary::*value;
};
constexpr std::array<NumberColumn, 9> number_columns{{{"settled_s", &RunSummary::settled_s},
                                                      {"time_optimal_s", &RunSummary::time_optimal_s},
                                                      {"range_error_m", &RunSummary::range_error_m},
                                                      {"bearing_error_rad", &RunSummary::bearing_error_rad},
                                                      {"range_rms_m", &RunSummary::range_rms_m},
                                                      {"bearing_rms_rad", &RunSummary::bearing_rms_rad},
                                                      {"min_clearance_m", &RunSummary::min_clearance_m},
                                                      {"out_of_view_s", &RunSummary::out_of_view_s},
                                                      {"duration_s", &RunSummary::duration_s}}};

const std::vector<std::string>& fixed_columns() {
  static const std::vector<std::string> columns = [] {
    std::vector<std::string> names{"scenario_hash", "seed", "outcome", "collision_cause"};
    for (const NumberColumn& column : number_columns) names.emplace_back(column.name);
    for (const char* name : {"lost_events", "ball_contacts", "steps", "last_state", "last_reason", "why"}) {
      names.emplace_back(name);
    }
    return names;
  }();
  return columns;
}

Trial read_row(const CsvRow& row, const std::vector<std::string>& drawn_columns) {
  const auto number = [&row](const std::string& column) {
    return row.number(column, {}).value_or(std::numeric_limits<double>::quiet_NaN());
  };
  Trial trial;
  trial.scenario_hash = row.text("scenario_hash");
  trial.seed = static_cast<std::uint64_t>(row.count("seed"));
  const std::string& outcome = row.text("outcome");
  trial.feasible = outcome != "infeasible";
  bool known = !trial.feasible;
  for (const Outcome each : {Outcome::reached, Outcome::timeout, Outcome::collision, Outcome::lost,
                             Outcome::hit_by, Outcome::fault, Outcome::interrupted}) {
    if (outcome != outcome_name(each)) continue;
    trial.summary.outcome = each;
    known = true;
  }
  if (!known) row.fault("outcome", outcome, "infeasible, or an outcome of a run");
  trial.why = row.text("why");
  trial.summary.collision_cause = row.text("collision_cause");
  trial.last_state = row.text("last_state");
  trial.last_reason = row.text("last_reason");
  for (const std::string& column : drawn_columns)
    trial.drawn.emplace_back(column.substr(std::string(drawn_prefix).size()), number(column));
  if (!trial.feasible) return trial;
  for (const NumberColumn& column : number_columns) trial.summary.*column.value = number(column.name);
  trial.summary.lost_events = static_cast<int>(row.count("lost_events"));
  trial.summary.ball_contacts = static_cast<int>(row.count("ball_contacts"));
  trial.summary.steps = static_cast<long>(row.count("steps"));
  return trial;
}

nlohmann::json millimetres(const std::vector<Eigen::Vector2d>& points_m) {
  nlohmann::json flat = nlohmann::json::array();
  for (const Eigen::Vector2d& p : points_m) {
    flat.push_back(std::lround(p.x() * 1e3));
    flat.push_back(std::lround(p.y() * 1e3));
  }
  return flat;
}

std::vector<Eigen::Vector2d> metres(const nlohmann::json& flat) {
  const auto numbers = flat.get<std::vector<double>>();
  std::vector<Eigen::Vector2d> points;
  for (std::size_t k = 0; k + 1 < numbers.size(); k += 2) {
    points.emplace_back(numbers[k] * 1e-3, numbers[k + 1] * 1e-3);
  }
  return points;
}

}  // namespace

std::string Trial::outcome_text() const {
  return feasible ? std::string(outcome_name(summary.outcome)) : "infeasible";
}

std::string Trial::cause() const {
  if (!feasible) return why;
  if (!summary.collision_cause.empty()) return summary.collision_cause;
  return last_state + ": " + last_reason;
}

std::string trials_csv_header(const std::vector<std::string>& drawn_keys) {
  std::string header;
  for (const std::string& column : fixed_columns()) header += (header.empty() ? "" : ",") + column;
  for (const std::string& key : drawn_keys) header += "," + csv_cell(drawn_prefix + key);
  return header + "\n";
}

std::string trial_row(const Trial& trial) {
  const RunSummary& s = trial.summary;
  std::vector<std::string> cells{trial.scenario_hash, csv_cell(trial.seed), trial.outcome_text(),
                                 csv_cell(s.collision_cause)};
  const auto measured = [&](const auto& value) { cells.push_back(trial.feasible ? csv_cell(value) : ""); };
  for (const NumberColumn& column : number_columns) measured(s.*column.value);
  measured(s.lost_events);
  measured(s.ball_contacts);
  measured(s.steps);
  for (const std::string& text : {trial.last_state, trial.last_reason, trial.why})
    cells.push_back(csv_cell(text));
  for (const auto& entry : trial.drawn) cells.push_back(csv_cell(entry.second));
  return fmt::format("{}\n", fmt::join(cells, ","));
}

std::vector<Trial> parse_trials(const std::string& csv, const std::string& name) {
  std::vector<std::string> drawn_columns;
  const std::string heading = csv.substr(0, csv.find('\n'));
  for (std::size_t at = heading.find(drawn_prefix); at != std::string::npos;) {
    const std::size_t end = std::min(heading.find_first_of(",\r\n\"", at), heading.size());
    drawn_columns.push_back(heading.substr(at, end - at));
    at = heading.find(drawn_prefix, end);
  }
  const CsvTable table = parse_csv(csv, name, fixed_columns(), drawn_columns, trials_limits);
  FaultList faults;
  std::vector<Trial> trials;
  for (std::size_t row = 0; row < table.rows.size() && faults.faults().size() < 100; ++row) {
    trials.push_back(read_row(CsvRow(table, row, faults), drawn_columns));
  }
  faults.throw_if_any();
  return trials;
}

TrialTrace trace_of(const Scenario& scenario, const RunRecord& run) {
  TrialTrace trace;
  trace.seed = scenario.seed;
  double next_s = 0;
  for (std::size_t k = 0; k < run.steps.size(); ++k) {
    const StepRecord& step = run.steps[k];
    if (step.time_s < next_s && k + 1 < run.steps.size()) continue;
    next_s = step.time_s + trace_step_s - 1e-9;
    trace.path.emplace_back(step.pose.x_m, step.pose.y_m);
    trace.ball_path.push_back(step.p_WB.head<2>());
    trace.end_yaw_rad = step.pose.yaw_rad;
  }
  trace.room = scenario.world.room;
  for (const Obstacle& obstacle : scenario.world.obstacles)
    trace.obstacles.push_back(floor_outline(obstacle));
  for (const Ball& ball : scenario.world.balls) {
    if (&ball != &scenario.target_ball() && std::holds_alternative<StaticMotion>(ball.motion))
      trace.obstacles.push_back({{ball.position_m.head<2>()}, ball.radius_m()});
  }
  return trace;
}

std::string trace_line(const TrialTrace& trace) {
  nlohmann::ordered_json line;
  line["seed"] = trace.seed;
  line["path_mm"] = millimetres(trace.path);
  line["end_yaw_mrad"] = std::lround(trace.end_yaw_rad * 1e3);
  line["ball_path_mm"] = millimetres(trace.ball_path);
  line["room_mm"] =
      millimetres({{trace.room.x_min_m, trace.room.y_min_m}, {trace.room.x_max_m, trace.room.y_max_m}});
  line["obstacles_mm"] = nlohmann::json::array();
  for (const FloorOutline& outline : trace.obstacles) {
    nlohmann::ordered_json item;
    item["points"] = millimetres(outline.points_m);
    if (outline.radius_m > 0) item["radius"] = std::lround(outline.radius_m * 1e3);
    line["obstacles_mm"].push_back(item);
  }
  return line.dump();
}

TrialTrace parse_trace(const std::string& line, const std::string& name) {
  const auto shallow = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) { return depth < 8; };
  TrialTrace trace;
  try {
    const nlohmann::json json = nlohmann::json::parse(line, shallow);
    trace.seed = json.at("seed").get<std::uint64_t>();
    trace.path = metres(json.at("path_mm"));
    trace.end_yaw_rad = json.at("end_yaw_mrad").get<double>() * 1e-3;
    trace.ball_path = metres(json.at("ball_path_mm"));
    const auto corners = metres(json.at("room_mm"));
    if (corners.size() == 2) {
      trace.room.x_min_m = corners[0].x();
      trace.room.y_min_m = corners[0].y();
      trace.room.x_max_m = corners[1].x();
      trace.room.y_max_m = corners[1].y();
    }
    for (const nlohmann::json& item : json.at("obstacles_mm")) {
      trace.obstacles.push_back({metres(item.at("points")), item.value("radius", 0.0) * 1e-3});
    }
  } catch (const nlohmann::json::exception&) {
    throw InputError(name, "a line that is no trace", "the file as a sweep wrote it");
  }
  return trace;
}

}  // namespace ballservo
