#include "app/experiment/run_video.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string_view>
#include <utility>

#include "app/report/overlay.hpp"

namespace ballservo {

namespace {

constexpr double text_size = 0.45;
constexpr std::size_t max_key_frames = 9;
const cv::Scalar seen_color{255, 0, 255}, predicted_color{190, 190, 190}, trail_color{178, 114, 0},
    ball_color{40, 40, 220}, ink{60, 60, 60}, room_color{250, 250, 250}, grid_color{228, 228, 228},
    solid_color{150, 150, 150}, goal_color{115, 158, 0}, intended_color{0, 140, 240},
    passed_color{80, 160, 20}, beam_color{235, 200, 140}, echo_color{160, 60, 160};

/// Text from the top left, broken between words so that it stays within the picture.
void text_block(cv::Mat& picture, std::string_view text) {
  const auto fits = static_cast<std::size_t>(std::max(10, (picture.cols - 16) / 8));
  for (int y = 18; !text.empty(); y += 18) {
    std::size_t length = text.size();
    if (length > fits) {
      length = text.rfind(' ', fits);
      if (length == std::string_view::npos || length == 0) length = fits;
    }
    draw_text(picture, std::string(text.substr(0, length)), {8, y}, text_size);
    text.remove_prefix(std::min(text.size(), length + 1));
  }
}

}  // namespace

std::vector<Eigen::Vector2d> foreseen_way(const Pose2& pose, const Twist2& twist, const Footprint& body) {
  constexpr double foreseen_s = 1.5;
  constexpr int parts = 15;
  std::vector<Eigen::Vector2d> way;
  for (int k = 0; k <= parts; ++k)
    way.push_back(in_world_frame(integrate(pose, twist, foreseen_s * k / parts), {body.front_m, 0.0}));
  return way;
}

void draw_detection(cv::Mat& bgr, const Camera& camera, const BallMeasurement& ball, double ball_radius_m,
                    const std::string& text) {
  if (ball.state != TrackState::none) {
    const cv::Scalar color = ball.is_sighting() ? seen_color : predicted_color;
    draw_polyline(bgr, project_outline(camera, ball.p_CB, ball_radius_m, 96), true, color);
    if (const auto center = camera.project(ball.p_CB)) draw_cross(bgr, *center, color);
  }
  draw_text(bgr, text, {8, bgr.rows - 10}, text_size);
}

namespace {

// Start, ball's places and what stands near their way, with room to go around it; within the walls.
Eigen::AlignedBox2d shown_floor(const World& world, const Eigen::Vector2d& p_WR,
                                const Eigen::AlignedBox2d& ball_floor) {
  const Eigen::Vector2d margin_m = Eigen::Vector2d::Constant(0.9), wall_m = Eigen::Vector2d::Constant(0.1);
  const Room& room = world.room;
  const Eigen::AlignedBox2d way(ball_floor.min().cwiseMin(p_WR) - margin_m,
                                ball_floor.max().cwiseMax(p_WR) + margin_m);
  const Eigen::AlignedBox2d around(way.min() - margin_m, way.max() + margin_m);
  Eigen::AlignedBox2d shown = way;
  for (const Obstacle& obstacle : world.obstacles) {
    const FloorOutline outline = floor_outline(obstacle);
    const Eigen::Vector2d reach_m = Eigen::Vector2d::Constant(outline.radius_m);
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& p : outline.points_m) {
      box.extend(p - reach_m);
      box.extend(p + reach_m);
    }
    if (!box.isEmpty() && box.intersects(around))
      shown.extend(Eigen::AlignedBox2d(box.min() - margin_m, box.max() + margin_m));
  }
  return shown.intersection({Eigen::Vector2d(room.x_min_m, room.y_min_m) - wall_m,
                             Eigen::Vector2d(room.x_max_m, room.y_max_m) + wall_m});
}

}  // namespace

