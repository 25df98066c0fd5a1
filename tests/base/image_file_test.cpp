#include "calibration/pictures/image_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"
#include "tests/support/faults.hpp"
#include "tests/support/test_data.hpp"

namespace fs = std::filesystem;

namespace ballservo {
namespace {

/// A smooth coloured picture that no encoder makes trivial.
cv::Mat sample(int width, int height) {
  cv::Mat image(height, width, CV_8UC3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.at<cv::Vec3b>(y, x) =
          cv::Vec3b(static_cast<uchar>(3 * x), static_cast<uchar>(5 * y), static_cast<uchar>(x * y / 7));
    }
  }
  return image;
}

std::string encoded(const std::string& extension, const cv::Mat& image,
                    const std::vector<int>& parameters = {}) {
  std::vector<uchar> bytes;
  EXPECT_TRUE(cv::imencode(extension, image, bytes, parameters)) << extension;
  return {bytes.begin(), bytes.end()};
}

struct Format {
  const char* extension;
  std::vector<int> parameters;
  bool lossless;
};

const std::vector<Format>& formats() {
  static const std::vector<Format> all = {{".png", {}, true},
                                          {".jpg", {}, false},
                                          {".jpg", {cv::IMWRITE_JPEG_PROGRESSIVE, 1}, false},
                                          {".jpg", {cv::IMWRITE_JPEG_RST_INTERVAL, 4}, false},
                                          {".bmp", {}, true},
                                          {".ppm", {}, true},
                                          {".ppm", {cv::IMWRITE_PXM_BINARY, 0}, true},
                                          {".tiff", {}, true},
                                          {".webp", {cv::IMWRITE_WEBP_QUALITY, 80}, false},
                                          {".webp", {cv::IMWRITE_WEBP_QUALITY, 101}, true}};
  return all;
}

class ImageFile : public testing::Test {
 protected:
  fs::path put(const std::string& bytes, const std::string& name = "picture") const {
    const fs::path file = folder.path() / name;
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
  }
  test::TemporaryFolder folder;
};

TEST_F(ImageFile, EveryFormatReadsBackWithItsSizeKnownBefore) {
  const cv::Mat image = sample(61, 37);
  for (const Format& format : formats()) {
    const std::string bytes = encoded(format.extension, image, format.parameters);
    EXPECT_EQ(image_size_from_header(bytes), (ImageSize{61, 37})) << format.extension;
    const cv::Mat back = read_color_image(put(bytes));
    ASSERT_EQ(back.type(), CV_8UC3);
    if (format.lossless) {
      EXPECT_EQ(cv::norm(image, back, cv::NORM_INF), 0) << format.extension;
    } else {
      EXPECT_LT(cv::norm(image, back, cv::NORM_L1) / static_cast<double>(3 * image.total()), 40)
          << format.extension;
    }
  }
}

TEST_F(ImageFile, AnyCutIsRefusedOrHarmless) {
  const cv::Mat image = sample(61, 37);
  for (const Format& format : formats()) {
    const std::string bytes = encoded(format.extension, image, format.parameters);
    const cv::Mat whole = read_color_image(put(bytes));
    for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 150) {
      try {
        const cv::Mat cut = read_color_image(put(bytes.substr(0, length)));
        // What follows the pixels may be missing (a TIFF's last tags); pixels may not.
        EXPECT_EQ(cv::norm(whole, cut, cv::NORM_INF), 0) << format.extension << " cut at " << length;
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("picture"));
      }
    }
    EXPECT_THROW(read_color_image(put(bytes.substr(0, bytes.size() * 9 / 10))), InputError)
        << format.extension;
  }
}

