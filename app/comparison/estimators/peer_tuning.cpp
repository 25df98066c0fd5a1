#include "app/comparison/estimators/peer_tuning.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

namespace ballservo {
namespace {

using Answer = std::optional<OutlineEllipse>;

struct Score {
  int found = 0;
  double error_px = 0;

  bool better_than(const Score& other) const {
    if (found != other.found) return found > other.found;
    return error_px < other.error_px;
  }
};

template <class Settings>
Settings best(const std::vector<TuningPicture>& pictures, const std::vector<Settings>& grid,
              const std::function<Answer(const TuningPicture&, const Settings&)>& ask) {
  std::optional<Score> best_score;
  Settings chosen = grid.front();
  for (const Settings& settings : grid) {
    Score score;
    for (const TuningPicture& picture : pictures) {
      const Answer answer = ask(picture, settings);
      MethodFit fit;
      if (answer) fit.outline = *answer;
      if (!answer || !picture.truth.outline || !at_the_ball(fit, picture.truth)) continue;
      ++score.found;
      score.error_px += (answer->center_px - picture.truth.outline->center_px).norm() +
                        std::abs(answer->radius_px - picture.truth.outline->radius_px);
    }
    score.error_px /= std::max(1, score.found);
    if (best_score && !score.better_than(*best_score)) continue;
    best_score = score;
    chosen = settings;
  }
  return chosen;
}

Answer first(const std::vector<OutlineEllipse>& found) {
  return found.empty() ? Answer() : Answer(found.front());
}

Answer largest(const std::vector<OutlineEllipse>& found) {
  const auto it = std::max_element(
      found.begin(), found.end(),
      [](const OutlineEllipse& a, const OutlineEllipse& b) { return a.radius_px < b.radius_px; });
  return it == found.end() ? Answer() : Answer(*it);
}

}  // namespace

PeerSettings tuned_peers(const std::vector<TuningPicture>& pictures, const MethodList& methods) {
  const auto asked = [&](std::string_view name) { return place_of(methods, name).has_value(); };
  PeerSettings chosen;
  const auto hough = [](const TuningPicture& p, const HoughSettings& s) {
    return first(HoughGradient(p.task.expected_radius_px.value_or(30), s).find(p.bgr));
  };
  if (asked("hough_gradient"))
    chosen.hough = best<HoughSettings>(pictures, hough_grid(HoughMode::gradient), hough);
  if (asked("hough_gradient_alt"))
    chosen.hough_alt = best<HoughSettings>(pictures, hough_grid(HoughMode::gradient_alt), hough);
  if (asked("hsv_contour"))
    chosen.hsv = best<HsvSettings>(pictures, hsv_grid(), [](const TuningPicture& p, const HsvSettings& s) {
      return largest(HsvContour(p.task.hue, s).find(p.bgr));
    });
  if (asked("vpdot2"))
    chosen.vpdot2 =
        best<VpDot2Settings>(pictures, vpdot2_grid(), [](const TuningPicture& p, const VpDot2Settings& s) {
          return p.task.click_px ? vpdot2_blob(p.bgr, p.task.hue, *p.task.click_px, s) : Answer();
        });
  return chosen;
}

bool has_tuned_peers(const MethodList& methods) {
  return std::any_of(methods.begin(), methods.end(),
                     [](const FitMethod* method) { return method->is_peer && method->fit; });
}

}  // namespace ballservo
