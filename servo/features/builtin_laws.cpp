#include "servo/features/builtin_laws.hpp"

#include <visp3/visual_features/vpFeatureDepth.h>
#include <visp3/visual_features/vpFeaturePoint.h>

#include <cmath>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "servo/features/visp_servo_law.hpp"

namespace ballservo {

namespace {

/// The first two coordinates of a BallFeature.
class TwoCoordinates final : public BallFeatures {
 public:
  TwoCoordinates(const BallFeature& feature, const Eigen::Vector3d& desired_p_CB)
      : s_(feature), desired_(feature) {
    desired_.buildFrom(desired_p_CB);
  }
  void add_to(vpServo& task) override {
    task.addFeature(s_, desired_, vpBasicFeature::FEATURE_LINE[0] | vpBasicFeature::FEATURE_LINE[1]);
  }
  bool look_at(const Eigen::Vector3d& p_CB) override {
    if (!s_.defined_at(p_CB)) return false;
    s_.buildFrom(p_CB);
    return true;
  }

 private:
  BallFeature s_, desired_;
};

class PointAndDepth final : public BallFeatures {
 public:
  explicit PointAndDepth(const ServoGoal& goal) : desired_depth_m_(goal.desired_p_CB().z()) {
    if (!before_camera(goal.desired_p_CB())) {
      throw InputError("target.distance_m", number_text(goal.distance_m),
                       "a distance at which the ball's centre lies before the camera, for law visp");
    }
    build(goal.desired_p_CB(), desired_point_, desired_depth_);
  }
  void add_to(vpServo& task) override {
    task.addFeature(point_, desired_point_, vpFeaturePoint::selectX());
    task.addFeature(depth_, desired_depth_);
  }
  bool look_at(const Eigen::Vector3d& p_CB) override {
    if (!before_camera(p_CB)) return false;
    build(p_CB, point_, depth_);
    return true;
  }

 private:
  // vpFeatureDepth prints and throws for Z <= 0, and x loses its meaning on the way there.
  static bool before_camera(const Eigen::Vector3d& p_CB) { return p_CB.z() >= 1e-3; }
  void build(const Eigen::Vector3d& p_CB, vpFeaturePoint& point, vpFeatureDepth& depth) const {
    const double x = p_CB.x() / p_CB.z(), y = p_CB.y() / p_CB.z();
    point.buildFrom(x, y, p_CB.z());
    depth.buildFrom(x, y, p_CB.z(), std::log(p_CB.z() / desired_depth_m_));
  }

  double desired_depth_m_;
  vpFeaturePoint point_, desired_point_;
  vpFeatureDepth depth_, desired_depth_;
};

std::unique_ptr<Law> law_on(const LawOptions& options, const ServoGoal& goal, const BallFeature& feature) {
  if (!feature.defined_at(goal.desired_p_CB())) {
    throw InputError("target.distance_m", number_text(goal.distance_m),
                     "a distance at which the features of law " + options.name + " are defined");
  }
  return std::make_unique<VispServoLaw>(options.gain_per_s, goal.mount,
                                        std::make_unique<TwoCoordinates>(feature, goal.desired_p_CB()));
}

}  // namespace

LawCatalog builtin_laws() {
  LawCatalog laws;
  laws.add("cone", [](const LawOptions& options, const ServoGoal& goal) {
    return law_on(options, goal, ConeFeature(goal.mount.X_RC().linear()));
  });
  laws.add("visp", [](const LawOptions& options, const ServoGoal& goal) {
    return std::make_unique<VispServoLaw>(options.gain_per_s, goal.mount,
                                          std::make_unique<PointAndDepth>(goal));
  });
  laws.add("sphere", [](const LawOptions& options, const ServoGoal& goal) {
    return law_on(options, goal, SphereFeature(goal.ball_radius_m, goal.mount.X_RC().linear()));
  });
  laws.add("pose", [](const LawOptions& options, const ServoGoal& goal) {
    return law_on(options, goal, FloorFeature(goal.mount.X_RC()));
  });
  return laws;
}

}  // namespace ballservo
