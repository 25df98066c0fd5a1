#include "app/io/image_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"
#include "calibration/pictures/image_file.hpp"
#include "tests/support/faults.hpp"
#include "tests/support/test_data.hpp"

namespace fs = std::filesystem;

namespace ballservo {
namespace {

class ImageSource : public testing::Test {
 protected:
  std::string put_image(const std::string& name, int width = 8) const {
    cv::imwrite((folder.path() / name).string(), cv::Mat(6, width, CV_8UC3, cv::Scalar(1, 2, 3)));
    return (folder.path() / name).string();
  }
  std::string put_text(const std::string& name, const std::string& text) const {
    std::ofstream(folder.path() / name, std::ios::binary) << text;
    return (folder.path() / name).string();
  }
  /// A video whose picture k has the grey value 20 k.
  std::string put_video(const std::string& name, int frames) const {
    const std::string file = (folder.path() / name).string();
    cv::VideoWriter writer(file, cv::VideoWriter::fourcc('F', 'F', 'V', '1'), 10, cv::Size(32, 16));
    EXPECT_TRUE(writer.isOpened());
    for (int k = 0; k < frames; ++k) writer.write(cv::Mat(16, 32, CV_8UC3, cv::Scalar::all(20 * k)));
    return file;
  }
  /// A phone's upright video: stored lying, its left half white, with the track header's matrix (ISO/IEC
  /// 14496-12, 8.3.2) that turns it to be shown: (x, y) to (-turn y, turn x).
  std::string put_portrait_video(const std::string& name, int turn) const {
    const std::string file = (folder.path() / name).string();
    cv::Mat lying(32, 64, CV_8UC3, cv::Scalar::all(0));
    lying(cv::Rect(0, 0, 32, 32)).setTo(cv::Scalar::all(255));
    {
      cv::VideoWriter writer(file, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), 10, lying.size());
      EXPECT_TRUE(writer.isOpened());
      for (int k = 0; k < 3; ++k) writer.write(lying);
    }
    std::string bytes = read_file_bytes(file, 1 << 20);
    constexpr std::size_t matrix_in_header = 44;  // from the box's name on
    const std::size_t header = bytes.find("tkhd");
    EXPECT_NE(header, std::string::npos);
    const auto put = [&](int entry, std::int32_t fixed_point) {
      for (int k = 0; k < 4; ++k)
        bytes.at(header + matrix_in_header + static_cast<std::size_t>(4 * entry + k)) =
            static_cast<char>(fixed_point >> (24 - 8 * k));
    };
    constexpr std::int32_t one = 1 << 16;
    put(0, 0), put(1, turn * one), put(3, -turn * one), put(4, 0);
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
  }
  static std::size_t faults_of(const std::vector<std::string>& sources,
                               double max_pixels = default_max_pixels) {
    return test::faults_of([&] { open_sources(sources, 30, max_pixels); }).size();
  }

