#include "app/report/picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace ballservo {
namespace {

struct FiniteRange {
  double low = 0, high = 0;
};

FiniteRange finite_range(const cv::Mat& values) {
  FiniteRange range;
  bool any = false;
  for (int y = 0; y < values.rows; ++y) {
    const double* row = values.ptr<double>(y);
    for (int x = 0; x < values.cols * values.channels(); ++x) {
      if (!std::isfinite(row[x])) continue;
      range.low = any ? std::min(range.low, row[x]) : row[x];
      range.high = any ? std::max(range.high, row[x]) : row[x];
      any = true;
    }
  }
  return range;
}

// Scaled from the finite range to 0..255; 0 where not finite.
cv::Mat to_bytes(const cv::Mat& picture) {
  if (picture.depth() == CV_8U) return picture;
  cv::Mat values;
  picture.convertTo(values, CV_64F);
  const FiniteRange range = finite_range(values);
  const double span = range.high - range.low;
  cv::Mat bytes(picture.size(), CV_8UC(picture.channels()));
  for (int y = 0; y < values.rows; ++y) {
    const double* from = values.ptr<double>(y);
    std::uint8_t* to = bytes.ptr<std::uint8_t>(y);
    for (int x = 0; x < values.cols * values.channels(); ++x) {
      const double unit =
          std::isfinite(from[x]) && span > 0 && std::isfinite(span) ? (from[x] - range.low) / span : 0;
      to[x] = static_cast<std::uint8_t>(std::lround(255 * unit));
    }
  }
  return bytes;
}

// Hershey fonts have no letters beyond ASCII.
std::string ascii(const std::string& text) {
  std::string plain;
  for (const char c : text) {
    if ((c & 0xc0) == 0x80) continue;
    plain += c >= 0x20 && c < 0x7f ? c : '?';
  }
  return plain;
}

}  // namespace

cv::Mat viewable(const cv::Mat& picture) {
  if (picture.empty()) return {};
  const cv::Mat bytes = to_bytes(picture);
  cv::Mat bgr;
  switch (bytes.channels()) {
    case 1:
      cv::cvtColor(bytes, bgr, cv::COLOR_GRAY2BGR);
      break;
    case 3:
      bgr = bytes;
      break;
    case 4:
      cv::cvtColor(bytes, bgr, cv::COLOR_BGRA2BGR);
      break;
    default:
      throw std::invalid_argument("a picture of 1, 3 or 4 channels is needed");
  }
  return bgr;
}

std::string picture_bytes(const cv::Mat& picture, PictureFormat format, int jpeg_quality) {
  if (picture.empty()) throw std::invalid_argument("an empty picture has no file");
  const bool jpeg = format == PictureFormat::jpeg;
  std::vector<int> parameters;
  if (jpeg) parameters = {cv::IMWRITE_JPEG_QUALITY, jpeg_quality};
  std::vector<std::uint8_t> bytes;
  cv::imencode(jpeg ? ".jpg" : ".png", viewable(picture), bytes, parameters);
  return {bytes.begin(), bytes.end()};
}

cv::Mat labelled_grid(const std::vector<std::pair<std::string, cv::Mat>>& pictures, int columns) {
  if (pictures.empty()) return {};
  const int count = static_cast<int>(pictures.size());
  const int across = std::clamp(columns, 1, count), down = (count + across - 1) / across;
  int cell_width = 120, cell_height = 60;
  for (const auto& [name, picture] : pictures) {
    cell_width = std::max(cell_width, picture.cols);
    cell_height = std::max(cell_height, picture.rows);
  }
  const int gap = 8, label_height = 26;
  cv::Mat grid(gap + down * (cell_height + label_height + gap), gap + across * (cell_width + gap), CV_8UC3,
               cv::Scalar(250, 250, 250));
  for (int k = 0; k < count; ++k) {
    const auto& [name, picture] = pictures[static_cast<std::size_t>(k)];
    const int left = gap + (k % across) * (cell_width + gap);
    const int top = gap + (k / across) * (cell_height + label_height + gap);
    const std::string text = ascii(name);
    double size = 0.55;
    const int width = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, nullptr).width;
    if (width > cell_width) size *= static_cast<double>(cell_width) / width;
    cv::putText(grid, text, {left, top + 18}, cv::FONT_HERSHEY_SIMPLEX, size, {40, 40, 40}, 1, cv::LINE_AA);
    if (picture.empty()) continue;
    const cv::Mat shown = viewable(picture);
    const double scale =
        std::min(static_cast<double>(cell_width) / shown.cols, static_cast<double>(cell_height) / shown.rows);
    const cv::Size fitted(std::max(1, static_cast<int>(shown.cols * scale)),
                          std::max(1, static_cast<int>(shown.rows * scale)));
    cv::Mat resized = shown;
    if (fitted != shown.size()) cv::resize(shown, resized, fitted, 0, 0, cv::INTER_NEAREST);
    resized.copyTo(grid(cv::Rect({left + (cell_width - fitted.width) / 2, top + label_height}, fitted)));
  }
  return grid;
}

}  // namespace ballservo
