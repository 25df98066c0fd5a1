// Whether a tracker keeps two balls of one colour apart that cross.
#pragma once

#include <cstdint>

#include "perception/tracking/tracker.hpp"
#include "tests/perception/tracking/moving_balls.hpp"

namespace ballservo::test {

/// The id of the track nearest to a place; 0 where none is near it.
inline int id_at(const std::vector<Track>& tracks, const Eigen::Vector3d& p_C, double reach_rad) {
  int id = 0;
  for (const Track& track : tracks) {
    const double angle = std::acos(std::min(1.0, track.ball.cone.axis.dot(p_C.normalized())));
    if (angle < reach_rad && track.state == TrackState::confirmed) id = track.id, reach_rad = angle;
  }
  return id;
}

/// One meeting; whether both balls have after it the ids that they had before.
inline bool keeps_identities(Meeting meeting, std::uint64_t seed) {
  constexpr double radius_m = 0.05, meet_s = 0.6, rate_hz = 30;
  constexpr int pictures = 32;
  const Camera camera = pinhole({320, 240}, 330);
  RandomEngine engine = random_stream(seed, meeting == Meeting::gap ? "gap" : "hiding");
  const auto balls = meeting_balls(meeting, radius_m, meet_s, engine);
  Tracker tracker(detector_for(camera, radius_m));
  std::array<int, 2> before{0, 0}, after{0, 0};
  for (int k = 0; k < pictures; ++k) {
    const double time_s = k / rate_hz;
    const auto& tracks = tracker.update(picture_of(camera, balls, time_s, radius_m, engine), time_s);
    for (std::size_t i = 0; i < 2; ++i) {
      const Eigen::Vector3d p_C = balls[i].at(time_s);
      if (k == 5) before[i] = id_at(tracks, p_C, radius_m / p_C.norm());
      if (k + 1 == pictures) after[i] = id_at(tracks, p_C, radius_m / p_C.norm());
    }
  }
  return before[0] > 0 && before[1] > 0 && before[0] != before[1] && before == after;
}

/// One ball that a wall hides for a quarter to half a second; whether it has its id again at the end, or when
/// it leaves the picture.
inline bool is_known_again(std::uint64_t seed) {
  constexpr double radius_m = 0.05, rate_hz = 30;
  const Camera camera = pinhole({320, 240}, 330);
  RandomEngine engine = random_stream(seed, "wall");
  const double speed_mps = uniform(engine, 0.35, 0.8), hidden_s = uniform(engine, 0.25, 0.5);
  const MovingBall ball{{-0.45, uniform(engine, -0.2, 0.2), 1.2},
                        {speed_mps, uniform(engine, -0.15, 0.15), uniform(engine, -0.1, 0.1)},
                        {uniform(engine, -0.2, 0.2), uniform(engine, -0.2, 0.2), 0}};
  // Behind the wall from the picture's middle on; seen for half a second again.
  double reaches_s = 0;
  while (ball.at(reaches_s).x() < -0.1) reaches_s += 0.01;
  const double left_px = camera.project(ball.at(reaches_s))->x();
  const double right_px = camera.project(ball.at(reaches_s + hidden_s))->x();
  Tracker tracker(detector_for(camera, radius_m));
  int before = 0, after = 0;
  for (double time_s = 0; time_s < reaches_s + hidden_s + 0.5; time_s += 1 / rate_hz) {
    cv::Mat bgr = grey_picture(320, 240);
    const Eigen::Vector3d p_C = ball.at(time_s);
    paint_shaded_ball(bgr, camera, p_C, radius_m, red);
    bgr.colRange(static_cast<int>(left_px), static_cast<int>(right_px)).setTo(cv::Scalar(70, 80, 90));
    add_noise(bgr, 2, engine);
    const auto& tracks = tracker.update(bgr, time_s);
    const int id = id_at(tracks, p_C, radius_m / p_C.norm());
    if (time_s < reaches_s - 0.1 && id > 0) before = id;
    const Eigen::Vector2d center_px = *camera.project(p_C);
    const double margin_px = 330 * radius_m / p_C.z() + 2;
    const bool in_view =
        center_px.x() < 320 - margin_px && center_px.y() > margin_px && center_px.y() < 240 - margin_px;
    if (in_view) after = id;
  }
  return before > 0 && after == before;
}

}  // namespace ballservo::test
