#include "servo/simulation/world/texture.hpp"

#include <cstdint>
#include <vector>

#include "calibration/base/random.hpp"
#include "servo/simulation/world/quad_grid.hpp"

namespace ballservo {

namespace {

constexpr float least_patch = 1e-3f;  // in units of the texture's scale

/// A number in [0, 1) for each cell of a grid.
double cell_value(std::int64_t i, std::int64_t j) {
  const auto x = static_cast<std::uint64_t>(i) * split_mix_step + static_cast<std::uint64_t>(j);
  return static_cast<double>(mixed_bits(x) >> 11) * 0x1.0p-53;
}

Floats from_0_to_1(Floats x) { return max(spread(0.0f), min(spread(1.0f), x)); }

/// The values of 64 x 64 cells, which repeat.
class CellGrid {
 public:
  CellGrid() : values_(side * side) {
    for (std::size_t k = 0; k < values_.size(); ++k)
      values_[k] = static_cast<float>(cell_value(static_cast<std::int64_t>(k), -7));
  }
  Floats operator()(Ints i, Ints j) const {
    const Ints at = (i & (side - 1)) * side + (j & (side - 1));
    const auto value = [this](std::int32_t k) { return values_[static_cast<std::size_t>(k)]; };
    if (all(at == at[0])) return spread(value(at[0]));  // neighbours mostly see one cell
    Floats values{};
    for (int k = 0; k < lanes; ++k) values[k] = value(at[k]);
    return values;
  }

 private:
  static constexpr int side = 64;
  std::vector<float> values_;
};

/// Three octaves of smooth value noise on a fine grid, side by side, so that one look-up serves them all.
class NoiseGrid {
 public:
  static constexpr int octaves = 3;

  NoiseGrid() : grid_(side + 1, side + 1) {
    for (int j = 0; j <= side; ++j) {
      for (int i = 0; i <= side; ++i) {
        for (int k = 0; k < octaves; ++k) {
          const double frequency = static_cast<double>(1 << k) / samples;
          grid_.cell(i, j)[k] =
              static_cast<float>(smooth(i % side * frequency, j % side * frequency, period << k, k));
        }
      }
    }
  }

  /// The octaves at the points, each from -0.5 to 0.5, summed with the points' weights.
  Floats operator()(Floats x, Floats y, const Floats (&weights)[octaves]) const {
    const Floats sx = x * samples, sy = y * samples;
    const Ints i = floor_index(sx), j = floor_index(sy);
    const Quads value = grid_.between(i & (side - 1), j & (side - 1), sx - to_float(i), sy - to_float(j));
    return weights[0] * value[0] + weights[1] * value[1] + weights[2] * value[2];
  }

 private:
  static constexpr int period = 32;  // in units of the first octave
  static constexpr int samples = 8;  // a unit
  static constexpr int side = period * samples;

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

