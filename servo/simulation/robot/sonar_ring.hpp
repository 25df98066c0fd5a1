// The simulated sonars: two arrays that fire one transducer after the other into the world.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "calibration/base/random.hpp"
#include "servo/avoidance/sonar.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

class OptionVisitor;

struct SonarOptions {
  SonarBeam beam;
  double height_m = 0.20;    ///< the plane in which all transducers look: what does not cross it has no echo
  double period_s = 0.040;   ///< between two firings of an array
  double latency_s = 0.030;  ///< from a firing until its answer is heard
  double noise_sigma_m = 0.005;  ///< of a range; cut off at three sigma
  double dropout_rate = 0;       ///< share of echoes that are not heard
  /// Surfaces answer only where the beam meets them at up to this angle from their normal: smooth ones throw
  /// the sound away. A right angle: every surface echoes.
  double specular_limit_rad = 1.5707963267948966;
  double crosstalk_rate = 0;  ///< share of firings that hear another's ping before their own echo

  /// The bound on a range's error (m).
  double noise_bound_m() const { return 3.0 * noise_sigma_m; }
};
void declare(OptionVisitor& v, SonarOptions& sonar);

/// What may be wrong with a transducer.
struct SonarFault {
  enum class Kind {
    dead,        ///< silent
    stuck,       ///< says over and over what it said first
    reads_long,  ///< every range is too long by `amount` (m)
    late         ///< every answer comes `amount` (s) late
  };
  Kind kind = Kind::dead;
  std::size_t transducer = 0;
  double from_s = 0;
  double amount = 0;
};

/// The order in which the transducers of an array fire: neighbours never one after the other.
inline constexpr std::array<std::size_t, 8> sonar_firing_order{0, 4, 1, 5, 2, 6, 3, 7};

/// What a firing said, and where the robot truly was.
struct SonarFiring {
  Pose2 pose;
  SonarReading reading;
};

class SonarRing {
 public:
  /// `world` must outlive the ring. The arrays take turns: one of them fires every half period.
  SonarRing(const World& world, const SonarOptions& options, std::vector<SonarFault> faults,
            std::uint64_t seed);

  /// The world's obstacles stand elsewhere from now on.
  void look_around();

  /// When the next transducer fires (s).
  double next_s() const { return 0.5 * options_.period_s * static_cast<double>(firings_); }

  /// Fires it, with the robot where it truly is then. What it will be heard to say; nothing of a dead one.
  std::optional<SonarFiring> fire(const Pose2& pose);

  /// Hands over every answer that has arrived by then, in the order of arrival.
  void deliver(double until_s, const std::function<void(const SonarReading&)>& hear);

  /// Distance (m) from a transducer to the nearest thing that echoes within its cone; no noise, no limits of
  /// range; infinite where there is nothing.
  double true_range_m(const Pose2& pose, std::size_t transducer, double time_s) const;

 private:
  struct Segment {
    Eigen::Vector2d from_m, to_m;  // heard from its right
  };
  struct Circle {
    Eigen::Vector2d center_m;
    double radius_m;
  };
  struct Answer {
    double arrives_s;
    SonarReading reading;
  };
  struct Beam;

  static void look_at(const Segment& segment, Beam& beam);
  static void look_at(const Circle& circle, Beam& beam);
  const SonarFault* fault_of(std::size_t transducer, double time_s) const;

  const World& world_;
  SonarOptions options_;
  std::vector<SonarFault> faults_;
  std::vector<Segment> segments_;
  std::vector<Circle> circles_;
  std::array<double, sonar_count> stuck_at_m_;
  std::vector<Answer> on_the_way_;
  RandomEngine engine_;
  long firings_ = 0;
};

}  // namespace ballservo
