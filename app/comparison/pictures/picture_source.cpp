#include "app/comparison/pictures/picture_source.hpp"

#include <algorithm>

namespace ballservo {

std::optional<UndistortedCircle> displaced_start(const Camera& camera, const OutlineEllipse& ball,
                                                 double center_sigma_px, double radius_sigma_px,
                                                 RandomEngine& engine) {
  auto start = undistorted_circle(camera, ball);
  if (!start) return start;
  for (double& coordinate : start->center_px) coordinate += center_sigma_px * standard_normal(engine);
  start->radius_px = std::max(1.0, start->radius_px + radius_sigma_px * standard_normal(engine));
  return start;
}

ComparisonRecord measure(const ComparisonPicture& picture, const MethodList& methods) {
  MethodScene scene(picture.bgr, picture.detector, picture.task);
  ComparisonRecord record;
  record.truth = picture.truth;
  record.fits = run_methods(scene, methods, picture.truth);
  if (const auto& vote = scene.vote()) record.facts = VoteFacts{vote->votes, vote->points, vote->quality()};
  if (scene.edges()) record.passes = scene.edges()->passes;
  return record;
}

}  // namespace ballservo
