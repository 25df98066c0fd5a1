#include "app/experiment/ball_sight.hpp"

#include <algorithm>
#include <cmath>

#include "app/io/ball_rows.hpp"
#include "calibration/base/fault.hpp"
#include "perception/tracking/tracker.hpp"
#include "servo/simulation/robot/geometric_ball_sensor.hpp"

namespace ballservo {

std::string_view perception_level_name(PerceptionLevel level) {
  switch (level) {
    case PerceptionLevel::image:
      return "image";
    case PerceptionLevel::geometric:
      return "geometric";
    case PerceptionLevel::truth:
      break;
  }
  return "truth";
}

PerceptionLevel parse_perception_level(const std::string& text) {
  for (const PerceptionLevel level :
       {PerceptionLevel::image, PerceptionLevel::geometric, PerceptionLevel::truth}) {
    if (text == perception_level_name(level)) return level;
  }
  throw InputError("--perception", text, "image, geometric or truth");
}

namespace {

constexpr const char* source_name = "camera";
constexpr double height_slack_m = 0.20, height_slack_per_m = 0.03;  // of the target, and by its range

class ImageSight final : public BallSight {
 public:
  ImageSight(Detector detector, const TrackerOptions& options, ClassIndex target_class, const ServoGoal& goal,
             double lift_m)
      : tracker_(std::move(detector), options),
        target_class_(target_class),
        X_RC_(goal.mount.X_RC()),
        low_m_(goal.desired_p_RB().z() - height_slack_m),
        high_m_(goal.desired_p_RB().z() + lift_m + height_slack_m) {}

  Sight look(const SightInput& input, std::string& rows) override {
    const std::vector<Track>& tracks = tracker_.update(*input.picture, input.time_s);
    for (const Track& track : tracks) {
      rows += ball_row({source_name, input.frame, input.time_s, track.id, class_name(track.color_class),
                        track_state_name(track.state)},
                       track.ball);
    }
    Sight sight;
    sight.measurement.time_s = input.time_s;
    const Track* target = choose(tracks);
    if (target == nullptr) return sight;
    sight.measurement.state = target->state;
    sight.measurement.p_CB = target->ball.position->p_C;
    sight.measurement.covariance_m2 = target->ball.position->covariance_m2;
    sight.outline = target->ball.outline;
    return sight;
  }

 private:
  const std::string& class_name(ClassIndex color_class) const {
    return tracker_.detector().colors().classes.at(static_cast<std::size_t>(color_class) - 1).name;
  }

  const Track* choose(const std::vector<Track>& tracks) {
    const Track* best = nullptr;
    for (const Track& track : tracks) {
      if (track.color_class != target_class_ || !lies_at_height(track)) continue;
      if (track.id == followed_) return &track;
      // Confirmed before tentative, then the better outline; the tracks stand in order of their age.
      const auto rank = [](const Track& t) { return t.state == TrackState::confirmed ? 2 : 1; };
      if (best == nullptr || rank(track) > rank(*best) ||
          (rank(track) == rank(*best) && track.ball.quality > best->ball.quality)) {
        best = &track;
      }
    }
    followed_ = best != nullptr && best->state == TrackState::confirmed ? best->id : 0;
    return best;
  }

  bool lies_at_height(const Track& track) const {
    if (!track.ball.position) return false;
    const Eigen::Vector3d p_RB = X_RC_ * track.ball.position->p_C;
    const double slack_m = height_slack_per_m * p_RB.head<2>().norm();
    return p_RB.z() > low_m_ - slack_m && p_RB.z() < high_m_ + slack_m;
  }

  Tracker tracker_;
  ClassIndex target_class_;
  Eigen::Isometry3d X_RC_;
  double low_m_, high_m_;  // between which the target is looked for, at no range
  int followed_ = 0;       // ids count from 1
};

class GeometricSight final : public BallSight {
 public:
  GeometricSight(const Camera& camera, const Ball& target, const GeometricSensorOptions& options,
                 std::uint64_t seed, const std::optional<BelievedView>& believed)
      : camera_(camera), sensor_(camera, options, seed), target_(target), believed_(believed) {}

  Sight look(const SightInput& input, std::string& rows) override {
    Sight sight;
    sight.measurement = sensor_.measure(*input.target, target_.diameter_m, input.time_s,
                                        static_cast<std::uint64_t>(input.frame));
    if (sight.measurement.state == TrackState::none) return sight;
    sight.outline = project_sphere(camera_, sight.measurement.p_CB, target_.radius_m());
    if (believed_) {
      const auto outline = project_outline(camera_, sight.measurement.p_CB, target_.radius_m(), 32);
      const auto believed_p_CB = sphere_from_outline(believed_->camera, outline, believed_->radius_m);
      if (!believed_p_CB) {
        sight.measurement.state = TrackState::none;
        return sight;
      }
      sight.measurement.p_CB = *believed_p_CB;
    }
    BallObservation ball;
    if (sight.outline) ball.outline = *sight.outline;
    ball.position = BallPosition{sight.measurement.p_CB, sight.measurement.covariance_m2};
    ball.quality = input.target->visible_fraction;
    rows += ball_row({source_name, input.frame, input.time_s, 1, target_.class_name,
                      track_state_name(sight.measurement.state)},
                     ball);
    return sight;
  }

 private:
  Camera camera_;
  GeometricBallSensor sensor_;
  Ball target_;
  std::optional<BelievedView> believed_;
};

}  // namespace

std::unique_ptr<BallSight> make_image_sight(const Camera& camera, std::shared_ptr<const ColorTable> colors,
                                            const Ball& target, const std::vector<Ball>& balls,
                                            const ServoGoal& goal, std::uint64_t seed, bool fixed_colors) {
  const auto target_class = colors->find(target.class_name);
  if (!target_class) {
    std::string known = "one of the colours file's classes:";
    for (const ColorClass& color : colors->classes) known += " " + color.name;
    throw InputError("balls: class of " + target.name, target.class_name, known);
  }
  DetectorOptions options;
  options.seed = seed;
  options.radii.resize(colors->classes.size());
  for (const Ball& ball : balls) {
    if (const auto color_class = colors->find(ball.class_name))
      options.radii[*color_class - 1u].radius_m = ball.radius_m();
  }
  options.radii[*target_class - 1u].radius_m = target.radius_m();
  TrackerOptions tracker;
  tracker.fixed_colors = fixed_colors;
  return std::make_unique<ImageSight>(
      Detector(std::make_shared<RayTable>(camera), std::move(colors), options), tracker, *target_class, goal,
      target.heights_m().second - target.position_m.z());
}

std::unique_ptr<BallSight> make_geometric_sight(const Camera& camera, const Ball& target,
                                                const GeometricSensorOptions& options, std::uint64_t seed,
                                                const std::optional<BelievedView>& believed) {
  return std::make_unique<GeometricSight>(camera, target, options, seed, believed);
}

}  // namespace ballservo
