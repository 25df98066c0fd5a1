#include "servo/simulation/texture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

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

/// Cell values of one period of the noise, so that a look-up costs four loads.
class NoiseGrid {
 public:
  static constexpr int side = 256;
  NoiseGrid() {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i)
        values_[static_cast<std::size_t>(j * side + i)] = static_cast<float>(cell_value(i, j));
    }
  }

  /// Smooth value noise from -0.5 to 0.5 of period 256.
  double operator()(double x, double y) const {
    const std::int64_t fx = floor_index(x), fy = floor_index(y);
    const int i = static_cast<int>(fx & (side - 1)), j = static_cast<int>(fy & (side - 1));
    const int i1 = (i + 1) & (side - 1), j1 = (j + 1) & (side - 1);
    const double tx = x - static_cast<double>(fx), ty = y - static_cast<double>(fy);
    const double wx = tx * tx * (3 - 2 * tx), wy = ty * ty * (3 - 2 * ty);
    const double low = at(i, j) + wx * (at(i1, j) - at(i, j));
    const double high = at(i, j1) + wx * (at(i1, j1) - at(i, j1));
    return low + wy * (high - low) - 0.5;
  }

 private:
  double at(int i, int j) const { return values_[static_cast<std::size_t>(j * side + i)]; }
  std::array<float, side * side> values_;
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
double fading_noise(double x, double y, double patch, int octaves) {
  double sum = 0, amplitude = 0.55, frequency = 1;
  for (int k = 0; k < octaves; ++k) {
    const double left = remaining(patch * frequency);
    if (amplitude * left < 0.02) break;  // a grey level or two
    sum += amplitude * left * noise_grid()(x * frequency + 17.3 * k, y * frequency + 9.1 * k);
    amplitude *= 0.5;
    frequency *= 2;
  }
  return sum;
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
  const double row_position = v, row_patch = patch_v;
  const double tone = mean_of_cells(row_position, row_patch, [&](std::int64_t row) {
    const double along = u / board_length + cell_value(row, -7);
    return mean_of_cells(along, patch_u / board_length,
                         [&](std::int64_t board) { return cell_value(row, board); });
  });
  const auto row = floor_index(v);
  const double shift = 40.0 * cell_value(row, 3);
  const double grain = fading_noise(u * 0.5 + shift, v * 7.0, std::max(patch_u * 0.5, patch_v * 7.0), 3);
  const double joint = line_share(v, patch_v, 0.025);
  const double butt = line_share(u / board_length + cell_value(row, -7), patch_u / board_length, 0.003) *
                      (patch_v < 0.7 ? 1.0 : 0.0);
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
              0.15 * fading_noise(u * 3, v * 3, patch * 3, 2);
      break;
    case Pattern::tiles: {
      const double joint_u = line_share(u, patch_u, 0.04), joint_v = line_share(v, patch_v, 0.04);
      share = 1.0 - (1.0 - joint_u) * (1.0 - joint_v) + 0.2 * fading_noise(u * 4, v * 4, patch * 4, 2);
      break;
    }
    case Pattern::noise:
      share = 0.5 + 1.2 * fading_noise(u, v, patch, 3);
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
