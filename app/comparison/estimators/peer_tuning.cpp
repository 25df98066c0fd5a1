#include "app/comparison/estimators/peer_tuning.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "app/comparison/found.hpp"

namespace ballservo {
namespace {

// The small grids that each peer's settings are chosen from.
constexpr cv::HoughModes plain_hough = cv::HOUGH_GRADIENT, alt_hough = cv::HOUGH_GRADIENT_ALT;
constexpr HoughSettings hough_grid[]{{plain_hough, 100, 20}, {plain_hough, 100, 12}, {plain_hough, 100, 30},
                                     {plain_hough, 50, 20},  {plain_hough, 50, 30},  {plain_hough, 200, 12}};
constexpr HoughSettings hough_alt_grid[]{{alt_hough, 300, 0.8}, {alt_hough, 300, 0.6}, {alt_hough, 150, 0.8},
                                         {alt_hough, 150, 0.5}, {alt_hough, 80, 0.8},  {alt_hough, 80, 0.5}};
constexpr HsvSettings hsv_grid[]{{120, 30}, {80, 30}, {50, 20}, {160, 30}, {120, 60}, {80, 15}};
constexpr VpDot2Settings vpdot2_grid[]{
    {true, 0.65, {120, 30}}, {true, 0, {80, 30}}, {true, 0, {50, 20}}, {false, 0.65, {}}};

using Answer = std::optional<OutlineEllipse>;

template <class Grid, class Ask>
auto best(const std::vector<TuningPicture>& pictures, const Grid& grid, const Ask& ask) {
  std::pair<int, double> least{1, 0};  // less the balls found, then the mean error (px)
  auto chosen = grid[0];
  for (const auto& settings : grid) {
    int found = 0;
    double error_px = 0;
    for (const TuningPicture& picture : pictures) {
      const Answer answer = ask(picture, settings);
      const auto& truth = picture.truth.outline;
      if (!answer || !truth || !is_found(*answer, *truth)) continue;
      ++found;
      error_px +=
          (answer->center_px - truth->center_px).norm() + std::abs(answer->radius_px - truth->radius_px);
    }
    const std::pair<int, double> score{-found, error_px / std::max(1, found)};
    if (!(score < least)) continue;
    least = score;
    chosen = settings;
  }
  return chosen;
}

Answer first_outline(const std::vector<OutlineEllipse>& found) {
  return found.empty() ? Answer() : Answer(found.front());
}

}  // namespace

PeerSettings tuned_peers(const std::vector<TuningPicture>& pictures, const MethodList& methods) {
  const auto asked = [&](std::string_view name) { return place_of(methods, name).has_value(); };
  PeerSettings chosen;
  const auto hough = [](const TuningPicture& p, const HoughSettings& s) {
    return first_outline(HoughGradient(p.task.expected_radius_px.value_or(30), s).find(p.bgr));
  };
  if (asked("hough_gradient")) chosen.hough = best(pictures, hough_grid, hough);
  if (asked("hough_gradient_alt")) chosen.hough_alt = best(pictures, hough_alt_grid, hough);
  if (asked("hsv_contour"))
    chosen.hsv = best(pictures, hsv_grid, [](const TuningPicture& p, const HsvSettings& s) {
      return first_outline(HsvContour(p.task.hue, s).find(p.bgr));
    });
  if (asked("vpdot2"))
    chosen.vpdot2 = best(pictures, vpdot2_grid, [](const TuningPicture& p, const VpDot2Settings& s) {
      return p.task.click_px ? vpdot2_blob(p.bgr, p.task.hue, *p.task.click_px, s) : Answer();
    });
  return chosen;
}

}  // namespace ballservo
