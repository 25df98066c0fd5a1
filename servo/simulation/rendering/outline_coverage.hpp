// How much of a small square of the picture lies inside a ball's outline.
#pragma once

namespace ballservo {

/// The share (0 to 1) of a square that lies on the inner side of a straight line. `inside` is the signed
/// distance of the square's centre from the line, positive inside; (slope_x, slope_y) the line's unit normal,
/// either way round; lengths in the unit of `side`.
double half_plane_share(double inside, double slope_x, double slope_y, double side);

}  // namespace ballservo
