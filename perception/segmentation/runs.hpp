// A picture's rows cut into runs of pixels of one class.
#pragma once

#include <opencv2/core/types.hpp>
#include <vector>

#include "calibration/color/color_table.hpp"
#include "perception/segmentation/bit_picture.hpp"

namespace ballservo {

/// Pixels of one class, or of none, from u = begin to end - 1 of row v.
struct Run {
  int v, begin, end;
  ClassIndex color_class;
};

/// All runs of a picture in raster order; they cover it. Takes memory when it is made and for larger pictures
/// alone.
class Runs {
 public:
  /// At most `max_runs`, but one a row in any case.
  explicit Runs(int max_runs) : max_runs_(max_runs) {}

  /// Where there are more, those of a class that are shorter than 2 pixels become background, in `classes`
  /// too; if that does not suffice, shorter than 4, 8 and so on.
  void cut(ClassPictures& classes, cv::Size size);

  const std::vector<Run>& all() const { return runs_; }
  const Run& operator[](int i) const { return runs_[static_cast<std::size_t>(i)]; }
  std::size_t capacity() const { return runs_.capacity(); }
  int size() const { return static_cast<int>(runs_.size()); }
  /// The number of the first run of a row; of one behind the last row: the number of runs.
  int row_begin(int v) const { return row_begin_[static_cast<std::size_t>(v)]; }
  /// Runs of a class shorter than this were dropped; 1 where all were kept.
  int shortest() const { return shortest_; }

 private:
  bool try_to_cut(const ClassPictures& classes, cv::Size size, int max_runs);

  int max_runs_;
  std::vector<Run> runs_;
  std::vector<int> row_begin_;
  int shortest_ = 1;
};

}  // namespace ballservo
