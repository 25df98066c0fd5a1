// A user's program: how large is a ball in the picture, and where is it, seen from its outline?
#include <cstdio>

#include "calibration/camera/camera.hpp"
#include "calibration/camera/sphere_outline.hpp"

int main() {
  ballservo::CameraParameters parameters;
  parameters.size = {640, 480};
  parameters.fx_px = parameters.fy_px = 500;
  parameters.cx_px = 319.5;
  parameters.cy_px = 239.5;
  const ballservo::Camera camera(parameters);

  const auto outline = ballservo::project_sphere(camera, {0, 0, 1}, 0.035);
  const auto ball = ballservo::sphere_from_rays(ballservo::outline_rays({0, 0, 1}, 0.035, 36), 0.035);
  if (!outline || !ball) return 1;
  std::printf("radius %.2f px, a ball at %.3f m\n", outline->radius_px, ball->z());
}
