// A window of square cells around the robot that moves with it: where cells are kept, and which are new.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>

namespace ballservo {

/// floor(value_m / side_m): index of the square of a grid in which a coordinate lies. Truncation is rounding
/// down but for negative numbers; std::floor is a call on machines of the baseline.
inline int floor_index(double value_m, double side_m) {
  const double scaled = value_m / side_m;
  const int whole = static_cast<int>(scaled);
  return whole - (scaled < whole ? 1 : 0);
}

/// A square of the floor: index of its column (x) and row (y) in the odometry's frame.
struct FloorCell {
  int column = 0, row = 0;
};

/// `size` x `size` cells, a power of two, kept as a ring in both directions: nothing is copied when the robot
/// moves.
template <int size>
class FloorWindow {
 public:
  static_assert((size & (size - 1)) == 0);
  static constexpr std::size_t cells = static_cast<std::size_t>(size) * size;

  const FloorCell& first() const { return first_; }  ///< the one of the least column and row
  bool contains(const FloorCell& cell) const {
    return cell.column >= first_.column && cell.column < first_.column + size && cell.row >= first_.row &&
           cell.row < first_.row + size;
  }
  /// Where a cell of the window is kept.
  static std::size_t index(const FloorCell& cell) {
    constexpr int mask = size - 1;
    return static_cast<std::size_t>((cell.row & mask) * size + (cell.column & mask));
  }
  /// The cell of the window that is kept there.
  FloorCell cell(std::size_t index) const {
    const int column = static_cast<int>(index) % size, row = static_cast<int>(index) / size;
    return {first_.column + ((column - first_.column) & (size - 1)),
            first_.row + ((row - first_.row) & (size - 1))};
  }
  /// Moves the window's middle there; `enters` is told the index of each cell that was not in it before.
  template <typename Enters>
  void follow(const FloorCell& middle, const Enters& enters) {
    const FloorCell before = first_;
    first_ = {middle.column - size / 2, middle.row - size / 2};
    const auto moved = [](int from, int to) { return std::min(std::abs(to - from), size); };
    const int columns = moved(before.column, first_.column), rows = moved(before.row, first_.row);
    for (int k = 0; k < columns; ++k) {
      const int column = first_.column > before.column ? first_.column + size - 1 - k : first_.column + k;
      for (int r = 0; r < size; ++r) enters(index({column, r}));
    }
    for (int k = 0; k < rows; ++k) {
      const int row = first_.row > before.row ? first_.row + size - 1 - k : first_.row + k;
      for (int c = 0; c < size; ++c) enters(index({c, row}));
    }
  }

 private:
  FloorCell first_;
};

}  // namespace ballservo
