#include "servo/simulation/rendering/outline_coverage.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

double half_plane_share(double inside, double slope_x, double slope_y, double side) {
  const double x = std::abs(slope_x) * side / 2, y = std::abs(slope_y) * side / 2;
  const double longer = std::max(x, y), shorter = std::min(x, y);
  const double distance = std::abs(inside);
  double share = 1.0;  // of the side on which the centre lies
  if (distance < longer - shorter) {
    share = 0.5 + distance / (2 * longer);
  } else if (distance < longer + shorter) {
    const double corner = longer + shorter - distance;  // a triangle is cut off
    share = 1.0 - corner * corner / (8 * longer * shorter);
  }
  return inside >= 0 ? share : 1.0 - share;
}

}  // namespace ballservo
