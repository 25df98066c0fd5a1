#include "calibration/color/color_names.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ballservo {
namespace {

/// The hues of a word, from `low` up to `high` (a word that begins below 360 and ends above it wraps).
struct HueRange {
  const char* word;
  double low_deg, high_deg;
};

// Where the words change over on the Lab hue circle; sRGB's own red, yellow, green, cyan, blue and magenta
// stand at 40, 103, 136, 196, 306 and 328 degrees.
constexpr std::array<HueRange, 8> ranges = {{{"red", 16, 43},
                                             {"orange", 43, 82},
                                             {"yellow", 82, 115},
                                             {"green", 115, 178},
                                             {"cyan", 178, 228},
                                             {"blue", 228, 309},
                                             {"purple", 309, 340},
                                             {"pink", 340, 376}}};

constexpr double shared_border_deg = 12;  // how far a word reaches into its neighbours when a user says it

bool within(const HueRange& range, double hue) {
  return (hue >= range.low_deg && hue < range.high_deg) ||
         (hue + 360 >= range.low_deg && hue + 360 < range.high_deg);
}

}  // namespace

const std::vector<std::string>& color_words() {
  static const std::vector<std::string> words = [] {
    std::vector<std::string> result;
    for (const HueRange& range : ranges) result.emplace_back(range.word);
    return result;
  }();
  return words;
}

double lab_hue_deg(double a, double b) {
  const double degrees = std::atan2(b, a) * (180.0 / M_PI);
  return degrees < 0 ? degrees + 360 : degrees;
}

double hue_distance_deg(double hue_a, double hue_b) {
  const double difference = std::fmod(std::abs(hue_a - hue_b), 360.0);
  return std::min(difference, 360.0 - difference);
}

std::string color_word(const Eigen::Vector3d& lab) {
  const double hue = lab_hue_deg(lab.y(), lab.z());
  std::string word = "red";
  for (const HueRange& range : ranges) {
    if (within(range, hue)) word = range.word;
  }
  if (word == "red" && hue < 32 && lab.x() > 65) return "pink";
  if (word == "orange" && hue < 52 && lab.x() < 45) return "red";
  if (word == "pink" && lab.x() < 40) return hue < 180 ? "red" : "purple";
  return word;
}

std::optional<double> hue_distance_to_word_deg(const std::string& word, double hue_deg) {
  for (const HueRange& range : ranges) {
    if (word != range.word) continue;
    if (within(range, hue_deg)) return 0.0;
    const double outside =
        std::min(hue_distance_deg(hue_deg, range.low_deg), hue_distance_deg(hue_deg, range.high_deg));
    return std::max(0.0, outside - shared_border_deg);
  }
  return std::nullopt;
}

}  // namespace ballservo
