#include "app/sweep/trial.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "calibration/base/csv_table.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

constexpr double trace_step_s = 0.25;
constexpr const char* drawn_prefix = "drawn.";
constexpr CsvLimits trials_limits{std::size_t{1} << 30, 2000000, 1000};

/// A column of trials.csv: how a trial writes it and reads it back.
struct Column {
  std::string name;
  std::function<std::string(const Trial&)> cell;
  std::function<void(const CsvRow&, Trial&)> read;
};

void read_cell(const CsvRow& row, const std::string& column, std::string& value) { value = row.text(column); }
void read_cell(const CsvRow& row, const std::string& column, double& value) {
  value = row.number(column, {}).value_or(not_known);
}
template <class Integer>
void read_cell(const CsvRow& row, const std::string& column, Integer& value) {
  value = static_cast<Integer>(row.count(column));
}

/// A member of the trial itself.
template <class T>
Column own(const char* name, T Trial::*member) {
  return {name, [=](const Trial& trial) { return csv_cell(trial.*member); },
          [=](const CsvRow& row, Trial& trial) { read_cell(row, name, trial.*member); }};
}

/// A member of the summary: empty where the world cannot be.
template <class T>
Column measured(const char* name, T RunSummary::*member) {
  return {name, [=](const Trial& trial) { return trial.feasible ? csv_cell(trial.summary.*member) : ""; },
          [=](const CsvRow& row, Trial& trial) {
            if (trial.feasible) read_cell(row, name, trial.summary.*member);
          }};
}

void read_outcome(const CsvRow& row, Trial& trial) {
  const std::string& text = row.text("outcome");
  trial.feasible = text != "infeasible";
  if (!trial.feasible) return;
  const auto outcome = outcome_from_name(text);
  if (!outcome) return row.fault("outcome", text, "infeasible, or an outcome of a run");
  trial.summary.outcome = *outcome;
}

/// In order; the outcome stands before what was measured, as reading needs it. What a seed drew follows.
const std::vector<Column>& fixed_columns() {
  static const std::vector<Column> columns{
      own("scenario_hash", &Trial::scenario_hash),
      own("seed", &Trial::seed),
      {"outcome", [](const Trial& trial) { return trial.outcome_text(); }, read_outcome},
      measured("collision_cause", &RunSummary::collision_cause),
      measured("settled_s", &RunSummary::settled_s),
      measured("time_optimal_s", &RunSummary::time_optimal_s),
      measured("range_error_m", &RunSummary::range_error_m),
      measured("bearing_error_rad", &RunSummary::bearing_error_rad),
      measured("range_rms_m", &RunSummary::range_rms_m),
      measured("bearing_rms_rad", &RunSummary::bearing_rms_rad),
      measured("min_clearance_m", &RunSummary::min_clearance_m),
      measured("out_of_view_s", &RunSummary::out_of_view_s),
      measured("duration_s", &RunSummary::duration_s),
      measured("lost_events", &RunSummary::lost_events),
      measured("ball_contacts", &RunSummary::ball_contacts),
      measured("steps", &RunSummary::steps),
      own("last_state", &Trial::last_state),
      own("last_reason", &Trial::last_reason),
      own("why", &Trial::why)};
  return columns;
}

Trial read_row(const CsvRow& row, const std::vector<std::string>& drawn_columns) {
  Trial trial;
  for (const Column& column : fixed_columns()) column.read(row, trial);
  for (const std::string& column : drawn_columns) {
    auto& [key, value] = trial.drawn.emplace_back(column.substr(std::string(drawn_prefix).size()), 0.0);
    read_cell(row, column, value);
  }
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

}  // namespace

std::string Trial::outcome_text() const {
  return feasible ? std::string(outcome_name(summary.outcome)) : "infeasible";
}

std::string Trial::cause() const {
  if (!feasible) return why;
  if (!summary.collision_cause.empty()) return summary.collision_cause;
  const bool named = last_reason.rfind(last_state + ": ", 0) == 0;  // "blocked: backing up"
  return named ? last_reason : last_state + ": " + last_reason;
}

std::string trials_csv_header(const std::vector<std::string>& drawn_keys) {
  std::vector<std::string> names;
  for (const Column& column : fixed_columns()) names.push_back(column.name);
  for (const std::string& key : drawn_keys) names.push_back(csv_cell(drawn_prefix + key));
  return fmt::format("{}\n", fmt::join(names, ","));
}

std::string trial_row(const Trial& trial) {
  std::vector<std::string> cells;
  for (const Column& column : fixed_columns()) cells.push_back(column.cell(trial));
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
  std::vector<std::string> fixed;
  for (const Column& column : fixed_columns()) fixed.push_back(column.name);
  const CsvTable table = parse_csv(csv, name, fixed, drawn_columns, trials_limits);
  FaultList faults;
  std::vector<Trial> trials;
  for (std::size_t row = 0; row < table.rows.size() && faults.faults().size() < 100; ++row) {
    trials.push_back(read_row(CsvRow(table, row, faults), drawn_columns));
  }
  faults.throw_if_any();
  return trials;
}

std::string trace_line(const Scenario& scenario, const RunRecord& run) {
  std::vector<Eigen::Vector2d> path, ball_path;
  double next_s = 0, end_yaw_rad = 0;
  for (std::size_t k = 0; k < run.steps.size(); ++k) {
    const StepRecord& step = run.steps[k];
    if (step.time_s < next_s && k + 1 < run.steps.size()) continue;
    next_s = step.time_s + trace_step_s - 1e-9;
    path.emplace_back(step.pose.x_m, step.pose.y_m);
    ball_path.push_back(step.p_WB.head<2>());
    end_yaw_rad = step.pose.yaw_rad;
  }
  const Room& room = scenario.world.room;
  nlohmann::ordered_json line;
  line["seed"] = scenario.seed;
  line["path_mm"] = millimetres(path);
  line["end_yaw_mrad"] = std::lround(end_yaw_rad * 1e3);
  line["ball_path_mm"] = millimetres(ball_path);
  line["room_mm"] = millimetres({{room.x_min_m, room.y_min_m}, {room.x_max_m, room.y_max_m}});
  line["obstacles_mm"] = nlohmann::json::array();
  const auto add = [&line](const FloorOutline& outline) {
    nlohmann::ordered_json item{{"points", millimetres(outline.points_m)}};
    if (outline.radius_m > 0) item["radius"] = std::lround(outline.radius_m * 1e3);
    line["obstacles_mm"].push_back(item);
  };
  for (const Obstacle& obstacle : scenario.world.obstacles) add(floor_outline(obstacle));
  for (const Ball& ball : scenario.world.balls) {
    if (&ball != &scenario.target_ball() && std::holds_alternative<StaticMotion>(ball.motion))
      add({{ball.position_m.head<2>()}, ball.radius_m()});
  }
  return line.dump();
}

std::uint64_t seed_of_trace(const std::string& line, const std::string& name) {
  const auto shallow = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) { return depth < 8; };
  try {
    const nlohmann::json trace = nlohmann::json::parse(line, shallow);
    for (const char* key : {"path_mm", "end_yaw_mrad", "ball_path_mm", "room_mm", "obstacles_mm"})
      trace.at(key);
    return trace.at("seed").get<std::uint64_t>();
  } catch (const nlohmann::json::exception&) {
    throw InputError(name, "a line that is no trace", "the file as a sweep wrote it");
  }
}

}  // namespace ballservo
