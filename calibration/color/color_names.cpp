#include "calibration/color/color_names.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <stdexcept>

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

/// What else people say, and the word whose hues it names.
struct OtherWord {
  const char *said, *word;
};
constexpr std::array<OtherWord, 13> other_words = {{{"crimson", "red"},
                                                    {"brown", "orange"},
                                                    {"gold", "yellow"},
                                                    {"lime", "green"},
                                                    {"olive", "green"},
                                                    {"turquoise", "cyan"},
                                                    {"teal", "cyan"},
                                                    {"aqua", "cyan"},
                                                    {"navy", "blue"},
                                                    {"violet", "purple"},
                                                    {"lilac", "purple"},
                                                    {"magenta", "purple"},
                                                    {"rose", "pink"}}};

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

std::optional<std::string> word_in_name(std::string_view name) {
  constexpr const char* letters = "abcdefghijklmnopqrstuvwxyz";
  std::set<std::string> said;
  for (std::size_t from = 0, to = 0; (from = name.find_first_of(letters, to)) != name.npos;) {
    to = std::min(name.find_first_not_of(letters, from), name.size());
    const std::string_view part = name.substr(from, to - from);
    for (const HueRange& range : ranges)
      if (part == range.word) said.insert(range.word);
    for (const OtherWord& other : other_words)
      if (part == other.said) said.insert(other.word);
  }
  return said.size() == 1 ? std::optional(*said.begin()) : std::nullopt;
}

double hue_distance_to_word_deg(std::string_view word, double hue_deg) {
  const auto named =
      std::find_if(ranges.begin(), ranges.end(), [&](const HueRange& range) { return word == range.word; });
  if (named == ranges.end()) throw std::logic_error("no colour word: " + std::string(word));
  if (within(*named, hue_deg)) return 0;
  const double outside =
      std::min(hue_distance_deg(hue_deg, named->low_deg), hue_distance_deg(hue_deg, named->high_deg));
  return std::max(0.0, outside - shared_border_deg);
}

}  // namespace ballservo
