#include "perception/runs.hpp"

#include <algorithm>

namespace ballservo {
namespace {

ClassIndex class_at(const ClassPictures& classes, int v, int w, std::uint64_t bit) {
  for (std::size_t k = 0; k < classes.size(); ++k) {
    if (classes[k].row(v)[w] & bit) return static_cast<ClassIndex>(k + 1);
  }
  return no_class;
}

// Pixels of a word, in any class, that are of another class than the one to their left.
std::uint64_t changes(const ClassPictures& classes, int v, int w) {
  std::uint64_t changed = 0;
  for (const BitPicture& picture : classes) {
    const std::uint64_t* const row = picture.row(v);
    const std::uint64_t left = w > 0 ? row[w - 1] >> (BitPicture::word_bits - 1) : 0;
    changed |= row[w] ^ (row[w] << 1 | left);
  }
  return changed;
}

// Calls found(begin, end, class) for each run of a row.
template <class Found>
void for_each_run(const ClassPictures& classes, cv::Size size, int v, const Found& found) {
  int begin = 0;
  ClassIndex color_class = no_class;
  const int words = classes.empty() ? 0 : classes[0].row_words();
  for (int w = 0; w < words; ++w) {
    std::uint64_t changed = changes(classes, v, w);
    if (w + 1 == words) changed &= classes[0].last_word_bits();
    for (; changed != 0; changed &= changed - 1) {
      const int u = BitPicture::word_bits * w + __builtin_ctzll(changed);
      if (u > begin) found(begin, u, color_class);
      begin = u;
      color_class = class_at(classes, v, w, changed & (0 - changed));
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
