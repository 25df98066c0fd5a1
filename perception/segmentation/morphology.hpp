// Stage 2: noise removal and hole filling in the class pictures (paper, figures 2c and 4).
#pragma once

#include <cstdint>
#include <vector>

#include "perception/segmentation/bit_picture.hpp"
#include "perception/segmentation/instructions.hpp"

namespace ballservo {

/// Outside the picture counts as inside for erosion and as outside for dilation, so that a ball cut by the
/// border is not eaten from there.
class ClassMorphology {
 public:
  explicit ClassMorphology(Instructions instructions = Instructions::fastest) : instructions_(instructions) {}

  /// Opening (3x3) of every class on its own: specks thinner than three pixels go.
  void open(const ClassPictures& classes, ClassPictures& opened);
  /// Closing (5x5) of every class on its own; a pixel that already has a class keeps it, and the first class
  /// has it that closes over it.
  void close(const ClassPictures& opened, ClassPictures& closed);

 private:
  Instructions instructions_;
  BitPicture rows_;  // reused between frames
  std::vector<std::uint64_t> row_, taken_;
};

}  // namespace ballservo
