#include "perception/detection_stages.hpp"

#include <cmath>
#include <utility>

#include "perception/detector.hpp"

namespace ballservo {
namespace {

std::vector<Eigen::Vector2d> picture_outline(const Camera& camera, const TangentCone& cone) {
  return project_outline(camera, cone.axis, std::sin(cone.alpha_rad), 128);
}

}  // namespace

void Detector::record(int region, const VotedCircle& circle, const Candidate& candidate,
                      const RefinementInput& input, DetectionStages& stages) const {
  DetectionStages::Candidate shown;
  shown.region = region;
  shown.color_class = regions_.regions()[static_cast<std::size_t>(region)].color_class;
  shown.outline = remaining_;
  shown.votes = voter_.histogram();
  shown.radius_votes = voter_.radius_histogram();
  shown.estimate = circle.estimate;
  shown.accepted = !candidate.reason;
  shown.reason = candidate.reason ? candidate.reason : "";
  shown.support = candidate.support;
  const Camera& camera = rays_->camera();
  if (circle.cone) shown.estimate_outline_px = picture_outline(camera, *circle.cone);
  for (const RingPixel& pixel : input.ring) shown.ring_px.emplace_back(pixel.u_px, pixel.v_px);
  for (const EdgePoint& edge : input.edges) {
    if (const auto pixel = camera.project(edge.ray); pixel && edge.weight > 0)
      shown.ring_px.push_back(*pixel);
  }
  if (candidate.ball) shown.refined_outline_px = picture_outline(camera, candidate.ball->cone);
  stages.candidates.push_back(std::move(shown));
}

}  // namespace ballservo
