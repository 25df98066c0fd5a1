#include "app/loop/target_selection.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

namespace {

// How badly a mount may be known: of the height at no range, and per metre of range.
constexpr double height_slack_m = 0.20, height_slack_per_m = 0.03;

/// Confirmed before tentative, then the better outline.
bool better(const Track& a, const Track& b) {
  const bool a_confirmed = a.state == TrackState::confirmed, b_confirmed = b.state == TrackState::confirmed;
  return a_confirmed != b_confirmed ? a_confirmed : a.ball.quality > b.ball.quality;
}

}  // namespace

TargetSelection::TargetSelection(const TargetOptions& options)
    : options_(options), X_RC_(options.mount.X_RC()) {}

const Track* TargetSelection::choose(const std::vector<Track>& tracks) {
  const Track* best = nullptr;
  for (const Track& track : tracks) {
    if (!may_be(track)) continue;
    if (track.id == followed_) return &track;
    if (best == nullptr || better(track, *best)) best = &track;
  }
  followed_ = best != nullptr && best->state == TrackState::confirmed ? best->id : 0;
  return best;
}

bool TargetSelection::may_be(const Track& track) const {
  if (track.color_class != options_.color_class || !track.ball.position ||
      !std::isfinite(track.ball.quality)) {
    return false;
  }
  const Eigen::Vector3d p_RB = X_RC_ * track.ball.position->p_C;
  const double slack_m = height_slack_m + height_slack_per_m * p_RB.head<2>().norm();
  const double up_m = options_.mount.up_m, above_m = p_RB.z() - up_m;
  const auto [lowest_m, highest_m] =
      std::minmax({up_m + above_m / options_.greatest_scale, up_m + above_m * options_.greatest_scale});
  return highest_m > options_.height_m - slack_m && lowest_m < options_.height_m + options_.lift_m + slack_m;
}

}  // namespace ballservo
