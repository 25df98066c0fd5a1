// Pictures of one bit a pixel: what the segmentation works on, 64 pixels at a time.
#pragma once

#include <cstdint>
#include <opencv2/core/types.hpp>
#include <vector>

#include "calibration/color/color_table.hpp"

namespace ballservo {

/// Rows of 64-bit words: pixel u is bit u % 64 of word u / 64 of its row, and the bits behind the last pixel
/// are 0. Memory is reused when the size changes.
class BitPicture {
 public:
  static constexpr int word_bits = 64;

  /// After it, every row is to be written anew.
  void resize(cv::Size size) {
    size_ = size;
    row_words_ = (size.width + word_bits - 1) / word_bits;
    words_.resize(static_cast<std::size_t>(row_words_) * static_cast<std::size_t>(size.height));
  }

  cv::Size size() const { return size_; }
  int row_words() const { return row_words_; }
  std::uint64_t* row(int v) { return &words_[start_of(v)]; }
  const std::uint64_t* row(int v) const { return &words_[start_of(v)]; }
  /// Of all rows.
  std::vector<std::uint64_t>& words() { return words_; }
  const std::vector<std::uint64_t>& words() const { return words_; }

  bool at(int u, int v) const { return (row(v)[u / word_bits] >> (u % word_bits)) & 1; }

  /// Sets the pixels from u = begin to end - 1 of a row, or clears them.
  void fill(int v, int begin, int end, bool value) {
    std::uint64_t* const words = row(v);
    for (int w = begin / word_bits; w * word_bits < end; ++w) {
      const std::uint64_t bits = bits_from(begin - w * word_bits) & ~bits_from(end - w * word_bits);
      words[w] = value ? words[w] | bits : words[w] & ~bits;
    }
  }

  /// The bits of a word from `first` on; all for 0 and below, none for 64 and above.
  static constexpr std::uint64_t bits_from(int first) {
    return first <= 0 ? ~std::uint64_t{0} : first >= word_bits ? 0 : ~std::uint64_t{0} << first;
  }
  /// The bits that are pixels in a row's last word.
  std::uint64_t last_word_bits() const { return ~bits_from(size_.width - (row_words_ - 1) * word_bits); }

 private:
  std::size_t start_of(int v) const {
    return static_cast<std::size_t>(row_words_) * static_cast<std::size_t>(v);
  }

  cv::Size size_;
  int row_words_ = 0;
  std::vector<std::uint64_t> words_;
};

/// One picture for each colour class, all of one size: class k is entry k - 1.
using ClassPictures = std::vector<BitPicture>;

/// The pixels that have a ball's colour, in a window of the picture: of its class, or absorbed by a region of
/// it.
struct ColoredPixels {
  ClassIndex color_class;
  const BitPicture& pixels;
  cv::Point window;  ///< top-left pixel

  bool knows(int u_px, int v_px) const {
    return cv::Rect(window, pixels.size()).contains(cv::Point(u_px, v_px));
  }
  bool at(int u_px, int v_px) const { return pixels.at(u_px - window.x, v_px - window.y); }
};

}  // namespace ballservo
