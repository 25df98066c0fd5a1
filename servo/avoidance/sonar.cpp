#include "servo/avoidance/sonar.hpp"

#include "calibration/base/options.hpp"

namespace ballservo {

void declare(OptionVisitor& v, SonarBeam& beam) {
  v.number("min_range_m", beam.min_range_m, NumberRange::above(0, 1, "m"), "nothing nearer is heard");
  v.number("max_range_m", beam.max_range_m, NumberRange::within(1, 10, "m"), "nothing further is heard");
  v.number("half_angle_rad", beam.half_angle_rad, NumberRange::within(0.02, 0.7, "rad"),
           "of the cone in which things echo");
}

}  // namespace ballservo