  QuadGrid grid_;
};

/// How much of a wave of unit wavelength is left after averaging over a patch of this size (in wavelengths).
Floats remaining(Floats patch) {
  const Floats q = patch * patch;
  return 1.0f / (1.0f + 4.0f * q + 8.0f * q * q);
}

/// Octaves of noise, each fading as the patch grows beyond its grains; about -0.5 to 0.5.
Floats fading_noise(Floats x, Floats y, Floats patch) {
  const Floats first = 0.55f * remaining(patch);
  const Ints shows = first >= 0.02f;  // a grey level or two
  if (!any(shows)) return spread(0.0f);
  static const NoiseGrid grid;
  const Floats noise =
      grid(x, y, {first, 0.275f * remaining(2.0f * patch), 0.1375f * remaining(4.0f * patch)});
  return shows ? noise : spread(0.0f);
}

/// Mean over [x - w/2, x + w/2] of the square wave of period 2 that is 1 in [0, 1) and -1 in [1, 2).
Floats mean_square_wave(Floats x, Floats w) {
  const auto triangle = [](Floats t) { return abs(t / 2 - floor(t / 2 + 0.5f)) * 2; };
  return (triangle(x + w / 2) - triangle(x - w / 2)) / w;
}

/// Fraction of [x - w/2, x + w/2] that lies in [k, k + line) for an integer k.
Floats line_share(Floats x, Floats w, float line) {
  const auto sum = [line](Floats t) {
    const Floats below = floor(t);
    return below * line + min(t - below, spread(line));
  };
  return from_0_to_1((sum(x + w / 2) - sum(x - w / 2)) / w);
}

/// Mean of a value per cell of unit length over [x - w/2, x + w/2], fading to 0.5 for windows beyond a cell.
template <typename ValueOfCell>
Floats mean_of_cells(Floats x, Floats w, const ValueOfCell& value) {
  const Floats fade = from_0_to_1(2.0f - w);
  if (all(fade == 0.0f)) return spread(0.5f);
  const Floats shown = min(w, spread(1.0f));
  const Ints first = floor_index(x - shown / 2), last = floor_index(x + shown / 2);
  Floats mean = value(first);
  if (any(first != last)) {
    const Floats share = first == last ? spread(0.0f) : (x + shown / 2 - to_float(last)) / shown;
    mean += share * (value(last) - mean);
  }
  return 0.5f + (mean - 0.5f) * fade;
}

Triples mixed(const Rgb& color, const Rgb& color_2, Floats share_2) {
  const auto channel = [&](int c) {
    return static_cast<float>(color[c]) + share_2 * static_cast<float>(color_2[c] - color[c]);
  };
  return {channel(0), channel(1), channel(2)};
}

constexpr float board_length = 8;                         // in board widths
constexpr float side_joint = 0.025f, end_joint = 0.003f;  // shares of a board

/// Where patches lie among boards: each board's tone, the shares of the joints, and how far each row of
/// boards is moved along.
struct Boards {
  Floats tone, joint, butt, shift;
};

Floats row_shift(const CellGrid& cells, Ints row) { return cells(row, row * 0 - 7); }

/// Where all patches lie on the same board, which is most often so.
bool on_one_board(const CellGrid& cells, const Pairs& at, const Pairs& patch, Boards& boards) {
  const auto low_of = [](Floats x, Floats side) { return x - side / 2; };
  const Floats low_v = low_of(at.v, patch.v), high_v = low_v + patch.v;
  const Ints row = floor_index(low_v);
  if (!all((row == row[0]) & (floor_index(high_v) == row[0]))) return false;
  boards.shift = row_shift(cells, row);
  const Floats side_u = patch.u / board_length, low_u = low_of(at.u / board_length + boards.shift, side_u),
               high_u = low_u + side_u;
  const Ints board = floor_index(low_u);
  if (!all((board == board[0]) & (floor_index(high_u) == board[0]))) return false;
  boards.tone = cells(row, board);
  const auto share_below = [](Floats low, Floats high, Floats start, Floats side, float line) {
    return (min(high - start, spread(line)) - min(low - start, spread(line))) / side;
  };
  boards.joint = share_below(low_v, high_v, to_float(row), patch.v, side_joint);
  boards.butt = share_below(low_u, high_u, to_float(board), side_u, end_joint);
  return true;
}

Boards boards_of(const CellGrid& cells, const Pairs& at, const Pairs& patch) {
  Boards boards;
  boards.shift = row_shift(cells, floor_index(at.v));
  const Floats along = at.u / board_length, along_patch = patch.u / board_length;
  boards.tone = mean_of_cells(at.v, patch.v, [&](Ints row) {
    return mean_of_cells(along + row_shift(cells, row), along_patch,
                         [&, row](Ints board) { return cells(row, board); });
  });
  boards.joint = line_share(at.v, patch.v, side_joint);
  boards.butt = line_share(along + boards.shift, along_patch, end_joint);
  return boards;
}

Triples wood_colors(const Texture& texture, const Pairs& at, const Pairs& patch) {
  static const CellGrid cells;
  Boards boards;
  if (!on_one_board(cells, at, patch, boards)) boards = boards_of(cells, at, patch);
  const Floats grain =
      fading_noise(at.u * 0.5f + 40.0f * boards.shift, at.v * 7.0f, max(patch.u * 0.5f, patch.v * 7.0f));
  const Floats butt = patch.v < 0.7f ? boards.butt : spread(0.0f);
  const Floats dark = from_0_to_1(0.35f + 0.55f * (boards.tone - 0.5f) + 0.8f * grain);
  const Triples board = mixed(texture.color, texture.color_2, dark);
  const Floats light = 1.0f - 0.65f * max(boards.joint, butt);
  return {board.x * light, board.y * light, board.z * light};
}

}  // namespace

BALLSERVO_WIDE Triples texture_colors(const Texture& texture, const Pairs& uv_m, const Pairs& patch_m) {
  const auto per_m = static_cast<float>(1.0 / texture.scale_m);
  const Pairs at{uv_m.u * per_m, uv_m.v * per_m};
  const Pairs side{max(patch_m.u * per_m, spread(least_patch)), max(patch_m.v * per_m, spread(least_patch))};
  const Floats longer = max(side.u, side.v);
  Floats share = spread(0.0f);  // of color_2
  switch (texture.pattern) {
    case Pattern::checks:
      share = 0.5f - 0.5f * mean_square_wave(at.u, side.u) * mean_square_wave(at.v, side.v) +
              0.15f * fading_noise(at.u * 3, at.v * 3, longer * 3);
      break;
    case Pattern::tiles: {
      const Floats joint_u = line_share(at.u, side.u, 0.04f), joint_v = line_share(at.v, side.v, 0.04f);
      share =
          1.0f - (1.0f - joint_u) * (1.0f - joint_v) + 0.2f * fading_noise(at.u * 4, at.v * 4, longer * 4);
      break;
    }
    case Pattern::noise:
      share = 0.5f + 1.2f * fading_noise(at.u, at.v, longer);
      break;
    case Pattern::wood:
      return wood_colors(texture, at, side);
    case Pattern::plain:
      break;
  }
  return mixed(texture.color, texture.color_2, from_0_to_1(share));
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
