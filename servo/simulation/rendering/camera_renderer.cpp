#include "servo/simulation/rendering/camera_renderer.hpp"

#include <utility>

#include "calibration/base/options.hpp"
#include "servo/simulation/rendering/view_painter.hpp"

namespace ballservo {

CameraRenderer::CameraRenderer(const Camera& camera, World world, const SensorOptions& sensor)
    : camera_(camera), rays_(camera), world_(std::move(world)), light_map_(world_), sensor_(sensor) {
  check_options("sensor", sensor_);
}

void CameraRenderer::set_world(World world) {
  world_ = std::move(world);
  light_map_ = LightMap(world_);
}

cv::Mat CameraRenderer::view_radiance(const CameraView& view) const {
  const Scene scene(world_, view.time_s, &light_map_);
  return ViewPainter(rays_, scene, view.X_WC).paint();
}

cv::Mat CameraRenderer::radiance(const std::vector<CameraView>& exposure) const {
  if (exposure.size() == 1) return view_radiance(exposure.front());
  cv::Mat sum(camera_.size().height_px, camera_.size().width_px, CV_32FC3, cv::Scalar::all(0));
  for (const CameraView& view : exposure) sum += view_radiance(view);
  return exposure.empty() ? sum : cv::Mat(sum / static_cast<double>(exposure.size()));
}

cv::Mat CameraRenderer::render(const std::vector<CameraView>& exposure, std::uint64_t seed,
                               std::uint64_t frame_index) const {
  return expose(radiance(exposure), sensor_, seed, frame_index);
}

}  // namespace ballservo
