// Pictures for pages and previews: as files, and side by side with their names.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

namespace ballservo {

enum class PictureFormat { png, jpeg };

/// The contents of a file of a picture (8-bit BGR). Throws std::invalid_argument for an empty one.
std::string picture_bytes(const cv::Mat& picture, PictureFormat format, int jpeg_quality = 88);

/// Pictures (8-bit BGR) in rows of three, each below its name. Cells are as large as the largest picture;
/// smaller ones are enlarged to fit, by nearest neighbour (so that single pixels stay visible); empty ones
/// stay empty. An empty list gives an empty picture.
cv::Mat labelled_grid(const std::vector<std::pair<std::string, cv::Mat>>& pictures);

}  // namespace ballservo
