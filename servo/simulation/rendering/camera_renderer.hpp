// Pictures of the simulated room through any calibrated lens.
//
// One ray per pixel where a pixel shows one surface, 16 where edges cross it, eight rays at once; a ball's
// outline is never sampled: each pixel that it crosses is cut into 64 squares, whose share inside the tangent
// cone is an exact area under a straight line (with the cone's own distance and slope in each square). So the
// outline errs by less than 0.01 px anywhere and its mean radius by less than 0.0005 px.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/camera.hpp"
#include "servo/simulation/rendering/lens_rays.hpp"
#include "servo/simulation/rendering/scene.hpp"
#include "servo/simulation/rendering/sensor.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

class CameraRenderer {
 public:
  /// Computes the ray of every pixel corner and the light on the room's surfaces. The sensor's options are
  /// checked (InputError).
  CameraRenderer(const Camera& camera, World world, const SensorOptions& sensor);

  /// Another world from now on; what light its lamps and obstacles let fall on the room is worked out anew.
  void set_world(World world);

  const Camera& camera() const { return camera_; }
  const World& world() const { return world_; }
  const SensorOptions& sensor() const { return sensor_; }

  /// Linear light on the pixels before optics' blur and the sensor: CV_32FC3, blue green red, 1 is full
  /// scale. Black where no ray reaches a pixel. The mean over the views, which stand for the instants of one
  /// exposure (one view: no motion blur). The camera must be inside the room.
  cv::Mat radiance(const std::vector<CameraView>& exposure) const;

  /// The picture as the camera gives it: 8-bit BGR. The noise is that of (seed, frame_index).
  cv::Mat render(const std::vector<CameraView>& exposure, std::uint64_t seed,
                 std::uint64_t frame_index) const;

 private:
  cv::Mat view_radiance(const CameraView& view) const;

  Camera camera_;
  LensRays rays_;
  World world_;
  LightMap light_map_;
  SensorOptions sensor_;
};

}  // namespace ballservo
