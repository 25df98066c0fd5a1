// The laws that ballservo brings.
#pragma once

#include "servo/control/law.hpp"

namespace ballservo {

/// Each a set of features in a task of ViSP's (visp_servo_law.hpp), derived in ball_feature.hpp:
///   cone    log range and azimuth of the tangent cone, levelled; the default
///   visp    x = X/Z of the ball's centre (vpFeaturePoint) and log(Z / Z*) (vpFeatureDepth)
///   sphere  the first two of the centre over the radius, levelled
///   pose    range and bearing from the axle in metres
///
/// visp in closed form, with s and c the sine and cosine of the pitch and l the camera's distance ahead of
/// the axle:
///
///     [x'       ]   [ c x / Z   (1 + x^2) c - y s + l / Z ] [v]
///     [(log Z)' ] = [ -c / Z    -x c                      ] [w],    det = c X_R / Z^2,
///
/// singular exactly when the ball is abeam of the axle (X_R = Z (c - y s) + l = 0), and not defined for Z <=
/// 0: a goal behind the camera is an InputError.
LawCatalog builtin_laws();

}  // namespace ballservo
