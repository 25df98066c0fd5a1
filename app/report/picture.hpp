// Pictures for pages and previews: as files, and side by side with their names.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

namespace ballservo {

enum class PictureFormat { png, jpeg };

/// The contents of a picture file, of a picture of 1, 3 (BGR) or 4 channels of any depth (8 bits as they are,
/// others as `viewable` shows them). Throws std::invalid_argument for an empty picture.
std::string picture_bytes(const cv::Mat& picture, PictureFormat format, int jpeg_quality = 88);

/// 8-bit BGR for looking at: grey spread over the channels, alpha dropped, other depths scaled from their
/// finite range to 0..255.
cv::Mat viewable(const cv::Mat& picture);

/// Pictures in rows, each below its name, 8-bit BGR. Cells are as large as the largest picture; smaller ones
/// are enlarged to fit, by nearest neighbour (so that single pixels stay visible); empty ones stay empty. An
/// empty list gives an empty picture.
cv::Mat labelled_grid(const std::vector<std::pair<std::string, cv::Mat>>& pictures, int columns);

}  // namespace ballservo
