#include "app/comparison/pictures/picture_source.hpp"

#include <opencv2/imgproc.hpp>

#include "perception/detector.hpp"

namespace ballservo {

ComparisonRecord measure(const ComparisonPicture& picture, const MethodList& methods) {
  // A detector learns from what it sees: each picture gets its own.
  Detector detector(picture.rays, picture.colors, picture.options);
  MethodScene scene(picture.bgr, detector, picture.task);
  ComparisonRecord record;
  record.truth = picture.truth;
  record.fits = run_methods(scene, methods);
  if (const auto& vote = scene.vote()) record.facts = VoteFacts{vote->votes, vote->points, vote->quality()};
  if (scene.edges()) record.passes = scene.edges()->passes;
  return record;
}

}  // namespace ballservo
