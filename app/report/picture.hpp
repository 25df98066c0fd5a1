// Pictures for pages and previews: as files, and side by side with their names.
#pragma once

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

namespace ballservo {

/// The contents of a file of a picture (8-bit BGR), whose name ends in `.png` or `.jpg`; `parameters` as
/// OpenCV's imencode has them. Throws std::invalid_argument for an empty picture.
std::string picture_bytes(const cv::Mat& picture, const std::string& ending,
                          const std::vector<int>& parameters = {cv::IMWRITE_JPEG_QUALITY, 88});

/// Pictures (8-bit BGR) in rows of three, each below its name. Cells are as large as the largest picture;
/// smaller ones are enlarged to fit, by nearest neighbour (so that single pixels stay visible); empty ones
/// stay empty. An empty list gives an empty picture.
cv::Mat labelled_grid(const std::vector<std::pair<std::string, cv::Mat>>& pictures);

}  // namespace ballservo
