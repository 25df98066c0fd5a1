// The way to the ball for a body that has a front: where to drive, which way it faces, and what it sees.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "servo/avoidance/navigation_function.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

/// Where the shield would not let the robot go, though the maps show room.
struct RefusedPose {
  Pose2 pose;
  double until_s = -1e9;  ///< for so long ways avoid it
};

/// What a way is planned for.
struct WayRequest {
  double time_s = 0;
  Pose2 from;                  ///< in the odometry's frame, as are all places here
  Eigen::Vector2d p_OB{0, 0};  ///< the ball, or another place to go to
  double half_view_rad = 0;    ///< the ball further aside is out of the picture; 0: views cost nothing
  std::array<RefusedPose, 8> refused{};
};

/// Poses from where the robot is to where the law can take over. Between two of them the robot drives
/// straight, ahead or astern, or turns on the spot.
struct Way {
  static constexpr std::size_t most = 160;
  std::array<Pose2, most> poses;
  std::size_t count = 0;
  double cost_m = 0;  ///< in metres on open floor
};

/// A* (Hart, Nilsson and Raphael, IEEE SSC 4, 1968) on a state lattice (Pivtoraiko, Knepper and Kelly,
/// J. Field Robotics 26, 2009): blocks of the navigation function times sixteen headings, joined by straight
/// moves and turns on the spot. The navigation function is the heuristic. A way costs its time, more where it
/// is narrow, and more while the ball is out of the picture or hidden. Allocates in the constructor only.
class WayPlanner {
 public:
  static constexpr int headings = 16;

  WayPlanner();

  /// Whether there is a way; `way` is left alone where there is none. A search that grows too long ends with
  /// the way to the place that it found to be nearest to the goal.
  bool plan(NavigationFunction& navigation, const WayRequest& request, Way& way);

  /// What the rest of a way costs now, from the pose nearest to the robot on; infinite where something has
  /// come to stand in it, or where it no longer leads to a place that faces the ball.
  double cost_m(NavigationFunction& navigation, const WayRequest& request, const Way& way) const;

 private:
  /// What a metre that ends at a pose costs: for the room there, infinite where the body does not fit; and
  /// for what is seen from there, and how often the shield refused it.
  struct Price {
    double room, more;
  };
  struct Node {
    Price price;
    float cost_m;             // from the start
    std::int32_t parent;      // state
    std::uint32_t epoch = 0;  // of the plan that priced it; others are stale
    bool closed;
  };
  struct Waiting {
    float total_m;
    std::int32_t state;
    bool operator<(const Waiting& other) const {  // std::push_heap keeps the greatest first
      return total_m != other.total_m ? total_m > other.total_m : state > other.state;
    }
  };

  static bool ends(const NavigationFunction& navigation, const WayRequest& request, const Pose2& pose);
  static Price price_at(NavigationFunction& navigation, const WayRequest& request, const Pose2& pose);
  static double move_cost_m(const NavigationFunction& navigation, const Pose2& from, const Pose2& to,
                            const Price& price_there);

  std::vector<Node> nodes_;
  std::vector<Waiting> heap_;
  std::uint32_t epoch_ = 0;
};

}  // namespace ballservo
