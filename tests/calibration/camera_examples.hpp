// Cameras of every lens model, bent as real ones are.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "calibration/camera/camera.hpp"

namespace ballservo::test {

struct CameraExample {
  std::string name;
  CameraParameters parameters;
};

/// What GoogleTest shows of it.
inline void PrintTo(const CameraExample& example, std::ostream* stream) { *stream << example.name; }

inline CameraParameters camera_parameters(LensModel model, double focal_px,
                                          const std::array<double, 8>& coefficients) {
  CameraParameters p;
  p.model = model;
  p.size = {640, 480};
  p.fx_px = focal_px;
  p.fy_px = 1.01 * focal_px;
  p.cx_px = 322.3;
  p.cy_px = 238.1;
  p.coefficients = coefficients;
  return p;
}

inline std::vector<CameraExample> camera_examples() {
  return {
      {"pinhole", camera_parameters(LensModel::pinhole, 520, {})},
      {"visp_barrel", camera_parameters(LensModel::visp, 535, {0.33})},
      {"visp_pincushion", camera_parameters(LensModel::visp, 602, {-0.06})},
      {"brown", camera_parameters(LensModel::brown, 533, {-0.2845, 0.0565, 1.1e-3, -5e-4, 0.0946})},
      {"brown8", camera_parameters(LensModel::brown8, 533, {-0.2, 0.3, 1e-3, -5e-4, 0.02, 0.1, 0.2, 0.05})},
      // 160 degrees across the picture's width.
      {"kannala_brandt_160",
       camera_parameters(LensModel::kannala_brandt, 236, {-0.02, 0.003, -0.001, 0.0001})},
      {"kannala_brandt_narrow",
       camera_parameters(LensModel::kannala_brandt, 533, {0.087, -0.35, 0.4, -0.2})}};
}

}  // namespace ballservo::test
