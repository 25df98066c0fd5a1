// Class pictures from pictures of class numbers, which are easier to paint.
#pragma once

#include <opencv2/core.hpp>

#include "calibration/base/random.hpp"
#include "perception/segmentation/bit_picture.hpp"

namespace ballservo::test {

inline ClassPictures to_bits(const cv::Mat& numbers, int classes) {
  ClassPictures pictures(static_cast<std::size_t>(classes));
  for (int k = 1; k <= classes; ++k) {
    BitPicture& picture = pictures[static_cast<std::size_t>(k) - 1];
    picture.resize(numbers.size());
    for (int v = 0; v < numbers.rows; ++v) {
      for (int u = 0; u < numbers.cols; ++u) picture.fill(v, u, u + 1, numbers.at<std::uint8_t>(v, u) == k);
    }
  }
  return pictures;
}

/// Whether no bit is set behind the rows' last pixels.
inline bool ends_are_clear(const ClassPictures& pictures) {
  for (const BitPicture& picture : pictures) {
    for (int v = 0; v < picture.size().height; ++v) {
      if (picture.row(v)[picture.row_words() - 1] & ~picture.last_word_bits()) return false;
    }
  }
  return true;
}

/// Blots of random classes and sizes over noise of that density.
inline cv::Mat random_classes(cv::Size size, int classes, double noise, RandomEngine& engine) {
  cv::Mat numbers = cv::Mat::zeros(size, CV_8UC1);
  const auto any = [&](int count) {
    return static_cast<int>(uniform_index(engine, static_cast<std::uint32_t>(count)));
  };
  for (int i = 0; i < 12; ++i) {
    const cv::Rect blot(any(size.width), any(size.height), 1 + any(size.width), 1 + any(size.height));
    const cv::Rect part(blot.x, blot.y, 1 + blot.width / 3, 1 + blot.height / 3);
    numbers(part & cv::Rect({0, 0}, size)).setTo(any(classes + 1));
  }
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      if (uniform01(engine) < noise)
        numbers.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(any(classes + 1));
    }
  }
  return numbers;
}

}  // namespace ballservo::test
