// Boards from files, folders and videos: what is used, what is remarked on, what is refused; and the report.
#include "app/io/board_pictures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "app/io/video_writer.hpp"
#include "app/report/camera_report.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/pictures/image_file.hpp"
#include "tests/calibration/board_examples.hpp"
#include "tests/calibration/camera_examples.hpp"
#include "tests/support/faults.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using testing::HasSubstr;

const Camera brown_camera(test::camera_parameters(LensModel::brown, 533, {-0.28, 0.05, 1e-3, -5e-4, 0.09}));

/// Pictures of boards that stand at different places, 8-bit BGR.
std::vector<cv::Mat> board_photographs(int count) {
  RandomEngine engine = random_stream(5, "board pictures");
  std::vector<cv::Mat> pictures;
  for (int i = 0; i < count; ++i) {
    const auto placed = test::random_place(brown_camera, test::chessboard, engine, 0.6, 0.25, 0.5, 12);
    cv::cvtColor(
        test::photographed(test::painted_chessboard(brown_camera, test::chessboard, placed, 3), 1, engine),
        pictures.emplace_back(), cv::COLOR_GRAY2BGR);
  }
  return pictures;
}

BoardSearch search_for(const std::string& board) {
  return {parse_board(board, 0.025), board, default_max_pixels, 2, true};
}

class BoardFiles : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }
  std::string write(const std::string& name, const cv::Mat& picture) const {
    cv::imwrite(path(name), picture);
    return path(name);
  }
  /// Each picture is shown for so many frames.
  void write_video(const std::string& name, const std::vector<cv::Mat>& pictures, int frames) const {
    VideoFile video(path(name), Overwrite::refuse, 30);
    for (const cv::Mat& picture : pictures)
      for (int i = 0; i < frames; ++i) video.write(picture);
    video.commit();
  }

 private:
  test::TemporaryFolder folder_;
};

TEST_F(BoardFiles, AVideoGivesEachPlaceOfTheBoardOnce) {
  const auto photographs = board_photographs(6);
  write_video("boards.mkv", photographs, 10);
  const BoardPictures found = find_boards({path("boards.mkv")}, search_for("chessboard:9x6"));
  EXPECT_EQ(found.used().size(), 6u);
  EXPECT_EQ(found.size, (ImageSize{640, 480}));
  EXPECT_THAT(found.used()[1]->name(), HasSubstr("boards.mkv frame 10"));
  write_video("one.mkv", {photographs[0]}, 5);
  EXPECT_THROW(find_boards({path("one.mkv")}, search_for("chessboard:8x5")), Refusal);
}

/// A camera before which nothing moves, or another board stands in every picture.
class EndlessPictures : public FrameSequence {
 public:
  EndlessPictures(std::vector<cv::Mat> pictures, double rate_hz)
      : pictures_(std::move(pictures)), rate_hz_(rate_hz) {}
  std::optional<Frame> next() override {
    const cv::Mat& picture = pictures_[static_cast<std::size_t>(index_ / 5) % pictures_.size()];
    return Frame{picture, name(), index_, index_++ / rate_hz_};
  }
  std::string name() const override { return "camera:0"; }
  long length() const override { return 0; }
  int taken() const { return index_; }

 private:
  std::vector<cv::Mat> pictures_;
  double rate_hz_;
  int index_ = 0;
};

TEST_F(BoardFiles, ACameraGivesEachPlaceOfTheBoardOnceAndEndsAfterTwoMinutes) {
  const SourceFile source{"camera:0", SourceFile::Kind::camera};
  EndlessPictures moving(board_photographs(3), 0.25);
  const auto found = pictures_of_moving_board(moving, source, search_for("chessboard:9x6"));
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[1].name(), "camera:0 frame 5");
  EXPECT_NEAR(moving.taken() / 0.25, 120, 8);

  EndlessPictures empty({cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(128))}, 0.25);
  const auto none = pictures_of_moving_board(empty, source, search_for("chessboard:9x6"));
  ASSERT_EQ(none.size(), 1u);
  EXPECT_THAT(none[0].rejected, HasSubstr("none of its pictures"));
}

TEST_F(BoardFiles, ACameraThatIsNotThereIsNamed) {
  EXPECT_THAT(test::fault_lines([] { find_boards({"camera:251"}, search_for("chessboard:9x6")); }),
              HasSubstr("camera:251: found no camera that can be opened"));
}

