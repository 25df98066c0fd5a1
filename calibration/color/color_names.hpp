// Basic colour words for hues.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ballservo {

/// The words that colour calibration uses: red, orange, yellow, green, cyan, blue, purple, pink.
const std::vector<std::string>& color_words();

/// Hue of a Lab colour: the angle of (a, b), degrees, 0 to 360.
double lab_hue_deg(double a, double b);

/// The shorter way around between two hues, degrees, 0 to 180.
double hue_distance_deg(double hue_a, double hue_b);

/// The word for a Lab colour with some chroma. Hue decides, but where English does not go by hue alone: a
/// light red is pink, a dark pink is red or purple.
std::string color_word(const Eigen::Vector3d& lab);

/// The colour word that a class's name says: "light_green" and "green_2" say green, "navy" says blue; nothing
/// where it says none, or two.
std::optional<std::string> word_in_name(std::string_view name);

/// How far a hue lies from those that a colour word may name: 0 inside, otherwise degrees to the nearer end.
/// Words share their borders generously (a tennis ball is yellow and green).
double hue_distance_to_word_deg(std::string_view word, double hue_deg);

}  // namespace ballservo
