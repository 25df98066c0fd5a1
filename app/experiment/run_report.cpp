#include "app/experiment/run_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/experiment/run_log.hpp"
#include "app/report/page.hpp"
#include "app/report/svg_canvas.hpp"
#include "app/report/svg_plot.hpp"

namespace ballservo {

namespace {

constexpr double degree = 0.017453292519943295;

std::string figure_or_dash(double value, double scale, int decimals, const char* unit) {
  if (!std::isfinite(value)) return "-";
  return fmt::format("{:.{}f} {}", value * scale, decimals, unit);
}

/// A stroke of that colour, nothing filled.
SvgStyle stroke(const PlotColor& color, double width_px = 1.5, bool dashed = false) {
  SvgStyle style;
  style.stroke = color;
  style.width_px = width_px;
  style.dashed = dashed;
  return style;
}

SvgStyle filled(const PlotColor& color, double fill_opacity) {
  SvgStyle style = stroke(color, 1.0);
  style.fill = color;
  style.fill_opacity = fill_opacity;
  return style;
}

std::vector<Eigen::Vector2d> footprint_corners(const Footprint& body, const Pose2& pose) {
  return {in_world_frame(pose, {body.front_m, body.half_width_m}),
          in_world_frame(pose, {-body.rear_m, body.half_width_m}),
          in_world_frame(pose, {-body.rear_m, -body.half_width_m}),
          in_world_frame(pose, {body.front_m, -body.half_width_m})};
}

Svg top_view(const RunRecord& record, const RunReportInput& input) {
  const Room& room = input.world->room;
  SvgCanvasOptions options;
  options.title = "From above";
  options.x_label = "x (m)";
  options.y_label = "y (m)";
  options.width_px = 640;
  options.x_low = options.y_low = 1e9;
  options.x_high = options.y_high = -1e9;
  const auto include = [&options](const Eigen::Vector2d& p) {
    options.x_low = std::min(options.x_low, p.x() - 0.8);
    options.x_high = std::max(options.x_high, p.x() + 0.8);
    options.y_low = std::min(options.y_low, p.y() - 0.8);
    options.y_high = std::max(options.y_high, p.y() + 0.8);
  };
  std::vector<Eigen::Vector2d> path, ball_path;
  for (const StepRecord& step : record.steps) {
    path.emplace_back(step.pose.x_m, step.pose.y_m);
    ball_path.push_back(step.p_WB.head<2>());
    include(path.back());
    include(ball_path.back());
  }
  options.x_low = std::max(options.x_low, room.x_min_m - 0.1);
  options.x_high = std::min(options.x_high, room.x_max_m + 0.1);
  options.y_low = std::max(options.y_low, room.y_min_m - 0.1);
  options.y_high = std::min(options.y_high, room.y_max_m + 0.1);

  SvgCanvas canvas(options);
  canvas.polygon({{room.x_min_m, room.y_min_m},
                  {room.x_max_m, room.y_min_m},
                  {room.x_max_m, room.y_max_m},
                  {room.x_min_m, room.y_max_m}},
                 stroke(PlotColor::text(), 2.0));
  for (const Obstacle& obstacle : input.world->obstacles) {
    const FloorOutline outline = floor_outline(obstacle);
    const SvgStyle style = filled(PlotColor::text(), 0.25);
    if (outline.radius_m > 0 && !outline.points_m.empty()) {
      canvas.circle(outline.points_m.front(), outline.radius_m, style);
    } else {
      canvas.polygon(outline.points_m, style);
    }
  }
  if (record.steps.empty()) return canvas.svg();
  const PlotColor robot = PlotColor::series(0), ball = PlotColor::series(1), goal = PlotColor::series(2);
  canvas.polyline(ball_path, stroke(ball, 1.5));
  canvas.polyline(path, stroke(robot, 2.0));
  const std::size_t marks = 6;
  for (std::size_t i = 0; i <= marks; ++i) {
    const StepRecord& step = record.steps[(record.steps.size() - 1) * i / marks];
    canvas.polygon(footprint_corners(input.footprint, step.pose), stroke(robot, 1.0, i != 0 && i != marks));
  }
  const StepRecord& last = record.steps.back();
  canvas.arrow({last.pose.x_m, last.pose.y_m}, in_world_frame(last.pose, {0.35, 0.0}), stroke(robot, 2.0));
  canvas.circle(last.p_WB.head<2>(), input.goal.distance_m, stroke(goal, 1.2, true));
  canvas.circle(last.p_WB.head<2>(), input.target->radius_m(), filled(ball, 0.8));
  canvas.text(path.front(), "start", TextAnchor::middle, 12, PlotColor::text(), {0, -34});
  return canvas.svg();
}

Svg image_trace(const RunRecord& record, const RunReportInput& input) {
  const ImageSize size = input.camera->size();
  SvgCanvasOptions options;
  options.title = "The ball's way through the picture";
  options.x_label = "u (px)";
  options.y_label = "v (px)";
  options.x_low = options.y_low = -0.5;
  options.x_high = size.width_px - 0.5;
  options.y_high = size.height_px - 0.5;
  options.y_down = true;
  options.width_px = 640;
  SvgCanvas canvas(options);
  std::vector<Eigen::Vector2d> truth;
  const double gap = std::numeric_limits<double>::quiet_NaN();
  for (const FrameRecord& frame : record.frames) {
    truth.push_back(frame.truth ? frame.truth->center_px : Eigen::Vector2d(gap, gap));
  }
  canvas.polyline(truth, stroke(PlotColor::series(0), 1.5));
  for (const FrameRecord& frame : record.frames) {
    if (frame.measured && frame.measurement.is_sighting()) {
      canvas.dot(frame.measured->center_px, 1.8, PlotColor::series(1));
    }
  }
  const Eigen::Vector3d desired = input.goal.desired_p_CB();
  canvas.polygon(project_outline(*input.camera, desired, input.target->radius_m(), 72),
                 stroke(PlotColor::series(2), 1.5, true));
  const auto ends = [&](const FrameRecord& frame) {
    if (frame.truth_p_CB) {
      canvas.polygon(project_outline(*input.camera, *frame.truth_p_CB, input.target->radius_m(), 72),
                     stroke(PlotColor::series(0), 1.0));
    }
  };
  if (!record.frames.empty()) {
    ends(record.frames.front());
    ends(record.frames.back());
  }
  return canvas.svg();
}

struct Columns {
  std::vector<double> t, range_mm, bearing_deg, v, w, v_command, w_command, error_1, error_2, clearance;
};

Columns columns_of(const std::vector<StepRecord>& steps) {
  Columns c;
  for (const StepRecord& s : steps) {
    c.t.push_back(s.time_s);
    c.range_mm.push_back(s.range_error_m * 1e3);
    c.bearing_deg.push_back(s.bearing_rad / degree);
    c.v.push_back(s.twist.v_mps);
    c.w.push_back(s.twist.w_radps / degree);
    c.v_command.push_back(s.control.command.v_mps);
    c.w_command.push_back(s.control.command.w_radps / degree);
    c.error_1.push_back(s.control.error_1);
    c.error_2.push_back(s.control.error_2);
    c.clearance.push_back(s.clearance_m);
  }
  return c;
}

PlotOptions over_time(const std::string& title, const std::string& label) {
  PlotOptions options;
  options.title = title;
  options.x.label = "time (s)";
  options.y.label = label;
  return options;
}

PlotSeries curve(const std::string& name, const std::vector<double>& x, const std::vector<double>& y,
                 bool dashed = false) {
  PlotSeries series;
  series.name = name;
  series.x = x;
  series.y = y;
  series.dashed = dashed;
  return series;
}

void add_plots(Page& page, const RunRecord& record, const RunReportInput& input) {
  const Columns c = columns_of(record.steps);
  PlotOptions range = over_time("Distance error", "range error (mm)");
  range.lines = {{false, 0.0, ""}};
  PlotOptions bearing = over_time("Bearing error", "bearing (deg)");
  bearing.lines = {{false, 0.0, ""}};
  page.heading("Errors over time");
  page.paragraph(
      "From the truth: the distance from axle to ball in the floor plane less the desired one, and the "
      "ball's bearing "
      "in the robot frame.");
  page.figures({drawing(line_plot({curve("", c.t, c.range_mm)}, range), "The whole run."),
                drawing(line_plot({curve("", c.t, c.bearing_deg)}, bearing), "The whole run.")});
  if (std::isfinite(record.summary.settled_s)) {
    PlotOptions range_end = range, bearing_end = bearing;
    range_end.title = "Distance error at the end";
    bearing_end.title = "Bearing error at the end";
    range_end.y.low = -1.2 * input.rule.range_m * 1e3;
    range_end.y.high = 1.2 * input.rule.range_m * 1e3;
    range_end.x.low = bearing_end.x.low = std::max(0.0, record.summary.settled_s - 0.5);
    bearing_end.y.low = -1.2 * input.rule.bearing_rad / degree;
    bearing_end.y.high = 1.2 * input.rule.bearing_rad / degree;
    range_end.lines = {{false, input.rule.range_m * 1e3, "limit"},
                       {false, -input.rule.range_m * 1e3, ""},
                       {true, record.summary.settled_s, "settled"}};
    bearing_end.lines = {{false, input.rule.bearing_rad / degree, "limit"},
                         {false, -input.rule.bearing_rad / degree, ""},
                         {true, record.summary.settled_s, "settled"}};
    page.figures(
        {drawing(line_plot({curve("", c.t, c.range_mm)}, range_end), "Within the limits of \"reached\"."),
         drawing(line_plot({curve("", c.t, c.bearing_deg)}, bearing_end),
                 "Within the limits of \"reached\".")});
  }
  page.figures(
      {drawing(line_plot({curve("error 1", c.t, c.error_1), curve("error 2", c.t, c.error_2)},
                         over_time("The law's own errors", "error")),
               fmt::format("Features less desired features of law {}, predicted for the moment when the "
                           "command acts.",
                           input.law)),
       drawing(line_plot({curve("", c.t, c.clearance)}, over_time("Clearance", "clearance (m)")),
               "From the footprint to the nearest wall or obstacle.")});
  page.heading("Commands");
  page.paragraph(
      "Dashed: as commanded. Solid: as driven, later by the actuation delay and within the drive's limits.");
  page.figures({drawing(line_plot({curve("driven", c.t, c.v), curve("commanded", c.t, c.v_command, true)},
                                  over_time("Forward speed", "v (m/s)")),
                        "The square-root shape of the braking envelope."),
                drawing(line_plot({curve("driven", c.t, c.w), curve("commanded", c.t, c.w_command, true)},
                                  over_time("Turning rate", "w (deg/s)")),
                        "Positive: to the left.")});
}

void add_states(Page& page, const std::vector<StepRecord>& steps) {
  PageTable table;
  table.heading = {"from (s)", "state", "why"};
  table.number_columns = {true, false, false};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const ControlOutput& now = steps[i].control;
    if (i > 0 && steps[i - 1].control.state == now.state && steps[i - 1].control.reason == now.reason)
      continue;
    table.rows.push_back({fmt::format("{:.2f}", steps[i].time_s), std::string(control_state_name(now.state)),
                          std::string(now.reason)});
  }
  page.heading("What the controller did, and why");
  page.table(table);
}

}  // namespace

