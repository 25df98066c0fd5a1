#include "app/comparison/estimators/peer_tuning.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

namespace ballservo {
namespace {

// The small grids that each peer's settings are chosen from.
const std::vector<HoughSettings>& hough_grid(HoughMode mode) {
  constexpr HoughMode plain = HoughMode::gradient, alt = HoughMode::gradient_alt;
  static const std::vector<HoughSettings> of_plain{{plain, 100, 20}, {plain, 100, 12}, {plain, 100, 30},
                                                   {plain, 50, 20},  {plain, 50, 30},  {plain, 200, 12}};
  static const std::vector<HoughSettings> of_alt{{alt, 300, 0.8}, {alt, 300, 0.6}, {alt, 150, 0.8},
                                                 {alt, 150, 0.5}, {alt, 80, 0.8},  {alt, 80, 0.5}};
  return mode == plain ? of_plain : of_alt;
}

const std::vector<HsvSettings>& hsv_grid() {
  static const std::vector<HsvSettings> grid{{120, 30}, {80, 30}, {50, 20}, {160, 30}, {120, 60}, {80, 15}};
  return grid;
}

const std::vector<VpDot2Settings>& vpdot2_grid() {
  static const std::vector<VpDot2Settings> grid{
      {true, 0.65, {120, 30}}, {true, 0, {80, 30}}, {true, 0, {50, 20}}, {false, 0.65, {}}};
  return grid;
}

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

Answer first_outline(const std::vector<OutlineEllipse>& found) {
  return found.empty() ? Answer() : Answer(found.front());
}

Answer largest_outline(const std::vector<OutlineEllipse>& found) {
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
    return first_outline(HoughGradient(p.task.expected_radius_px.value_or(30), s).find(p.bgr));
  };
  if (asked("hough_gradient"))
    chosen.hough = best<HoughSettings>(pictures, hough_grid(HoughMode::gradient), hough);
  if (asked("hough_gradient_alt"))
    chosen.hough_alt = best<HoughSettings>(pictures, hough_grid(HoughMode::gradient_alt), hough);
  if (asked("hsv_contour"))
    chosen.hsv = best<HsvSettings>(pictures, hsv_grid(), [](const TuningPicture& p, const HsvSettings& s) {
      return largest_outline(HsvContour(p.task.hue, s).find(p.bgr));
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
