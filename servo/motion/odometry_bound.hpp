// How wrong dead reckoning may be: the bound that the robot's makers state and everybody else relies on.
#pragma once

namespace ballservo {

class OptionVisitor;

/// Between two moments, with the path length s and the turned angle |turn| both summed without sign:
///   error of the path's length  <= distance_share * s
///   error of the heading        <= turn_share * |turn| + turn_per_m * s
struct OdometryBound {
  double distance_share = 0;    ///< m per m
  double turn_share = 0;        ///< rad per rad
  double turn_per_m_radpm = 0;  ///< rad per m

  /// Bound (m) on the error of where a resting point stands relative to the robot, after the path and turn
  /// since it was seen; `distance_m` is the point's distance from the axle now. The point's place in the
  /// robot frame changes by v and w x p, so its error grows by at most |dv| + |dw| |p|, and |p| was never
  /// more than distance_m + path_m.
  double point_error_m(double path_m, double turn_rad, double distance_m) const {
    return distance_share * path_m +
           (turn_share * turn_rad + turn_per_m_radpm * path_m) * (distance_m + path_m);
  }
};

void declare(OptionVisitor& v, OdometryBound& bound);

}  // namespace ballservo
