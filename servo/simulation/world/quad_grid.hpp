// Four numbers a cell of a grid, interpolated in between at many points at once.
#pragma once

#include <cstddef>
#include <cstring>
#include <vector>

#include "servo/simulation/world/lanes.hpp"

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace ballservo {

/// Four numbers of each point.
struct Quads {
  Floats values[4];
  const Floats& operator[](std::size_t k) const { return values[k]; }
};

class QuadGrid {
 public:
  QuadGrid(int columns, int rows)
      : columns_(columns),
        rows_(rows),
        values_(4 * static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  /// The cell's four numbers.
  float* cell(int column, int row) { return values_.data() + 4 * (row * columns_ + column); }

  /// At points between the centres of cells (column, row) and (column + 1, row + 1), which the grid must
  /// have; `x` and `y` from 0 at the former to 1 at the latter.
  Quads between(Ints column, Ints row, Floats x, Floats y) const {
    const Ints first = 4 * (row * columns_ + column);
    const Floats points_04 = mean_of_two<0>(first, x, y), points_15 = mean_of_two<1>(first, x, y);
    const Floats points_26 = mean_of_two<2>(first, x, y), points_37 = mean_of_two<3>(first, x, y);
    // From numbers of a point side by side to points side by side, in each half.
    const auto low = [](Floats a, Floats b) {
      return __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
    };
    const auto high = [](Floats a, Floats b) {
      return __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
    };
    const auto even = [](Floats a, Floats b) {
      return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
    };
    const auto odd = [](Floats a, Floats b) {
      return __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
    };
    const Floats low_01 = low(points_04, points_15), low_23 = low(points_26, points_37);
    const Floats high_01 = high(points_04, points_15), high_23 = high(points_26, points_37);
    return {{even(low_01, low_23), odd(low_01, low_23), even(high_01, high_23), odd(high_01, high_23)}};
  }

 private:
  using Quad = float __attribute__((vector_size(16)));

  /// Of points k and k + 4, one in each half.
  template <int k>
  Floats mean_of_two(const Ints& first, const Floats& x, const Floats& y) const {
    const float *const a = values_.data() + first[k], *const b = values_.data() + first[k + 4];
    const auto corner = [&](int at) {
      Quad of_a, of_b;
      std::memcpy(&of_a, a + at, sizeof of_a);
      std::memcpy(&of_b, b + at, sizeof of_b);
      return __builtin_shufflevector(of_a, of_b, 0, 1, 2, 3, 4, 5, 6, 7);
    };
    const int down = 4 * columns_;
    const Floats right = __builtin_shufflevector(x, x, k, k, k, k, k + 4, k + 4, k + 4, k + 4);
    const Floats below = __builtin_shufflevector(y, y, k, k, k, k, k + 4, k + 4, k + 4, k + 4);
    const Floats upper = corner(0) + right * (corner(4) - corner(0));
    const Floats lower = corner(down) + right * (corner(down + 4) - corner(down));
    return upper + below * (lower - upper);
  }

  int columns_, rows_;
  std::vector<float> values_;
};

}  // namespace ballservo

#pragma GCC diagnostic pop