TopView::TopView(const World& world, const Footprint& footprint, const Pose2& start,
                 const Eigen::AlignedBox2d& ball_floor, double goal_distance_m, int height_px,
                 const SonarBeam& beam)
    : footprint_(footprint), goal_distance_m_(goal_distance_m), beam_(beam), balls_(world.balls) {
  const Room& room = world.room;
  const Eigen::AlignedBox2d shown = shown_floor(world, {start.x_m, start.y_m}, ball_floor);
  const Eigen::Vector2d low = shown.min(), high = shown.max();
  const Eigen::Vector2d size = (high - low).cwiseMax(Eigen::Vector2d::Constant(0.5));
  // The x axis points up, the y axis to the left, as the robot sees the room when it starts along x.
  scale_ = height_px / std::max(size.x(), size.y() * 0.75);
  const int width_px =
      std::clamp(static_cast<int>(std::lround(size.y() * scale_)), height_px / 2, height_px * 4 / 3);
  low_ = Eigen::Vector2d(0.5 * (low.x() + high.x()) - 0.5 * height_px / scale_,
                         0.5 * (low.y() + high.y()) - 0.5 * width_px / scale_);
  room_ = cv::Mat(height_px, width_px, CV_8UC3, room_color);

  for (double x = std::ceil(low_.x()); x < low_.x() + height_px / scale_; x += 1.0) {
    draw_polyline(room_, pixels({{x, -1e3}, {x, 1e3}}), false, grid_color);
  }
  for (double y = std::ceil(low_.y()); y < low_.y() + width_px / scale_; y += 1.0) {
    draw_polyline(room_, pixels({{-1e3, y}, {1e3, y}}), false, grid_color);
  }
  const auto walls = pixels({{room.x_min_m, room.y_min_m},
                             {room.x_max_m, room.y_min_m},
                             {room.x_max_m, room.y_max_m},
                             {room.x_min_m, room.y_max_m}});
  draw_polyline(room_, walls, true, ink, 2);
  for (const Obstacle& obstacle : world.obstacles) {
    const FloorOutline outline = floor_outline(obstacle);
    if (outline.points_m.empty()) continue;
    if (outline.radius_m > 0) {
      draw_circle(room_, pixel(outline.points_m.front()), outline.radius_m * scale_, solid_color, cv::FILLED);
    } else {
      fill_polygon(room_, pixels(outline.points_m), solid_color);
    }
  }
}

Eigen::Vector2d TopView::pixel(const Eigen::Vector2d& p_W) const {
  return {room_.cols - 1 - (p_W.y() - low_.y()) * scale_, room_.rows - 1 - (p_W.x() - low_.x()) * scale_};
}

std::vector<Eigen::Vector2d> TopView::pixels(const std::vector<Eigen::Vector2d>& points_W) const {
  std::vector<Eigen::Vector2d> all;
  for (const Eigen::Vector2d& p : points_W) all.push_back(pixel(p));
  return all;
}

/// Each transducer's last firing, older ones apart: a round of all takes a third of a second.
void TopView::draw_beams(cv::Mat& picture, double now_s, const std::vector<SonarFiring>& firings) const {
  constexpr double round_s = 0.35, shown_range_m = 2.6;
  constexpr int arc_points = 12;
  cv::Mat cones = picture.clone();
  std::vector<std::vector<Eigen::Vector2d>> echoes;
  for (auto firing = firings.rbegin(); firing != firings.rend(); ++firing) {
    if (now_s - firing->reading.fired_s > round_s) break;
    const SonarMount& mount = pioneer_3dx_sonars[firing->reading.transducer];
    const Eigen::Vector2d apex = in_world_frame(firing->pose, {mount.x_m, mount.y_m});
    const double heading = firing->pose.yaw_rad + mount.heading_rad;
    const double range_m = std::min(firing->reading.range_m, shown_range_m);
    std::vector<Eigen::Vector2d> arc;
    for (int k = 0; k <= arc_points; ++k) {
      const double angle = heading + beam_.half_angle_rad * (2.0 * k / arc_points - 1.0);
      arc.push_back(pixel(apex + range_m * Eigen::Vector2d(std::cos(angle), std::sin(angle))));
    }
    if (firing->reading.echo && firing->reading.range_m <= shown_range_m) echoes.push_back(arc);
    arc.push_back(pixel(apex));
    fill_polygon(cones, arc, beam_color);
  }
  cv::addWeighted(cones, 0.35, picture, 0.65, 0, picture);
  for (const auto& echo : echoes) draw_polyline(picture, echo, false, echo_color, 2);
}

/// From the bottom left up.
void TopView::draw_legend(cv::Mat& picture, bool hears, bool looks_aside) const {
  int y = picture.rows - 9;
  const auto entry = [&](const std::string& words, const cv::Scalar& color, int length_px) {
    cv::line(picture, {8, y - 4}, {8 + length_px, y - 4}, color, 2, cv::LINE_AA);
    cv::putText(picture, words, {14 + length_px, y}, cv::FONT_HERSHEY_SIMPLEX, 0.38, ink, 1, cv::LINE_AA);
    y -= 15;
  };
  constexpr int sample_px = 16;
  entry("1 m", ink, static_cast<int>(std::lround(scale_)));
  entry("driven", trail_color, sample_px);
  entry("let pass", passed_color, sample_px);
  entry("asked for", intended_color, sample_px);
  if (hears) entry("echo", echo_color, sample_px);
  if (looks_aside) entry("the camera looks", ball_color, sample_px);
  entry(fmt::format("goal: axle to ball {:.2f} m", goal_distance_m_), goal_color, sample_px);
}

