// What the sonars have shown to be free, around the robot, in the odometry's frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "servo/avoidance/floor_region.hpp"
#include "servo/avoidance/floor_scan.hpp"
#include "servo/avoidance/floor_window.hpp"
#include "servo/avoidance/sonar.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

class OptionVisitor;

struct OccupancyGridOptions {
  SonarBeam beam;
  OdometryBound odometry;
  double range_error_m = 0.025;   ///< bound on the error of a range, the place of the transducer included
  double look_range_m = 2.6;      ///< nothing further off is remembered of a firing
  double start_clear_m = 0.70;    ///< at the start nothing stands within this of the axle: an assumption
  double drift_allowed_m = 0.04;  ///< what was seen free counts until odometry may have drifted so far
  double memory_s = 45.0;         ///< and so long, counted while the robot moves
  Footprint footprint;
};
/// What a user can set: the rest follows from the robot.
void declare(OptionVisitor& v, OccupancyGridOptions& grid);

/// A window of the floor around the robot, in square cells. Allocates in the constructor only.
///
/// A cell is *free* when a firing's cone held the whole of it, short of the echo (and of the echo that the
/// same transducer heard the time before: one that is missed once does no harm), and neither odometry's drift
/// since then nor the time in motion since then exceed what is allowed. What was never seen is not free. An
/// echo lies somewhere on an arc: where some cell of the arc is not free, that explains it; where all are,
/// and the echo is heard twice, something has come, and the whole arc is free no longer.
///
/// What the camera sees standing on the floor in two scans, one after the other, is *standing*: not free, and
/// no firing makes it so, until the camera sees floor there or the robot's body has been there.
class OccupancyGrid {
 public:
  static constexpr double cell_m = 0.03, half_diagonal_m = 0.7071067811865476 * cell_m;
  static constexpr int size = 256;  ///< cells along each side: 7.68 m

  static constexpr double angle_error_rad = 0.01;  ///< taken off the beam's half angle
  /// Less drift than allowed asks for less clearance: where the robot passes close, only what was seen lately
  /// counts.
  static constexpr double drift_close_m = 0.012;

  /// How far odometry may have drifted since a cell was seen free.
  enum class Drift { allowed, close };

  explicit OccupancyGrid(const OccupancyGridOptions& options);

  /// The robot is there now; times must not run backwards. The first call is the start.
  void move(double time_s, const Pose2& pose);

  /// A firing, with the odometry's pose at that moment.
  void look(const SonarReading& reading, const Pose2& pose_then);

  /// A frame's word on the floor, with the odometry's pose when it was exposed.
  void look_at_floor(const FloorScan& scan, const Pose2& pose_then);

  bool in_window(const FloorCell& cell) const { return window_.contains(cell); }
  bool is_free(const FloorCell& cell, Drift drift = Drift::allowed) const {
    return in_window(cell) &&
           (is_fresh(cell, drift) || still_free(cell, free_since_[window_.index(cell)], drift));
  }
  /// Calls `visit` with each cell from one corner to another that is not free.
  template <typename Visit>
  void visit_not_free(const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m, Drift drift,
                      const Visit& visit) const {
    const FloorCell low = cell_at(low_m.x(), low_m.y()), high = cell_at(high_m.x(), high_m.y());
    const bool is_inside = in_window(low) && in_window(high);
    for (int row = low.row; row <= high.row; ++row)
      for (int column = low.column; column <= high.column; ++column)
        if (!(is_inside && is_fresh({column, row}, drift)) && !is_free({column, row}, drift))
          visit(FloorCell{column, row});
  }
  bool is_standing(const FloorCell& cell) const;

  static FloorCell cell_at(double x_m, double y_m) { return {index_at(x_m), index_at(y_m)}; }
  /// Of the column at x or the row at y.
  static int index_at(double value_m) { return floor_index(value_m, cell_m); }
  static double center_m(int index) { return (index + 0.5) * cell_m; }

  double drift_m(Drift drift) const {
    return drift == Drift::allowed ? options_.drift_allowed_m : drift_close_m;
  }

  /// Whether every cell is free that comes within `margin_m`, and the drift, of the footprint at that pose.
  /// `from` is where the footprint stands now without touching anything. With it a cell that is not free is
  /// let pass if it comes no nearer to the footprint than it is from there; one under the footprint's edge
  /// only if it was seen free before.
  bool covers(const Footprint& footprint, const Pose2& pose, double margin_m, Drift drift,
              const Pose2* from = nullptr) const;

  const OccupancyGridOptions& options() const { return options_; }
  const Pose2& pose() const { return pose_; }

 private:
  /// Path and turn so far when an epoch began; epochs follow each other only while the robot moves.
  struct Epoch {
    double time_s = 0, motion_s = 0, path_m = 0, turn_rad = 0;
  };

  void take_back(const FloorCell& cell);
  void set_standing(const FloorCell& cell, bool yes) {
    std::uint8_t& standing = standing_[window_.index(cell)];
    standing_cells_ += (yes ? 1 : 0) - standing;
    standing = yes ? 1 : 0;
  }
  std::uint32_t epoch_at(double time_s) const;
  bool still_counts(std::uint32_t seen, double distance_m, Drift drift) const;
  /// Whether a cell of the window was seen free so lately that it counts wherever it is.
  bool is_fresh(const FloorCell& cell, Drift drift) const {
    return free_since_[window_.index(cell)] >= motion_.fresh[static_cast<std::size_t>(drift)];
  }
  bool still_free(const FloorCell& cell, std::uint32_t seen, Drift drift) const;
  /// Free, but for what is standing; where the body has been nothing stands.
  void mark_free(const FloorRegion& region, std::uint32_t epoch_number, bool by_body);
  bool comes_no_nearer(const FloorCell& cell, const Footprint& footprint, const Pose2& pose,
                       const Pose2& from) const;
  void mark_arc(const SonarReading& reading, const Pose2& transducer, bool heard_before);
  void forget(std::size_t index);

  OccupancyGridOptions options_;
  bool started_ = false;
  Pose2 pose_;
  FloorWindow<size> window_;
  // Instead of the number of the epoch in which a cell was seen free: never; or it was, but then something
  // was heard or seen there.
  static constexpr std::uint32_t never = 0, taken_back = 1, first_epoch = 2;
  /// How far the robot has moved, by epochs.
  struct Motion {
    std::array<Epoch, 2048> epochs{};
    std::uint32_t now = first_epoch;  ///< number of the current epoch
    /// By Drift: what was seen free then or later counts in all the window.
    std::array<std::uint32_t, 2> fresh{first_epoch, first_epoch};
    Epoch sum;  ///< path and turn up to now

    const Epoch& epoch(std::uint32_t number) const { return epochs[number % epochs.size()]; }
  };
  Motion motion_;
  std::array<double, sonar_count> last_range_m_{};
  std::vector<std::uint32_t> free_since_;
  std::vector<std::uint8_t> standing_;  // 1: of a cell where something stands
  int standing_cells_ = 0;
  std::uint32_t scans_ = 1;                 // number of the last scan; the first is 2
  std::vector<std::uint32_t> glimpsed_in_;  // last scan that showed something in a cell; 0: none
};

}  // namespace ballservo
