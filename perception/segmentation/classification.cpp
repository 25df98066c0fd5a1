#include "perception/segmentation/classification.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>

#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

// The rows' places in the pictures of all classes.
using RowOfClass = std::array<std::uint64_t*, max_classes>;

// Calls each(class, i) for the set pixels i of a word.
template <class Each>
void look_up_word(const std::uint8_t* bgr, const ColorLookup& colors, std::uint64_t unsure,
                  const Each& each) {
  for (; unsure != 0; unsure &= unsure - 1) {
    const int i = __builtin_ctzll(unsure);
    each(colors.classify(bgr[3 * i], bgr[3 * i + 1], bgr[3 * i + 2]), i);
  }
}

// Looks up what the boxes did not tell.
void look_up(const std::uint8_t* bgr, const ColorLookup& colors, const std::uint64_t* unsure, int words,
             const RowOfClass& rows) {
  const std::size_t classes = static_cast<std::size_t>(colors.classes());
  for (int w = 0; w < words; ++w, bgr += 3 * BitPicture::word_bits) {
    if (unsure[w] == 0) continue;
    if (classes == 1) {  // a register serves, and is nearly twice as fast
      std::uint64_t found = 0;
      look_up_word(bgr, colors, unsure[w], [&](std::uint64_t k, int i) { found |= k << i; });
      rows[0][w] |= found;
      continue;
    }
    std::array<std::uint64_t, max_classes + 1> found{};
    look_up_word(bgr, colors, unsure[w], [&](ClassIndex k, int i) { found[k] |= std::uint64_t{1} << i; });
    for (std::size_t k = 0; k < classes; ++k) rows[k][w] |= found[k + 1];
  }
}

// As many pixels of a row as are told by the boxes before what is left is looked up.
constexpr int chunk_words = 16, chunk = chunk_words * BitPicture::word_bits;

void classify_chunk(const std::uint8_t* bgr, int pixels, const ColorLookup& colors, RowOfClass& rows) {
  std::array<std::uint64_t, chunk_words> unsure;
  const int words = (pixels + BitPicture::word_bits - 1) / BitPicture::word_bits;
  tell_by_boxes(bgr, pixels, colors.boxes(), rows.data(), unsure.data());
  look_up(bgr, colors, unsure.data(), words, rows);
  for (std::uint64_t*& row : rows) row += words;
}

template <class Row>
void for_rows(int rows, int threads, const Row& row) {
  if (threads == 1) {
    for (int v = 0; v < rows; ++v) row(v);
    return;
  }
  // TBB warns on the console of more threads than it may have.
  const auto most = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  tbb::task_arena(std::min(threads, static_cast<int>(most))).execute([&] {
    tbb::parallel_for(0, rows, row, tbb::static_partitioner());
  });
}

}  // namespace

void classify(const cv::Mat& bgr, const ColorLookup& colors, ClassPictures& classes, int threads) {
  if (bgr.type() != CV_8UC3)
    throw InputError(
        "picture",
        std::to_string(bgr.channels()) + " channels of " + std::to_string(8 * bgr.elemSize1()) + " bits",
        "8-bit BGR");
  classes.resize(static_cast<std::size_t>(colors.classes()));
  for (BitPicture& picture : classes) picture.resize(bgr.size());
  if (classes.empty()) return;
  for_rows(bgr.rows, threads, [&](int v) {
    RowOfClass rows{};
    for (std::size_t k = 0; k < classes.size(); ++k) rows[k] = classes[k].row(v);
    for (int u = 0; u < bgr.cols; u += chunk) {
      classify_chunk(bgr.ptr<std::uint8_t>(v) + 3 * u, std::min(chunk, bgr.cols - u), colors, rows);
    }
  });
}

cv::Mat class_numbers(const ClassPictures& classes, cv::Size size) {
  cv::Mat numbers = cv::Mat::zeros(size, CV_8UC1);
  for (std::size_t k = 0; k < classes.size(); ++k) {
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        if (classes[k].at(u, v)) numbers.at<ClassIndex>(v, u) = static_cast<ClassIndex>(k + 1);
      }
    }
  }
  return numbers;
}

}  // namespace ballservo
