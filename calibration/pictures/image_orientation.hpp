// Which way up a picture is to be shown: the orientation that cameras write into EXIF.
#pragma once

#include <opencv2/core.hpp>
#include <string_view>

namespace ballservo {

/// The orientation tag (1 to 8, EXIF 2.32, 4.6.4) of the first bytes of a JPEG, PNG or WebP file; 1, upright,
/// where there is none or it is damaged.
int image_orientation_from_header(std::string_view bytes);

/// Whether that orientation turns the picture on its side, so that width and height change places.
inline bool swaps_sides(int orientation) { return orientation >= 5 && orientation <= 8; }

/// The picture as it is to be shown.
cv::Mat upright(const cv::Mat& image, int orientation);

}  // namespace ballservo
