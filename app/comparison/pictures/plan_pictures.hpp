// A plan's pictures, rendered with exact truth.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>

#include "app/comparison/pictures/picture_source.hpp"
#include "app/comparison/pictures/plan.hpp"

namespace ballservo {

/// The plan must outlive the source. Each ball colour is learnt, as a user would, from teaching pictures
/// rendered for it; each peer is set up for its condition on three frames that are not measured,
/// and whole detectors have seen them before.
class PlanPictures : public PictureSource {
 public:
  explicit PlanPictures(const ComparisonPlan& plan);

  const std::vector<ConditionInfo>& conditions() const override { return infos_; }
  void prepare(const std::vector<char>& needed) override;
  ComparisonPicture picture(std::size_t condition, int frame) const override;
  std::string peer_words(std::size_t condition) const override;

 private:
  struct Setup {
    DetectorSetup detector;
    PeerSettings peers;
    int hue = 0;
  };
  MethodTask task(std::size_t condition, const FrameTruth& truth) const;

  const ComparisonPlan& plan_;
  bool peers_asked_ = false, detectors_asked_ = false;
  std::vector<ConditionInfo> infos_;
  std::vector<Setup> setups_;
};

/// All that tells one camera from another.
nlohmann::json camera_identity(const Camera& camera);

/// A ball of that colour before the lab's walls, in a camera's usual blur and noise.
ComparisonCondition usual_scene(const std::string& name, const std::string& ball_color);

/// The colours of balls, a class each, as learnt from so many frames of each. Throws Refusal where one cannot
/// be learnt.
std::shared_ptr<const ColorTable> learn_rendered(const std::vector<ComparisonCondition>& balls, int frames,
                                                 std::uint64_t seed);

}  // namespace ballservo
