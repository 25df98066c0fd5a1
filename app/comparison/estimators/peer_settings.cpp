#include "app/comparison/estimators/peer_settings.hpp"

#include <fmt/format.h>

namespace ballservo {

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

std::string in_words(const HoughSettings& settings) {
  return fmt::format("param1 {:g}, param2 {:g}", settings.edges, settings.support);
}

std::string in_words(const HsvSettings& settings) {
  return fmt::format("saturation from {:g}, value from {:g}", settings.least_saturation,
                     settings.least_value);
}

std::string in_words(const VpDot2Settings& settings) {
  const std::string picture =
      settings.mask ? "mask of hue, " + in_words(settings.hsv) : std::string("grey picture");
  return fmt::format("{}; ellipsoid shape precision {:g}", picture, settings.roundness);
}

std::string in_words(const PeerSettings& settings) {
  return "hough_gradient: " + in_words(settings.hough) +
         "; hough_gradient_alt: " + in_words(settings.hough_alt) +
         "; hsv_contour: " + in_words(settings.hsv) + "; vpdot2: " + in_words(settings.vpdot2);
}

}  // namespace ballservo
