#include "app/sweep/sweep_drawings.hpp"

#include <algorithm>

#include "app/report/svg_canvas.hpp"

namespace ballservo {
namespace {

const PlotColor way_color = PlotColor::series(0), failed_color = PlotColor::series(1),
                ball_color = PlotColor::series(2);

SvgStyle stroke(const PlotColor& color, double width_px, double opacity = 1) {
  SvgStyle style;
  style.stroke = color;
  style.width_px = width_px;
  style.opacity = opacity;
  return style;
}

SvgCanvas canvas_of(const Room& room, const std::string& title, int width_px, bool axes) {
  SvgCanvasOptions options;
  options.title = title;
  if (axes) {
    options.x_label = "x (m)";
    options.y_label = "y (m)";
  }
  options.axes = axes;
  options.width_px = width_px;
  options.x_low = room.x_min_m - 0.1;
  options.x_high = room.x_max_m + 0.1;
  options.y_low = room.y_min_m - 0.1;
  options.y_high = room.y_max_m + 0.1;
  return SvgCanvas(options);
}

void draw_room(SvgCanvas& canvas, const Room& room) {
  canvas.polygon({{room.x_min_m, room.y_min_m},
                  {room.x_max_m, room.y_min_m},
                  {room.x_max_m, room.y_max_m},
                  {room.x_min_m, room.y_max_m}},
                 stroke(PlotColor::text(), 2));
}

void draw_obstacles(SvgCanvas& canvas, const std::vector<FloorOutline>& obstacles) {
  SvgStyle style = stroke(PlotColor::text(), 1);
  style.fill = PlotColor::text();
  style.fill_opacity = 0.25;
  for (const FloorOutline& outline : obstacles) {
    if (outline.radius_m > 0 && !outline.points_m.empty()) {
      canvas.circle(outline.points_m.front(), outline.radius_m, style);
    } else {
      canvas.polygon(outline.points_m, style);
    }
  }
}

bool same_obstacles(const TrialTrace& a, const TrialTrace& b) {
  return a.obstacles.size() == b.obstacles.size() &&
         std::equal(a.obstacles.begin(), a.obstacles.end(), b.obstacles.begin(),
                    [](const FloorOutline& p, const FloorOutline& q) {
                      return p.radius_m == q.radius_m && p.points_m == q.points_m;
                    });
}

bool moves(const TrialTrace& trace) {
  return !trace.ball_path.empty() && trace.ball_path.front() != trace.ball_path.back();
}

}  // namespace

Svg ways_drawing(const std::vector<DrawnTrial>& trials) {
  Room room = trials.empty() ? Room{} : trials.front().trace.room;
  bool shared = true;
  for (const DrawnTrial& trial : trials) {
    const Room& other = trial.trace.room;
    room.x_min_m = std::min(room.x_min_m, other.x_min_m);
    room.x_max_m = std::max(room.x_max_m, other.x_max_m);
    room.y_min_m = std::min(room.y_min_m, other.y_min_m);
    room.y_max_m = std::max(room.y_max_m, other.y_max_m);
    shared = shared && same_obstacles(trial.trace, trials.front().trace);
  }
  SvgCanvas canvas = canvas_of(room, "All ways from above", 760, true);
  draw_room(canvas, room);
  if (shared && !trials.empty()) draw_obstacles(canvas, trials.front().trace.obstacles);
  const double opacity = std::clamp(30.0 / static_cast<double>(trials.size() + 1), 0.15, 0.8);
  for (const bool reached : {true, false}) {
    for (const DrawnTrial& trial : trials) {
      if (trial.reached != reached || trial.trace.path.empty()) continue;
      const PlotColor color = reached ? way_color : failed_color;
      canvas.polyline(trial.trace.path, stroke(color, reached ? 1 : 1.5, reached ? opacity : 0.8));
      if (!reached) canvas.dot(trial.trace.path.back(), 3, color);
    }
  }
  for (const DrawnTrial& trial : trials) {
    if (!trial.trace.ball_path.empty()) canvas.dot(trial.trace.ball_path.front(), 2, ball_color);
  }
  return canvas.svg();
}

Svg way_drawing(const DrawnTrial& trial, double goal_distance_m, int width_px) {
  const TrialTrace& trace = trial.trace;
  SvgCanvas canvas = canvas_of(trace.room, "seed " + std::to_string(trace.seed), width_px, false);
  draw_room(canvas, trace.room);
  draw_obstacles(canvas, trace.obstacles);
  if (trace.path.empty()) return canvas.svg();
  if (moves(trace)) canvas.polyline(trace.ball_path, stroke(ball_color, 1, 0.6));
  canvas.polyline(trace.path, stroke(way_color, 1.5));
  canvas.dot(trace.path.front(), 3, way_color);
  const Footprint body = pioneer_3dx_footprint;
  const Pose2 end{trace.path.back().x(), trace.path.back().y(), trace.end_yaw_rad};
  std::vector<Eigen::Vector2d> corners;
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(body.front_m, body.half_width_m), Eigen::Vector2d(-body.rear_m, body.half_width_m),
        Eigen::Vector2d(-body.rear_m, -body.half_width_m),
        Eigen::Vector2d(body.front_m, -body.half_width_m)}) {
    corners.push_back(in_world_frame(end, corner));
  }
  canvas.polygon(corners, stroke(way_color, 1.2));
  canvas.arrow(trace.path.back(), in_world_frame(end, {0.35, 0}), stroke(way_color, 1.5), 6);
  SvgStyle goal = stroke(ball_color, 1);
  goal.dashed = true;
  canvas.circle(trace.ball_path.back(), goal_distance_m, goal);
  canvas.dot(trace.ball_path.back(), 4, ball_color);
  return canvas.svg();
}

}  // namespace ballservo
