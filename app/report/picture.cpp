#include "app/report/picture.hpp"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace ballservo {
namespace {

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

std::string picture_bytes(const cv::Mat& picture, const std::string& ending,
                          const std::vector<int>& parameters) {
  if (picture.empty()) throw std::invalid_argument("an empty picture has no file");
  std::vector<std::uint8_t> bytes;
  cv::imencode(ending, picture, bytes, parameters);
  return {bytes.begin(), bytes.end()};
}

cv::Mat labelled_grid(const std::vector<std::pair<std::string, cv::Mat>>& pictures) {
  if (pictures.empty()) return {};
  const int count = static_cast<int>(pictures.size());
  const int across = std::min(3, count), down = (count + across - 1) / across;
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
    const double scale = std::min(static_cast<double>(cell_width) / picture.cols,
                                  static_cast<double>(cell_height) / picture.rows);
    const cv::Size fitted(std::max(1, static_cast<int>(picture.cols * scale)),
                          std::max(1, static_cast<int>(picture.rows * scale)));
    cv::Mat resized = picture;
    if (fitted != picture.size()) cv::resize(picture, resized, fitted, 0, 0, cv::INTER_NEAREST);
    resized.copyTo(grid(cv::Rect({left + (cell_width - fitted.width) / 2, top + label_height}, fitted)));
  }
  return grid;
}

}  // namespace ballservo
