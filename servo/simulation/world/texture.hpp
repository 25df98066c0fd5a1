// What surfaces look like: procedural patterns, filtered over the patch that a pixel sees so that they do not
// alias.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string_view>

#include "servo/simulation/world/lanes.hpp"

namespace ballservo {

/// Linear light, (red, green, blue). As a reflectance from 0 to 1; as light, 1 saturates the camera at a gain
/// of 1.
using Rgb = Eigen::Vector3d;

enum class Pattern { plain, checks, tiles, noise, wood };

inline constexpr std::array<Pattern, 5> all_patterns{Pattern::plain, Pattern::checks, Pattern::tiles,
                                                     Pattern::noise, Pattern::wood};

inline std::string_view pattern_name(Pattern pattern) {
  constexpr std::string_view names[] = {"plain", "checks", "tiles", "noise", "wood"};
  return names[static_cast<std::size_t>(pattern)];
}

/// A pattern of two colours. `scale_m`: side of a check or tile, size of the noise's largest grains, width of
/// a board.
struct Texture {
  Pattern pattern = Pattern::plain;
  Rgb color{0.5, 0.5, 0.5};
  Rgb color_2{0.4, 0.4, 0.4};  ///< the other check, the joints, the dark grains or boards
  double scale_m = 0.3;
};

/// The texture's mean colours (linear, from 0 to 1 where the two colours are) over patches of the
/// surface, one a lane: centres (m, surface coordinates) and the patches' sides along u and v (m). Patches
/// that are larger than the pattern give its mean. Periodic noise of fixed seed.
Triples texture_colors(const Texture& texture, const Pairs& uv_m, const Pairs& patch_m);

/// The reflectance that stands for a basic colour word ("red", "orange", "yellow", "green", "cyan", "blue",
/// "purple", "pink", "white", "black", "grey", "brown"); a suffix such as in "red_2" is ignored. Nothing for
/// other words.
std::optional<Rgb> color_from_word(std::string_view word);

}  // namespace ballservo
