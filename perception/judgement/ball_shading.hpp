// Does what is seen of a ball look like a part of a sphere? Light falls on a sphere by its normals, on a flat
// thing evenly.
#pragma once

#include <opencv2/core.hpp>

#include "calibration/camera/ray_table.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "perception/judgement/outline_support.hpp"
#include "perception/outline/camera_response.hpp"
#include "perception/outline/cone_fit.hpp"

namespace ballservo {

/// Least squares of the brightness over a sphere's normals n: I = a + b . n (Lambert, any number of lamps
/// that reach the whole of what is seen) or, where that explains more, I = a + max(0, b . n) without glare
/// (one lamp and a terminator).
struct BallShading {
  double strength = 0;   ///< |b| of the former as a part of the mean brightness
  double explained = 0;  ///< of the brightness's variance beyond the noise; 0 to about 1
  /// The same by the best two even parts, a dark and a light one: all of it on a flat thing of two shades,
  /// three quarters of a ramp.
  double explained_by_two = 0;
  /// `strength` in the lighter of these parts alone: where a shadow falls across it, a flat thing has none.
  double strength_of_lighter = 0;
};

/// Over the ball's pixels inside the cone. Zeros where there are too few.
BallShading ball_shading(const cv::Mat& bgr, const CameraResponse& response, const ColoredPixels& colored,
                         const RayTable& rays, const TangentCone& cone, const OutlineEllipse& outline);

/// `BallShading::strength` alone, of fewer pixels: to about 0.05, in a thirtieth of the time.
double shading_strength(const cv::Mat& bgr, const CameraResponse& response, const ColoredPixels& colored,
                        const RayTable& rays, const TangentCone& cone, const OutlineEllipse& outline);

}  // namespace ballservo