TEST_F(BoardFiles, APictureOfAPixelMoreIsUsedAndSaidToBe) {
  const auto photographs = board_photographs(3);
  cv::Mat larger;
  cv::copyMakeBorder(photographs[2], larger, 0, 1, 0, 1, cv::BORDER_REPLICATE);
  const std::vector<std::string> files{write("a.png", photographs[0]), write("b.png", photographs[1]),
                                       write("c.png", larger)};
  const BoardPictures found = find_boards(files, search_for("chessboard:9x6"));
  ASSERT_EQ(found.used().size(), 3u);
  EXPECT_EQ(found.size, (ImageSize{640, 480}));
  EXPECT_THAT(found.used()[2]->remark, HasSubstr("641x481"));
  EXPECT_EQ(found.used()[0]->remark, "");
  cv::Mat other;
  cv::resize(photographs[2], other, cv::Size(800, 600));
  EXPECT_THROW(find_boards({files[0], files[1], write("d.png", other)}, search_for("chessboard:9x6")),
               InputError);
}

TEST_F(BoardFiles, AnotherBoardThanNamedIsRefusedWithItsSize) {
  const auto photographs = board_photographs(2);
  std::vector<std::string> files;
  for (std::size_t i = 0; i < photographs.size(); ++i)
    files.push_back(write("board" + std::to_string(i) + ".png", photographs[i]));
  for (const char* wrong : {"chessboard:8x5", "chessboard:10x7"}) {
    try {
      find_boards(files, search_for(wrong));
      ADD_FAILURE() << wrong << " was taken";
    } catch (const Refusal& refusal) {
      EXPECT_THAT(refusal.what(), HasSubstr("9x6 inner corners")) << wrong;
    }
  }
  EXPECT_EQ(find_boards(files, search_for("chessboard:6x9")).used().size(), 2u);
  files.push_back(files.front());  // no new evidence
  const BoardPictures twice = find_boards(files, search_for("chessboard:9x6"));
  EXPECT_EQ(twice.used().size(), 2u);
  EXPECT_THAT(twice.all[2].rejected, HasSubstr("the same picture as"));
}

TEST(CameraReport, HoldsWhatThePageShows) {
  const std::vector<BoardView> views = test::random_views(brown_camera, 8, 0.1, 3);
  BoardPictures pictures;
  pictures.all.resize(9);
  for (std::size_t k = 0; k < 8; ++k) {
    pictures.all[k].decoded = cv::Mat(1200, 1600, CV_8UC3, cv::Scalar::all(128));
    pictures.all[k].view = views[k];
  }
  pictures.all[2].file = "large.png";
  pictures.all[2].remark = "a pixel more";
  pictures.all[8].file = "<dark>.png";
  pictures.all[8].rejected = "the board was not found in it";
  std::vector<const BoardPicture*> used = pictures.used();
  const CameraCalibration calibration{std::move(pictures), std::move(used), views,
                                      calibrate_from_boards({640, 480}, views, test::only(LensModel::brown))};
  const test::TemporaryFolder temporary;
  const OutputFolder folder(temporary.path() / "boards", Overwrite::refuse);
  const auto report = camera_report(calibration, 1e7, folder);
  EXPECT_EQ(report["boards"].size(), 8u);
  EXPECT_EQ(report["looked_at"], 9);
  EXPECT_EQ(report["rejected"],
            nlohmann::ordered_json::parse(R"([["<dark>.png", "the board was not found in it"]])"));
  EXPECT_EQ(report["remarks"], nlohmann::ordered_json::parse(R"(["large.png: a pixel more"])"));
  EXPECT_EQ(report["ball_maps"].size(), 3u);
  EXPECT_EQ(report["boards"][0]["corners_px"].size(), views[0].size());
  EXPECT_EQ(cv::imread((folder.path() / "board_08.png").string()).cols, 1600);
  EXPECT_EQ(cv::imread((folder.path() / report["boards"][7]["file"].get<std::string>()).string()).cols, 800)
      << "small enough for a page";
  EXPECT_THAT(report["advice"].get<std::vector<std::string>>(),
              testing::Contains(HasSubstr("Take more pictures")));
}

}  // namespace
}  // namespace ballservo
