
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "calibration/base/fault.hpp"
#include "calibration/pictures/image_file.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

constexpr int width = 48, height = 32;

/// An upright picture whose four quarters differ, so that no orientation looks like another.
cv::Mat upright_sample() {
  cv::Mat image(height, width, CV_8UC3, cv::Scalar(30, 30, 30));
  image(cv::Rect(0, 0, width / 2, height / 2)).setTo(cv::Scalar(20, 20, 230));
  image(cv::Rect(width / 2, 0, width / 2, height / 2)).setTo(cv::Scalar(20, 230, 20));
  image(cv::Rect(0, height / 2, width / 2, height / 2)).setTo(cv::Scalar(230, 20, 20));
  return image;
}

/// What a camera stores whose tag is `orientation`, pixel by pixel from the tag's definition: where the
/// stored row 0 and column 0 stand in the scene.
cv::Mat stored(const cv::Mat& scene, int orientation) {
  const bool swap = orientation >= 5;
  cv::Mat result(swap ? scene.cols : scene.rows, swap ? scene.rows : scene.cols, CV_8UC3);
  const int right = scene.cols - 1, bottom = scene.rows - 1;
  for (int row = 0; row < result.rows; ++row) {
    for (int column = 0; column < result.cols; ++column) {
      cv::Point at;
      switch (orientation) {
        case 1:
          at = {column, row};
          break;  // row 0 top, column 0 left
        case 2:
          at = {right - column, row};
          break;  // top, right
        case 3:
          at = {right - column, bottom - row};
          break;  // bottom, right
        case 4:
          at = {column, bottom - row};
          break;  // bottom, left
        case 5:
          at = {row, column};
          break;  // left, top
        case 6:
          at = {right - row, column};
          break;  // right, top
        case 7:
          at = {right - row, bottom - column};
          break;  // right, bottom
        default:
          at = {row, bottom - column};
          break;  // left, bottom
      }
      result.at<cv::Vec3b>(row, column) = scene.at<cv::Vec3b>(at);
    }
  }
  return result;
}

std::string number(std::uint32_t value, int length, bool big) {
  std::string result;
  for (int i = 0; i < length; ++i) result += static_cast<char>(value >> 8 * (big ? length - 1 - i : i) & 255);
  return result;
}

/// A TIFF structure of one other tag and the orientation.
std::string exif(int orientation, bool big) {
  return (big ? "MM" : "II") + number(42, 2, big) + number(8, 4, big) + number(2, 2, big) +
         number(0x0100, 2, big) + number(4, 2, big) + number(1, 4, big) + number(99, 4, big) +  //
         number(0x0112, 2, big) + number(3, 2, big) + number(1, 4, big) +
         number(static_cast<std::uint32_t>(orientation), 2, big) + number(0, 2, big) + number(0, 4, big);
}

std::string encoded_sample(const std::string& extension, const cv::Mat& image) {
  std::vector<uchar> bytes;
  EXPECT_TRUE(cv::imencode(extension, image, bytes));
  return {bytes.begin(), bytes.end()};
}

std::string jpeg_with(const cv::Mat& image, const std::string& tiff) {
  const std::string body = std::string("Exif\0\0", 6) + tiff;
  std::string bytes = encoded_sample(".jpg", image);
  return bytes.insert(2, "\xFF\xE1" + number(static_cast<std::uint32_t>(body.size() + 2), 2, true) + body);
}

std::uint32_t crc(const std::string& text) {
  std::uint32_t value = 0xFFFFFFFFu;
  for (const char c : text) {
    value ^= static_cast<unsigned char>(c);
    for (int i = 0; i < 8; ++i) value = value >> 1 ^ (value & 1 ? 0xEDB88320u : 0u);
  }
  return ~value;
}

std::string png_with(const cv::Mat& image, const std::string& tiff) {
  std::string bytes = encoded_sample(".png", image);
  const std::string chunk = "eXIf" + tiff;
  return bytes.insert(
      33, number(static_cast<std::uint32_t>(tiff.size()), 4, true) + chunk + number(crc(chunk), 4, true));
}

class Orientation : public testing::Test {
 protected:
  std::filesystem::path put(const std::string& bytes) const {
    std::ofstream(folder.path() / "picture", std::ios::binary) << bytes;
    return folder.path() / "picture";
  }
  test::TemporaryFolder folder;
};

TEST_F(Orientation, EveryTagGivesTheSameUprightPicture) {
  const cv::Mat scene = upright_sample();
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const cv::Mat pixels = stored(scene, orientation);
    EXPECT_EQ(cv::norm(upright(pixels, orientation), scene, cv::NORM_INF), 0) << orientation;
    for (const bool big : {false, true}) {
      const std::string png = png_with(pixels, exif(orientation, big));
      EXPECT_EQ(image_size_from_header(png), (ImageSize{width, height})) << orientation;
      EXPECT_EQ(cv::norm(read_color_image(put(png)), scene, cv::NORM_INF), 0) << orientation;
      const std::string jpeg = jpeg_with(pixels, exif(orientation, big));
      EXPECT_EQ(image_size_from_header(jpeg), (ImageSize{width, height})) << orientation;
      const cv::Mat read = read_color_image(put(jpeg));
      ASSERT_EQ(read.size(), scene.size()) << orientation;
      EXPECT_LT(cv::norm(read, scene, cv::NORM_L1) / static_cast<double>(3 * scene.total()), 12)
          << orientation;
    }
  }
}

TEST_F(Orientation, AThumbnailsOwnPictureDoesNotCount) {
  // The second segment is another application's; only the EXIF one says how the picture stands.
  const cv::Mat pixels = stored(upright_sample(), 6);
  std::string jpeg = jpeg_with(pixels, exif(6, false));
  jpeg.insert(2, std::string("\xFF\xE1\x00\x06xmp!", 8));
  EXPECT_EQ(read_color_image(put(jpeg)).size(), cv::Size(width, height));
}

TEST_F(Orientation, DamagedTagsMeanUpright) {
  const cv::Mat pixels = upright_sample();
  for (const int nonsense : {0, 9, 255, 65535}) {
    EXPECT_EQ(image_orientation_from_header(jpeg_with(pixels, exif(nonsense, true))), 1) << nonsense;
  }
  const std::string whole = exif(6, true);
  for (std::size_t length = 0; length < whole.size() - 4; ++length) {
    const std::string jpeg = jpeg_with(pixels, whole.substr(0, length));
    // The tag's value ends at byte 32.
    EXPECT_EQ(image_orientation_from_header(jpeg), length < 32 ? 1 : 6) << length;
    EXPECT_NO_THROW(read_color_image(put(jpeg))) << length;
  }
}

TEST_F(Orientation, HostileBytesAreSafe) {
  std::mt19937 engine(7);
  const cv::Mat pixels = stored(upright_sample(), 8);
  for (const std::string& whole : {jpeg_with(pixels, exif(8, true)), png_with(pixels, exif(8, false))}) {
    for (int i = 0; i < 4000; ++i) {
      std::string bytes = whole.substr(0, i % 3 ? whole.size() : engine() % 120);
      for (int k = 0; k < 4 && !bytes.empty(); ++k) {
        bytes[engine() % std::min<std::size_t>(bytes.size(), 100)] = static_cast<char>(engine());
      }
      const std::vector<char> exact(bytes.begin(), bytes.end());
      const int orientation = image_orientation_from_header({exact.data(), exact.size()});
      EXPECT_TRUE(orientation >= 1 && orientation <= 8);
    }
  }
}

}  // namespace
}  // namespace ballservo
