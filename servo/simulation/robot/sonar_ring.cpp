#include "servo/simulation/robot/sonar_ring.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/base/options.hpp"

namespace ballservo {

namespace {

constexpr double nothing = std::numeric_limits<double>::infinity();

}  // namespace

void declare(OptionVisitor& v, SonarOptions& sonar) {
  const NumberRange rate = NumberRange::within(0, 1, "");
  declare(v, sonar.beam);
  v.number("height_m", sonar.height_m, NumberRange::above(0, 0.4, "m"),
           "the plane in which all transducers look: what does not cross it has no echo");
  v.number("period_s", sonar.period_s, NumberRange::within(0.005, 1, "s"), "between two firings of an array");
  v.number("latency_s", sonar.latency_s, NumberRange::within(0, 1, "s"), "from a firing to its answer");
  v.number("noise_sigma_m", sonar.noise_sigma_m, NumberRange::within(0, 0.2, "m"),
           "of a range; cut off at three sigma");
  v.number("dropout_rate", sonar.dropout_rate, rate, "share of echoes that are not heard");
  v.number("crosstalk_rate", sonar.crosstalk_rate, rate, "share of firings that hear another's ping first");
  v.number("specular_limit_rad", sonar.specular_limit_rad, NumberRange::above(0, 1.5708, "rad"),
           "surfaces echo up to this angle from their normal");
}

/// A cone seen from above, and the nearest echo in it so far.
struct SonarRing::Beam {
  Eigen::Vector2d apex_m, axis, right, left;  // unit vectors; right and left bound the cone
  double specular_tangent;                    // of the limit angle; infinite: everything echoes
  double specular_sine;
  double range_m = nothing;
};

/// The nearest point of the segment that lies in the cone and faces it well enough to echo.
void SonarRing::look_at(const Segment& segment, Beam& beam) {
  const Eigen::Vector2d a = segment.from_m - beam.apex_m, b = segment.to_m - beam.apex_m, along = b - a;
  const double length = along.norm();
  if (!(length > 0)) return;
  const Eigen::Vector2d unit = along / length;
  if (cross(a, unit) >= 0) return;  // seen from behind
  // Positions s along the segment that lie within both sides of the cone.
  double low = 0, high = length;
  const auto cut = [&](double at_start, double slope) {  // keeps at_start + slope s >= 0
    if (slope == 0) {
      if (at_start < 0) high = -1;
    } else if (slope > 0) {
      low = std::max(low, -at_start / slope);
    } else {
      high = std::min(high, -at_start / slope);
    }
  };
  cut(cross(beam.right, a), cross(beam.right, unit));
  cut(-cross(beam.left, a), -cross(beam.left, unit));
  cut(a.dot(beam.axis), unit.dot(beam.axis));
  const double foot = -a.dot(unit), distance = -cross(a, unit);
  if (std::isfinite(beam.specular_tangent)) {
    low = std::max(low, foot - distance * beam.specular_tangent);
    high = std::min(high, foot + distance * beam.specular_tangent);
  }
  if (low > high) return;
  beam.range_m = std::min(beam.range_m, std::hypot(distance, std::clamp(foot, low, high) - foot));
}

void SonarRing::look_at(const Circle& circle, Beam& beam) {
  const Eigen::Vector2d c = circle.center_m - beam.apex_m;
  const double distance = c.norm();
  if (distance - circle.radius_m >= beam.range_m || distance <= circle.radius_m) return;
  const bool right_of_left = cross(beam.left, c) <= 0, left_of_right = cross(beam.right, c) >= 0;
  if (right_of_left && left_of_right && c.dot(beam.axis) > 0) {
    beam.range_m = distance - circle.radius_m;
    return;
  }
  // The centre lies outside: the side of the cone nearest to it meets the circle first, if at all.
  const Eigen::Vector2d& side = right_of_left ? beam.right : beam.left;
  const double ahead = c.dot(side), aside = std::abs(cross(side, c));
  if (ahead <= 0 || aside >= circle.radius_m || aside / circle.radius_m > beam.specular_sine) return;
  beam.range_m = std::min(beam.range_m, ahead - std::sqrt(circle.radius_m * circle.radius_m - aside * aside));
}

SonarRing::SonarRing(const World& world, const SonarOptions& options, std::vector<SonarFault> faults,
                     std::uint64_t seed)
    : world_(world), options_(options), faults_(std::move(faults)), engine_(random_stream(seed, "sonar")) {
  stuck_at_m_.fill(-1);
  look_around();
}

void SonarRing::look_around() {
  segments_.clear();
  circles_.clear();
  // Outlines run so that what can be heard lies on their right: clockwise for the room.
  const auto add = [this](const std::vector<Eigen::Vector2d>& corners) {
    for (std::size_t k = 0; k < corners.size(); ++k)
      segments_.push_back({corners[k], corners[(k + 1) % corners.size()]});
  };
  const Room& room = world_.room;
  add({{room.x_min_m, room.y_min_m},
       {room.x_min_m, room.y_max_m},
       {room.x_max_m, room.y_max_m},
       {room.x_max_m, room.y_min_m}});
  for (const Obstacle& obstacle : world_.obstacles) {
    if (obstacle.bottom_m() > options_.height_m || obstacle.top_m() < options_.height_m) continue;
    const FloorOutline outline = floor_outline(obstacle);
    if (outline.radius_m > 0) {
      circles_.push_back({outline.points_m.front(), outline.radius_m});
    } else {
      add(outline.points_m);
    }
  }
}

double SonarRing::true_range_m(const Pose2& pose, std::size_t transducer, double time_s) const {
  const SonarMount& mount = pioneer_3dx_sonars[transducer];
  const double heading = pose.yaw_rad + mount.heading_rad, half = options_.beam.half_angle_rad;
  const auto unit = [](double angle) { return Eigen::Vector2d(std::cos(angle), std::sin(angle)); };
  const bool all_echo = options_.specular_limit_rad >= 1.57;
  Beam beam{in_world_frame(pose, {mount.x_m, mount.y_m}),
            unit(heading),
            unit(heading - half),
            unit(heading + half),
            all_echo ? nothing : std::tan(options_.specular_limit_rad),
            all_echo ? 1.0 : std::sin(options_.specular_limit_rad)};
  for (const Segment& segment : segments_) look_at(segment, beam);
  for (const Circle& circle : circles_) look_at(circle, beam);
  for (const Ball& ball : world_.balls) {
    if (ball.sonar) look_at(Circle{ball.p_WB(time_s).head<2>(), ball.radius_m()}, beam);
  }
  return beam.range_m;
}

const SonarFault* SonarRing::fault_of(std::size_t transducer, double time_s) const {
  for (const SonarFault& fault : faults_) {
    if (fault.transducer == transducer && time_s >= fault.from_s) return &fault;
  }
  return nullptr;
}

std::optional<SonarFiring> SonarRing::fire(const Pose2& pose) {
  const double time_s = next_s();
  const auto turn = static_cast<std::size_t>(firings_++);
  SonarReading reading;
  reading.fired_s = time_s;
  reading.transducer = 8 * (turn % 2) + sonar_firing_order[(turn / 2) % 8];

  // The same draws at every firing, whatever comes of them.
  const double noise = std::clamp(standard_normal(engine_), -3.0, 3.0) * options_.noise_sigma_m;
  const bool dropped = uniform01(engine_) < options_.dropout_rate;
  const bool disturbed = uniform01(engine_) < options_.crosstalk_rate;
  const double disturbed_share = uniform01(engine_);

  const SonarBeam& beam = options_.beam;
  double range_m = true_range_m(pose, reading.transducer, time_s) + noise;
  if (dropped || range_m > beam.max_range_m) range_m = beam.max_range_m;
  // A foreign ping is heard before the own echo: what comes first counts.
  if (disturbed) range_m = beam.min_range_m + disturbed_share * (range_m - beam.min_range_m);

  double arrives_s = time_s + options_.latency_s;
  if (const SonarFault* fault = fault_of(reading.transducer, time_s)) {
    if (fault->kind == SonarFault::Kind::dead) return std::nullopt;
    if (fault->kind == SonarFault::Kind::reads_long) range_m += fault->amount;
    if (fault->kind == SonarFault::Kind::late) arrives_s += fault->amount;
    if (fault->kind == SonarFault::Kind::stuck) {
      double& stuck_at_m = stuck_at_m_[reading.transducer];
      if (stuck_at_m < 0) stuck_at_m = range_m;
      range_m = stuck_at_m;
    }
  }
  reading.range_m = std::clamp(range_m, beam.min_range_m, beam.max_range_m);
  reading.echo = reading.range_m < beam.max_range_m;
  const Answer answer{arrives_s, reading};
  const auto later =
      std::upper_bound(on_the_way_.begin(), on_the_way_.end(), answer,
                       [](const Answer& a, const Answer& b) { return a.arrives_s < b.arrives_s; });
  on_the_way_.insert(later, answer);
  return SonarFiring{pose, reading};
}

void SonarRing::deliver(double until_s, const std::function<void(const SonarReading&)>& hear) {
  std::size_t count = 0;
  while (count < on_the_way_.size() && on_the_way_[count].arrives_s <= until_s)
    hear(on_the_way_[count++].reading);
  on_the_way_.erase(on_the_way_.begin(), on_the_way_.begin() + static_cast<std::ptrdiff_t>(count));
}

}  // namespace ballservo
