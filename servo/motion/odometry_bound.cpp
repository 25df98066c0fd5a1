#include "servo/motion/odometry_bound.hpp"

#include "calibration/base/options.hpp"

namespace ballservo {

void declare(OptionVisitor& v, OdometryBound& bound) {
  const NumberRange share = NumberRange::within(0, 0.2, "");
  v.number("distance_share", bound.distance_share, share, "largest error, of the way");
  v.number("turn_share", bound.turn_share, share, "largest error, of the turned angle");
  v.number("turn_per_m_radpm", bound.turn_per_m_radpm, NumberRange::within(0, 0.2, "rad/m"),
           "largest veering along the way");
}

}  // namespace ballservo
