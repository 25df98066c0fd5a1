#include "servo/simulation/texture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace ballservo {

namespace {

/// std::floor for numbers within the range of 64-bit integers, without a call into the library.
std::int64_t floor_index(double x) {
  const auto whole = static_cast<std::int64_t>(x);
  return whole - (x < static_cast<double>(whole) ? 1 : 0);
}

double fast_floor(double x) { return static_cast<double>(floor_index(x)); }

/// A number in [0, 1) for each cell of an infinite grid (SplitMix64's finaliser over both indices).
double cell_value(std::int64_t i, std::int64_t j) {
  std::uint64_t x = static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15ull + static_cast<std::uint64_t>(j);
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1.0p-53;
}

/// Three octaves of smooth value noise on a fine grid, side by side, so that one look-up serves them all.
class NoiseGrid {
 public:
  static constexpr int octaves = 3;
  static constexpr int period = 32;  // in units of the first octave
  static constexpr int samples = 8;  // a unit
  static constexpr int side = period * samples;

  NoiseGrid() : values_(static_cast<std::size_t>(side * side)) {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        Eigen::Vector4f& value = values_[static_cast<std::size_t>(j * side + i)];
        for (int k = 0; k < octaves; ++k) {
          const double frequency = static_cast<double>(1 << k) / samples;
          value[k] = static_cast<float>(smooth(i * frequency, j * frequency, period << k, k));
        }
        value[3] = 0;
      }
    }
  }

  /// The octaves at a point, each from -0.5 to 0.5.
  Eigen::Vector4f operator()(double x, double y) const {
    const double sx = x * samples, sy = y * samples;
    const std::int64_t fx = floor_index(sx), fy = floor_index(sy);
    const int i = static_cast<int>(fx & (side - 1)), j = static_cast<int>(fy & (side - 1));
    const int i1 = (i + 1) & (side - 1), j1 = (j + 1) & (side - 1);
    const auto tx = static_cast<float>(sx - static_cast<double>(fx)),
               ty = static_cast<float>(sy - static_cast<double>(fy));
    const Eigen::Vector4f low = at(i, j) + tx * (at(i1, j) - at(i, j));
    const Eigen::Vector4f high = at(i, j1) + tx * (at(i1, j1) - at(i, j1));
    return low + ty * (high - low);
  }

 private:
  /// Value noise of unit cells that repeats after `cells`.
  static double smooth(double x, double y, int cells, int octave) {
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const double tx = x - i, ty = y - j;
    const double wx = tx * tx * (3 - 2 * tx), wy = ty * ty * (3 - 2 * ty);
    const auto value = [&](int a, int b) { return cell_value(a % cells + 1000 * octave, b % cells); };
    const double low = value(i, j) + wx * (value(i + 1, j) - value(i, j));
    const double high = value(i, j + 1) + wx * (value(i + 1, j + 1) - value(i, j + 1));
    return low + wy * (high - low) - 0.5;
  }

  const Eigen::Vector4f& at(int i, int j) const { return values_[static_cast<std::size_t>(j * side + i)]; }
  std::vector<Eigen::Vector4f> values_;
};

const NoiseGrid& noise_grid() {
  static const NoiseGrid grid;
  return grid;
}

/// How much of a wave of unit wavelength is left after averaging over a patch of this size (in wavelengths).
double remaining(double patch) {
  const double q = patch * patch;
  return 1.0 / (1.0 + 4.0 * q + 8.0 * q * q);
}

/// Octaves of noise, each fading as the patch grows beyond its grains; about -0.5 to 0.5.
double fading_noise(double x, double y, double patch) {
  const double first = 0.55 * remaining(patch);
  if (first < 0.02) return 0.0;  // a grey level or two
  const Eigen::Vector4f noise = noise_grid()(x, y);
  return first * static_cast<double>(noise[0]) +
         0.275 * remaining(2 * patch) * static_cast<double>(noise[1]) +
         0.1375 * remaining(4 * patch) * static_cast<double>(noise[2]);
}

/// Mean over [x - w/2, x + w/2] of the square wave of period 2 that is 1 in [0, 1) and -1 in [1, 2).
double mean_square_wave(double x, double w) {
  const auto triangle = [](double t) { return std::abs(t / 2 - fast_floor(t / 2 + 0.5)) * 2; };
  return (triangle(x + w / 2) - triangle(x - w / 2)) / w;
}

/// Fraction of [x - w/2, x + w/2] that lies in [k, k + line) for an integer k.
double line_share(double x, double w, double line) {
  const auto sum = [line](double t) { return fast_floor(t) * line + std::min(t - fast_floor(t), line); };
  return std::clamp((sum(x + w / 2) - sum(x - w / 2)) / w, 0.0, 1.0);
}