cv::Mat TopView::draw(const std::vector<StepRecord>& steps, const std::vector<SonarFiring>& firings) const {
  cv::Mat picture = room_.clone();
  if (steps.empty()) return picture;
  const StepRecord& now = steps.back();
  draw_beams(picture, now.time_s, firings);
  draw_legend(picture, !firings.empty(), now.pan.angle_rad != 0);
  for (const Ball& ball : balls_)
    draw_circle(picture, pixel(ball.p_WB(now.time_s).head<2>()), ball.radius_m() * scale_, solid_color,
                cv::FILLED);
  std::vector<Eigen::Vector2d> trail;
  for (const StepRecord& step : steps) trail.push_back(pixel({step.pose.x_m, step.pose.y_m}));
  draw_polyline(picture, trail, false, trail_color, 2);
  const Eigen::Vector2d target = pixel(now.p_WB.head<2>());
  draw_circle(picture, target, goal_distance_m_ * scale_, goal_color);
  draw_circle(picture, target, 4, ball_color, cv::FILLED);

  std::vector<Eigen::Vector2d> corners;
  for (const Eigen::Vector2d& corner : footprint_.corners())
    corners.push_back(pixel(in_world_frame(now.pose, corner)));
  draw_polyline(picture, corners, true, ink, 2);
  const Eigen::Vector2d axle = pixel({now.pose.x_m, now.pose.y_m});
  cv::arrowedLine(picture, subpixel(axle), subpixel(pixel(in_world_frame(now.pose, {0.4, 0.0}))), ink, 2,
                  cv::LINE_AA, subpixel_bits, 0.25);

  if (now.pan.angle_rad != 0) {
    const Pose2 looks{now.pose.x_m, now.pose.y_m, now.pose.yaw_rad + now.pan.angle_rad};
    draw_polyline(picture, {axle, pixel(in_world_frame(looks, {0.8, 0.0}))}, false, ball_color, 2);
  }

  // The way that each command would lead: as intended, and as guard and shield let it pass.
  const auto foreseen = [&](const Twist2& twist, const cv::Scalar& color) {
    draw_polyline(picture, pixels(foreseen_way(now.pose, twist, footprint_)), false, color, 3);
  };
  foreseen(now.control.intended, intended_color);
  foreseen(now.control.command, passed_color);
  if (!now.control.shield.empty()) text_block(picture, now.control.shield);
  return picture;
}

cv::Mat side_by_side(const cv::Mat& left, const cv::Mat& right) {
  cv::Mat scaled = right;
  if (right.rows != left.rows) {
    const double scale = static_cast<double>(left.rows) / right.rows;
    cv::resize(right, scaled, {std::max(2, static_cast<int>(std::lround(right.cols * scale))), left.rows}, 0,
               0, cv::INTER_AREA);
  }
  cv::Mat both;
  cv::hconcat(left, scaled, both);
  return both;
}

PictureKeeper::PictureKeeper(const Scenario& scenario, std::function<void(const cv::Mat& picture)> show)
    : scenario_(scenario), show_(std::move(show)) {}

void PictureKeeper::frame(const FrameEvent& event) {
  if (event.frame.bgr.empty()) return;
  const double time_s = event.frame.time_s;
  const ControlState state = state_;
  const bool changed = !last_ || last_->state != state;
  const bool halfway = state == ControlState::approach && time_s >= next_s_;
  last_ = {event.frame.bgr.clone(), time_s, state, event.percept.ball};
  const bool keep = (changed || halfway) && kept_.size() + 1 < max_key_frames;
  if (!keep && !show_) return;
  const cv::Mat picture = drawn(*last_);
  if (keep) {
    kept_.push_back({time_s, picture, fmt::format("{:.2f} s: {}", time_s, control_state_name(state))});
    next_s_ = time_s + 2.5;
  }
  if (show_) show_(picture);
}

cv::Mat PictureKeeper::drawn(const Seen& seen) const {
  std::string text = fmt::format("{:6.2f} s  {}  {}", seen.time_s, control_state_name(seen.state),
                                 track_state_name(seen.ball.state));
  if (seen.ball.state != TrackState::none) {
    const Eigen::Vector3d p_RB = scenario_.camera.mount.X_RC(seen.ball.pan_rad) * seen.ball.p_CB;
    text += fmt::format("  axle to ball {:.3f} m", p_RB.head<2>().norm());
  }
  cv::Mat picture = seen.bgr.clone();
  draw_detection(picture, scenario_.believed.camera(scenario_.camera.camera), seen.ball,
                 scenario_.goal().ball_radius_m, text);
  return picture;
}

std::vector<KeyFrame> PictureKeeper::finish() {
  if (last_)
    kept_.push_back({last_->time_s, drawn(*last_), fmt::format("{:.2f} s: the last frame", last_->time_s)});
  return std::move(kept_);
}

}  // namespace ballservo