std::string run_report_html(const RunRecord& record, const RunReportInput& input) {
  const RunSummary& s = record.summary;
  Page page(input.title,
            fmt::format("One closed-loop run: law {}, perception {}", input.law, input.perception));
  page.note(fmt::format("{}: {}.", outcome_name(s.outcome), s.outcome_text));
  page.key_values({
      {"distance error, last second", figure_or_dash(s.range_error_m, 1e3, 2, "mm")},
      {"bearing error, last second", figure_or_dash(s.bearing_error_rad, 1 / degree, 3, "deg")},
      {"settled after", figure_or_dash(s.settled_s, 1, 2, "s")},
      {"time-optimal run", figure_or_dash(s.time_optimal_s, 1, 2, "s")},
      {"settling / time-optimal", figure_or_dash(s.settled_s / s.time_optimal_s, 1, 2, "")},
      {"rms after settling", figure_or_dash(s.range_rms_m, 1e3, 2, "mm") + ", " +
                                 figure_or_dash(s.bearing_rms_rad, 1 / degree, 3, "deg")},
      {"least clearance", figure_or_dash(s.min_clearance_m, 1, 2, "m")},
      {"ball out of view", figure_or_dash(s.out_of_view_s, 1, 2, "s")},
      {"times the ball was lost", std::to_string(s.lost_events)},
      {"contacts with the ball", std::to_string(s.ball_contacts)},
      {"control steps", std::to_string(s.steps)},
  });
  if (input.video) {
    page.heading("The run as a film");
    page.video("video.mp4",
               "Left: the camera's picture with the ball's outline as measured. Right: the room from above.");
  }
  page.heading("The way");
  page.figures(
      {drawing(top_view(record, input),
               "Robot path (with its footprint at seven moments), ball, and the circle of the desired "
               "distance around it (dashed)."),
       drawing(image_trace(record, input),
               "Line: true centre of the outline. Dots: as measured. Circles: the outline in the first and "
               "the last frame, and where it should end (dashed).")});
  add_plots(page, record, input);
  if (!record.key_frames.empty()) {
    page.heading("Key frames");
    std::vector<PageFigure> pictures;
    for (const KeyFrame& key : record.key_frames) pictures.push_back(photo(key.picture, key.caption));
    page.figures(pictures);
  }
  add_states(page, record.steps);
  page.begin_details("The scenario as it was run");
  page.code(input.scenario_json);
  page.end_details();
  return page.html();
}

}  // namespace ballservo
