#include "app/comparison/pictures/picture_source.hpp"

namespace ballservo {

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
