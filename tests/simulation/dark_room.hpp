// A world for measuring: a white ball that shows no shading in a black room, and lenses of every model.
#pragma once

#include <Eigen/Geometry>

#include "calibration/camera/camera.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo::test {

inline Material luminous(const Rgb& color) {
  Material material;
  material.texture.color = color;
  material.luminous = true;
  return material;
}

/// A room of 40 m around the origin, half a kilometre high, so that nothing but the balls is ever near.
inline World dark_room() {
  World world;
  world.room = {-20, 20, -20, 20, 500, luminous(Rgb::Zero()), luminous(Rgb::Zero()), luminous(Rgb::Zero())};
  return world;
}

inline Ball white_ball(const Eigen::Vector3d& position_m, double diameter_m) {
  Ball ball;
  ball.name = "ball";
  ball.class_name = "white";
  ball.diameter_m = diameter_m;
  ball.position_m = position_m;
  ball.material = luminous(Rgb::Ones());
  return ball;
}

inline Camera lens(LensModel model) {
  CameraParameters p;
  p.model = model;
  p.size = {640, 480};
  p.fx_px = model == LensModel::kannala_brandt ? 330 : 480;
  p.fy_px = p.fx_px + 3;
  p.cx_px = 322.3;
  p.cy_px = 236.8;
  switch (model) {
    case LensModel::pinhole:
      break;
    case LensModel::visp:
      p.coefficients = {0.15};
      break;
    case LensModel::brown:
      p.coefficients = {-0.25, 0.08, 0.001, -0.0008, 0.0};
      break;
    case LensModel::brown8:
      p.coefficients = {0.3, 0.05, 0.0005, -0.0004, 0.01, 0.55, 0.12, 0.02};
      break;
    case LensModel::kannala_brandt:
      p.coefficients = {-0.02, 0.005, -0.001, 0.0};
      break;
  }
  return Camera(p);
}

/// A camera in the middle of the dark room that looks along the world's x axis.
inline Eigen::Isometry3d level_view() {
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
  X_WC.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  X_WC.translation() = Eigen::Vector3d(0, 0, 250);
  return X_WC;
}

}  // namespace ballservo::test