TEST_F(ImageFile, EveryPrefixOfAHeaderIsSafe) {
  const cv::Mat image = sample(61, 37);
  for (const Format& format : formats()) {
    const std::string bytes = encoded(format.extension, image, format.parameters);
    for (std::size_t length = 0; length < std::min<std::size_t>(bytes.size(), 1000); ++length) {
      // A copy of exactly this length, so that a read beyond its end is one beyond an allocation.
      const std::vector<char> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
      const auto size = image_size_from_header({cut.data(), cut.size()});
      if (size &&
          format.extension != std::string(".ppm")) {  // a cut in the middle of digits is another number
        EXPECT_EQ(*size, (ImageSize{61, 37})) << format.extension << " cut at " << length;
      }
    }
  }
}

TEST_F(ImageFile, DamagedBytesGiveAPictureOrAnInputError) {
  const cv::Mat image = sample(24, 16);
  std::mt19937 engine(5);
  for (const Format& format : formats()) {
    const std::string whole = encoded(format.extension, image, format.parameters);
    for (int i = 0; i < 300; ++i) {
      std::string bytes = whole;
      for (unsigned k = 1 + engine() % 4; k > 0; --k) {
        bytes[engine() % std::min<std::size_t>(bytes.size(), i % 2 ? 64 : bytes.size())] =
            static_cast<char>(engine());
      }
      try {
        const cv::Mat read = read_color_image(put(bytes), 1e5);
        EXPECT_EQ(read.type(), CV_8UC3);
        EXPECT_LE(read.total(), 100000u);
      } catch (const InputError&) {
      }
    }
  }
}

TEST_F(ImageFile, LargePictureIsRefusedFromItsHeader) {
  // A header that promises 60000 x 60000 pixels over a few bytes.
  std::string bytes = encoded(".png", sample(8, 8));
  bytes[18] = bytes[22] = static_cast<char>(0xEA);
  bytes[19] = bytes[23] = static_cast<char>(0x60);
  EXPECT_EQ(image_size_from_header(bytes), (ImageSize{60000, 60000}));
  EXPECT_THAT(test::fault_lines([&] { read_color_image(put(bytes)); }),
              testing::AllOf(testing::HasSubstr("60000 x 60000"), testing::HasSubstr("--max-pixels")));
  const fs::path small = put(encoded(".png", sample(8, 8)));
  EXPECT_NO_THROW(read_color_image(small, 64));
  EXPECT_THROW(read_color_image(small, 63), InputError);
  EXPECT_THROW(read_color_image(small, std::numeric_limits<double>::quiet_NaN()), InputError);
}

TEST_F(ImageFile, WhatIsNoPictureIsRefused) {
  EXPECT_THROW(read_color_image(folder.path() / "none.png"), InputError);
  EXPECT_THROW(read_color_image(folder.path()), InputError);
  EXPECT_THROW(read_color_image(put("")), InputError);
  EXPECT_THROW(read_color_image(put("hello, world\n", "text.png")), InputError);
  EXPECT_THROW(read_color_image(put(std::string(10000, '\0'))), InputError);
  const fs::path pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(read_color_image(pipe), InputError);
  EXPECT_THROW(read_color_image("/dev/zero"), InputError);
}

TEST_F(ImageFile, OddSizesInHeadersAreNoSizes) {
  using namespace std::string_literals;
  for (const std::string& bytes :
       {"P6\n0 5\n255\n"s, "P6\n-1 5\n255\n"s, "P6\n99999999999999999999 5\n255\n"s, "P65 5\n"s, "P6"s,
        "P6\n5"s, "P6 # 5 5"s, "\xFF\xD8\xFF\xE0\x00\x00"s, "\xFF\xD8\xFF\xE0\x00\x01zz"s,
        "II*\0\xFF\xFF\xFF\xFF"s, "RIFFxxxxWEBPVP8 "s, "BM"s}) {
    EXPECT_EQ(image_size_from_header(bytes), std::nullopt) << bytes;
  }
  EXPECT_EQ(image_size_from_header("P5 # a comment 1 2\n 7\t9\n255\n"), (ImageSize{7, 9}));
}

