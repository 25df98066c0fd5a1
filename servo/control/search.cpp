#include "servo/control/search.hpp"

#include <cmath>

namespace ballservo {

namespace {

constexpr double search_radps = 0.7;    // 43 frames a radian at 30 Hz
constexpr double first_turn_rad = 0.6;  // of the first turn: half a wide picture
constexpr double whole_turn_rad = 6.8;  // and the ball's width over a full turn
constexpr double turning_radps = 0.1,
                 held_back_s = 0.8;   // slower for so long: the shield lets it turn no further
constexpr double much_sooner = 1.5;   // so many times, for turning back
constexpr int most_flips = 2;         // both ways have been tried
constexpr double excursion_s = 15.0;  // 4 m through gaps, at 0.25 to 0.6 m/s
constexpr double shortest_excursion_m = 0.4, arrived_m = 0.15;

double distance_m(const Pose2& pose, const Eigen::Vector2d& p_O) {
  return (p_O - Eigen::Vector2d(pose.x_m, pose.y_m)).norm();
}

}  // namespace

void Search::start(double time_s, const Pose2& pose) {
  start_ = pose;
  last_yaw_rad_ = pose.yaw_rad;
  resume_turn(time_s);
}

void Search::note_heading(double yaw_rad, bool searching) {
  if (searching) turned_rad_ += std::abs(wrap_angle(yaw_rad - last_yaw_rad_));
  last_yaw_rad_ = yaw_rad;
}

void Search::begin_turn(double time_s) {
  turned_rad_ = 0;
  turned_back_ = false;
  resume_turn(time_s);
}

void Search::prefer(double sooner_left) {
  looked_aside_ = true;  // or it need not
  const bool begins = turned_rad_ == 0.0;
  if (flips_ > 0 || (turned_back_ && !begins)) return;
  const double other_way = sign_ > 0.0 ? 1.0 / sooner_left : sooner_left;
  if (other_way <= (begins ? 1.0 : much_sooner)) return;
  sign_ = -sign_;
  turned_rad_ = 0;
  turned_back_ = !begins;
}

bool Search::looks(double time_s) const { return turned_rad_ == 0.0 && time_s - turn_since_s_ < look_s; }

bool Search::turn(double time_s, const Twist2& twist) {
  if (looks(time_s) || std::abs(twist.w_radps) > turning_radps) turning_s_ = time_s;
  if (time_s - turning_s_ > held_back_s) {
    sign_ = -sign_;
    ++flips_;
    turning_s_ = time_s;
  }
  // Where a robot is set down, the ball is rather ahead than behind.
  if (!looked_aside_ && turned_rad_ >= first_turn_rad) {
    looked_aside_ = true;
    turned_rad_ = 0;
    sign_ = -sign_;
  }
  if (turned_rad_ < whole_turn_rad && flips_ < most_flips) return false;
  flips_ = 0;
  return true;
}

Twist2 Search::turn_command(double time_s) const {
  return looks(time_s) ? Twist2{} : Twist2{0.0, sign_ * search_radps};
}

void Search::set_out(double time_s, const Pose2& pose, const Eigen::Vector2d& p_O) {
  ++excursions_;
  p_OD_ = distance_m(pose, p_O) < shortest_excursion_m ? Eigen::Vector2d(start_.x_m, start_.y_m) : p_O;
  turned_rad_ = 0;
  flips_ = 0;
  excursion_since_s_ = time_s;
}

bool Search::arrives(const Pose2& pose, const Twist2& twist, double a_max_mps2) const {
  return distance_m(pose, p_OD_) < arrived_m + 0.5 * twist.v_mps * twist.v_mps / a_max_mps2;
}

bool Search::out_of_time(double time_s) const { return time_s - excursion_since_s_ > excursion_s; }

bool Search::misses_ball(double time_s, bool in_view) {
  if (!in_view) expected_s_ = time_s;
  return time_s - expected_s_ > look_s;
}

}  // namespace ballservo
