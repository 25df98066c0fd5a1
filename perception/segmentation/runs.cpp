#include "perception/segmentation/runs.hpp"

#include <algorithm>
#include <array>

namespace ballservo {
namespace {

// One row of the class pictures.
struct ClassRow {
  ClassRow(const ClassPictures& pictures, int v) : classes(pictures.size()) {
    for (std::size_t k = 0; k < classes; ++k) words[k] = pictures[k].row(v);
  }

  ClassIndex class_at(int w, std::uint64_t bit) const {
    for (std::size_t k = 0; k < classes; ++k) {
      if (words[k][w] & bit) return static_cast<ClassIndex>(k + 1);
    }
    return no_class;
  }

  // Pixels of a word, in any class, that are of another class than the one to their left.
  std::uint64_t changes(int w) const {
    std::uint64_t changed = 0;
    for (std::size_t k = 0; k < classes; ++k) {
      const std::uint64_t left = w > 0 ? words[k][w - 1] >> (BitPicture::word_bits - 1) : 0;
      changed |= words[k][w] ^ (words[k][w] << 1 | left);
    }
    return changed;
  }

  std::size_t classes;
  std::array<const std::uint64_t*, max_classes> words;  // the first `classes`
};

// Calls found(begin, end, class) for each run of a row.
template <class Found>
void for_each_run(const ClassPictures& classes, cv::Size size, int v, const Found& found) {
  int begin = 0;
  ClassIndex color_class = no_class;
  const ClassRow row(classes, v);
  const int words = classes.empty() ? 0 : classes[0].row_words();
  for (int w = 0; w < words; ++w) {
    for (std::uint64_t changed = row.changes(w); changed != 0; changed &= changed - 1) {
      const int u = BitPicture::word_bits * w + __builtin_ctzll(changed);
      if (u == size.width) break;  // the bits behind the last pixel
      if (u > begin) found(begin, u, color_class);
      begin = u;
      color_class = row.class_at(w, changed & (0 - changed));
    }
  }
  found(begin, size.width, color_class);
}

void drop_shorter(ClassPictures& classes, cv::Size size, int shortest) {
  for (int v = 0; v < size.height; ++v) {
    for_each_run(classes, size, v, [&](int begin, int end, ClassIndex color_class) {
      if (color_class != no_class && end - begin < shortest)
        classes[static_cast<std::size_t>(color_class) - 1].fill(v, begin, end, false);
    });
  }
}

}  // namespace

bool Runs::try_to_cut(const ClassPictures& classes, cv::Size size, int max_runs) {
  runs_.clear();
  row_begin_.clear();
  for (int v = 0; v < size.height; ++v) {
    row_begin_.push_back(static_cast<int>(runs_.size()));
    for_each_run(classes, size, v, [&](int begin, int end, ClassIndex color_class) {
      runs_.push_back({v, begin, end, color_class});
    });
    if (static_cast<int>(runs_.size()) > max_runs) return false;
  }
  row_begin_.push_back(static_cast<int>(runs_.size()));
  return true;
}

void Runs::cut(ClassPictures& classes, cv::Size size) {
  const int max_runs = std::max(max_runs_, size.height);
  runs_.reserve(static_cast<std::size_t>(max_runs) + static_cast<std::size_t>(size.width));
  row_begin_.reserve(static_cast<std::size_t>(size.height) + 1);
  for (shortest_ = 1; !try_to_cut(classes, size, max_runs);) {
    shortest_ *= 2;
    drop_shorter(classes, size, shortest_);
  }
}

}  // namespace ballservo