TEST_F(ImageFile, GreyAndDeepAndAlphaBecomeBgr) {
  cv::Mat grey;
  cv::cvtColor(sample(20, 10), grey, cv::COLOR_BGR2GRAY);
  cv::Mat spread;
  cv::cvtColor(grey, spread, cv::COLOR_GRAY2BGR);
  EXPECT_EQ(cv::norm(read_color_image(put(encoded(".png", grey))), spread, cv::NORM_INF), 0);
  cv::Mat deep;
  sample(20, 10).convertTo(deep, CV_16U, 257);
  EXPECT_LE(cv::norm(read_color_image(put(encoded(".png", deep))), sample(20, 10), cv::NORM_INF), 1);
  cv::Mat alpha;
  cv::cvtColor(sample(20, 10), alpha, cv::COLOR_BGR2BGRA);
  EXPECT_EQ(cv::norm(read_color_image(put(encoded(".png", alpha))), sample(20, 10), cv::NORM_INF), 0);
}

TEST_F(ImageFile, TrailingBytesOfACameraAreAllowed) {
  const std::string jpeg = encoded(".jpg", sample(30, 20)) + std::string(500, '\0') + "maker";
  EXPECT_EQ(read_color_image(put(jpeg)).size(), cv::Size(30, 20));
}

TEST_F(ImageFile, EmbeddedThumbnailDoesNotHideACut) {
  const std::string thumbnail = encoded(".jpg", sample(8, 8));
  std::string jpeg = encoded(".jpg", sample(30, 20));
  const std::size_t length = thumbnail.size() + 2;
  ASSERT_LT(length, 65536u);
  std::string segment = "\xFF\xE1";
  segment += static_cast<char>(length >> 8);
  segment += static_cast<char>(length & 255);
  jpeg.insert(2, segment + thumbnail);
  EXPECT_NO_THROW(read_color_image(put(jpeg)));
  EXPECT_THROW(read_color_image(put(jpeg.substr(0, jpeg.size() - 10))), InputError);
}

TEST_F(ImageFile, AFileTellsWhetherItsColoursAreCoarse) {
  for (const Format& format : formats()) {
    const std::string bytes = encoded(format.extension, sample(30, 20), format.parameters);
    EXPECT_EQ(has_coarse_chroma(bytes), !format.lossless) << format.extension;
    EXPECT_EQ(read_stored_image(put(bytes)).coarse_chroma, !format.lossless) << format.extension;
  }
  // The first component's sampling factors, 2 x 2, stand eleven bytes after a baseline frame's marker.
  std::string jpeg = encoded(".jpg", sample(30, 20));
  const std::size_t frame = jpeg.find("\xFF\xC0");
  ASSERT_NE(frame, std::string::npos);
  ASSERT_EQ(jpeg[frame + 11], '\x22');
  jpeg[frame + 11] = '\x21';
  EXPECT_TRUE(has_coarse_chroma(jpeg)) << "in one direction";
  jpeg[frame + 11] = '\x11';
  EXPECT_FALSE(has_coarse_chroma(jpeg));
  EXPECT_FALSE(has_coarse_chroma(jpeg.substr(0, frame + 11)));
  EXPECT_FALSE(has_coarse_chroma(encoded(".jpg", cv::Mat(20, 30, CV_8U, cv::Scalar(90))))) << "grey";
}

TEST_F(ImageFile, FileBytesStopAtTheLimit) {
  EXPECT_EQ(read_file_bytes(put("12345"), 5), "12345");
  EXPECT_THROW(read_file_bytes(put("123456"), 5), InputError);
  EXPECT_EQ(read_file_bytes(put(""), 5), "");
}

TEST_F(ImageFile, RealPicturesHaveTheSizeOfTheirHeaders) {
  const auto examples = test::opencv_doc_dir();
  if (!examples) GTEST_SKIP() << "opencv-doc's pictures are not on this machine";
  const fs::path file = *examples / "left01.jpg";
  EXPECT_EQ(image_size_from_header(read_file_bytes(file, 1 << 24)), (ImageSize{640, 480}));
  EXPECT_EQ(read_color_image(file).size(), cv::Size(640, 480));
}

}  // namespace
}  // namespace ballservo