  test::TemporaryFolder folder;
};

TEST_F(ImageSource, FolderIsReadInNaturalOrder) {
  fs::create_directory(folder.path() / "in");
  for (const char* name : {"in/a10.png", "in/a2.PNG", "in/a1.png", "in/.hidden.png"}) put_image(name);
  put_text("in/notes.txt", "not a picture, and not named like one");
  const auto sequences = open_sources({(folder.path() / "in").string()}, 10, default_max_pixels);
  ASSERT_EQ(sequences.size(), 1u);
  EXPECT_EQ(sequences[0]->length(), 3);
  std::vector<std::string> names;
  std::vector<double> times;
  while (const auto frame = sequences[0]->next()) {
    names.push_back(frame->source);
    times.push_back(frame->time_s);
    EXPECT_EQ(frame->index, 0);
  }
  EXPECT_THAT(names, testing::ElementsAre("a1.png", "a2.PNG", "a10.png"));
  EXPECT_THAT(times, testing::ElementsAre(0, 0.1, 0.2));
}

TEST_F(ImageSource, SingleFilesFormOneSequenceInTheirOrder) {
  const auto sequences = open_sources({put_image("b.png"), put_image("a.png")}, 30, default_max_pixels);
  ASSERT_EQ(sequences.size(), 1u);
  EXPECT_EQ(sequences[0]->next()->source, "b.png");
  EXPECT_EQ(sequences[0]->next()->source, "a.png");
  EXPECT_FALSE(sequences[0]->next());
}

TEST_F(ImageSource, TellsOfJpegFilesAndVideosThatTheirColoursAreCoarse) {
  const auto is_coarse = [](const std::string& source) {
    return open_sources({source}, 30, default_max_pixels).at(0)->next()->coarse_chroma;
  };
  EXPECT_FALSE(is_coarse(put_image("a.png")));
  EXPECT_TRUE(is_coarse(put_image("a.jpg")));
  EXPECT_TRUE(is_coarse(put_video("v.mkv", 2)));
}

// Its size stands at its end, behind the pixels.
TEST_F(ImageSource, ALargeTiffIsAPicture) {
  cv::Mat noise(300, 400, CV_8UC3);
  cv::RNG(1).fill(noise, cv::RNG::UNIFORM, 0, 256);
  cv::imwrite((folder.path() / "large.tiff").string(), noise);
  ASSERT_GT(fs::file_size(folder.path() / "large.tiff"), 1u << 17);
  const auto sequences = open_sources({(folder.path() / "large.tiff").string()}, 30, default_max_pixels);
  EXPECT_EQ(cv::norm(sequences.at(0)->next()->bgr, noise, cv::NORM_INF), 0);
  EXPECT_THROW(open_sources({(folder.path() / "large.tiff").string()}, 30, 1000).at(0)->next(), InputError);
}

TEST_F(ImageSource, NamesThatSeveralFilesHaveAreTold) {
  for (const char* sub : {"left", "right"}) fs::create_directory(folder.path() / sub);
  const std::string left = put_image("left/a.png"), right = put_image("right/a.png"),
                    b = put_image("left/b.png");
  const auto repeated = [](const std::vector<std::string>& sources) {
    return repeated_names(open_sources(sources, 30, default_max_pixels));
  };
  EXPECT_EQ(repeated({left, right, b}), std::vector<std::string>{"a.png"});
  EXPECT_EQ(repeated({(folder.path() / "left").string(), right}), std::vector<std::string>{"a.png"});
  EXPECT_TRUE(repeated({left, left, b}).empty());  // the same file again is the same file
}

TEST_F(ImageSource, VideoCarriesItsOwnTime) {
  const auto sequences = open_sources({put_video("v.mkv", 5)}, 30, default_max_pixels);
  ASSERT_EQ(sequences.size(), 1u);
  int count = 0;
  while (const auto frame = sequences[0]->next()) {
    EXPECT_EQ(frame->index, count);
    EXPECT_NEAR(frame->time_s, 0.1 * count, 0.002);
    EXPECT_EQ(frame->source, "v.mkv");
    EXPECT_NEAR(frame->bgr.at<cv::Vec3b>(8, 16)[1], 20 * count, 3);
    ++count;
  }
  EXPECT_EQ(count, 5);
}

TEST_F(ImageSource, APortraitVideoStandsUpright) {
  for (const int turn : {1, -1}) {
    const auto sequences = open_sources({put_portrait_video("phone.mp4", turn)}, 30, default_max_pixels);
    const auto frame = sequences.front()->next();
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->bgr.size(), cv::Size(32, 64));
    const double top = cv::mean(frame->bgr.rowRange(0, 32))[0],
                 bottom = cv::mean(frame->bgr.rowRange(32, 64))[0];
    EXPECT_GT(turn * (top - bottom), 200);
  }
}

TEST_F(ImageSource, EveryBadSourceIsNamedAtOnce) {
  put_image("good.png");
  fs::create_directory(folder.path() / "empty");
  EXPECT_EQ(faults_of({(folder.path() / "none.png").string(), put_text("zero.png", ""),
                       put_text("text.png", "hello"), (folder.path() / "empty").string(), "camera:x",
                       "camera:-1", "camera:999", (folder.path() / "good.png").string()}),
            7u);
  EXPECT_EQ(faults_of({}), 1u);
}

TEST_F(ImageSource, PlaylistsAndDamagedVideosAreRefused) {
  const std::string video = put_video("v.mkv", 3);
  EXPECT_EQ(faults_of({put_text("list.mkv", "ffconcat version 1.0\nfile v.mkv\n")}), 1u);
  EXPECT_EQ(faults_of({put_text("list.m3u8", "#EXTM3U\n#EXTINF:1,\nv.mkv\n")}), 1u);
  EXPECT_EQ(faults_of({put_text("cut.mkv", read_file_bytes(video, 1 << 20).substr(0, 60))}), 1u);
}

TEST_F(ImageSource, LargePicturesAndVideosAreRefusedBeforeDecoding) {
  EXPECT_EQ(faults_of({put_image("wide.png", 1000), put_video("v.mkv", 2)}, 100), 2u);
}

TEST_F(ImageSource, ImageFilesRefuseWhatMoves) {
  const std::string image = put_image("a.png");
  EXPECT_EQ(image_files({image}), std::vector<fs::path>{image});
  const std::string video = put_video("v.mkv", 2);
  const auto faults = test::faults_of([&] { image_files({image, video, "camera:0"}); });
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_EQ(faults[0].found, "a video");
  EXPECT_EQ(faults[1].found, "a camera");
  for (const Fault& fault : faults) EXPECT_EQ(fault.allowed, "image files or folders of images");
}

TEST_F(ImageSource, RateMustBePositive) {
  const std::string image = put_image("a.png");
  for (const double fps : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(open_sources({image}, fps, default_max_pixels), InputError);
  }
}

}  // namespace
}  // namespace ballservo