/// Mean of a value per cell of unit length over [x - w/2, x + w/2], fading to 0.5 for windows beyond a cell.
template <typename ValueOfCell>
double mean_of_cells(double x, double w, const ValueOfCell& value) {
  if (w >= 2.0) return 0.5;
  const double shown = std::min(w, 1.0);
  const double first = fast_floor(x - shown / 2), last = fast_floor(x + shown / 2);
  const double share = first == last ? 0.0 : (x + shown / 2 - last) / shown;
  double mean = (1 - share) * value(static_cast<std::int64_t>(first));
  if (share > 0) mean += share * value(static_cast<std::int64_t>(last));
  return w <= 1.0 ? mean : 0.5 + (mean - 0.5) * (2.0 - w);
}

Rgb wood_color(const Texture& texture, double u, double v, double patch_u, double patch_v) {
  constexpr double board_length = 8.0;  // in board widths
  const std::int64_t row = floor_index(v);
  const double row_shift = cell_value(row, -7);
  const double along = u / board_length, along_patch = patch_u / board_length;
  const double tone = mean_of_cells(v, patch_v, [&](std::int64_t r) {
    const double shift = r == row ? row_shift : cell_value(r, -7);
    return mean_of_cells(along + shift, along_patch,
                         [&](std::int64_t board) { return cell_value(r, board); });
  });
  const double grain =
      fading_noise(u * 0.5 + 40.0 * row_shift, v * 7.0, std::max(patch_u * 0.5, patch_v * 7.0));
  const double joint = line_share(v, patch_v, 0.025);
  const double butt = patch_v < 0.7 ? line_share(along + row_shift, along_patch, 0.003) : 0.0;
  const double dark = std::clamp(0.35 + 0.55 * (tone - 0.5) + 0.8 * grain, 0.0, 1.0);
  const Rgb board = texture.color + dark * (texture.color_2 - texture.color);
  return board * (1.0 - 0.65 * std::max(joint, butt));
}

}  // namespace

std::string_view pattern_name(Pattern pattern) {
  switch (pattern) {
    case Pattern::plain:
      return "plain";
    case Pattern::checks:
      return "checks";
    case Pattern::tiles:
      return "tiles";
    case Pattern::noise:
      return "noise";
    case Pattern::wood:
      return "wood";
  }
  return "plain";
}

Rgb texture_color(const Texture& texture, const Eigen::Vector2d& uv_m, const Eigen::Vector2d& patch_m) {
  if (texture.pattern == Pattern::plain) return texture.color;
  const double u = uv_m.x() / texture.scale_m, v = uv_m.y() / texture.scale_m;
  const double patch_u = std::max(patch_m.x() / texture.scale_m, 1e-4);
  const double patch_v = std::max(patch_m.y() / texture.scale_m, 1e-4);
  const double patch = std::max(patch_u, patch_v);
  double share = 0;  // of color_2
  switch (texture.pattern) {
    case Pattern::checks:
      share = 0.5 - 0.5 * mean_square_wave(u, patch_u) * mean_square_wave(v, patch_v) +
              0.15 * fading_noise(u * 3, v * 3, patch * 3);
      break;
    case Pattern::tiles: {
      const double joint_u = line_share(u, patch_u, 0.04), joint_v = line_share(v, patch_v, 0.04);
      share = 1.0 - (1.0 - joint_u) * (1.0 - joint_v) + 0.2 * fading_noise(u * 4, v * 4, patch * 4);
      break;
    }
    case Pattern::noise:
      share = 0.5 + 1.2 * fading_noise(u, v, patch);
      break;
    case Pattern::wood:
      return wood_color(texture, u, v, patch_u, patch_v);
    case Pattern::plain:
      break;
  }
  return texture.color + std::clamp(share, 0.0, 1.0) * (texture.color_2 - texture.color);
}

std::optional<Rgb> color_from_word(std::string_view word) {
  const std::string_view base = word.substr(0, word.find('_'));
  struct Entry {
    std::string_view word;
    Rgb color;
  };
  static const std::array<Entry, 12> entries{{{"red", {0.72, 0.035, 0.03}},
                                              {"orange", {0.80, 0.22, 0.02}},
                                              {"yellow", {0.80, 0.60, 0.03}},
                                              {"green", {0.06, 0.45, 0.08}},
                                              {"cyan", {0.04, 0.50, 0.55}},
                                              {"blue", {0.03, 0.12, 0.60}},
                                              {"purple", {0.28, 0.05, 0.45}},
                                              {"pink", {0.80, 0.25, 0.42}},
                                              {"white", {0.85, 0.85, 0.85}},
                                              {"black", {0.03, 0.03, 0.03}},
                                              {"grey", {0.40, 0.40, 0.40}},
                                              {"brown", {0.28, 0.14, 0.06}}}};
  for (const Entry& entry : entries) {
    if (entry.word == base) return entry.color;
  }
  return std::nullopt;
}

}  // namespace ballservo
