// calibrate board: what the sheet shows once it is on paper.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "calibration/boards/board_detector.hpp"
#include "tests/program/program_run.hpp"

const char* ballservo::test::program_path() { return BALLSERVO_PROGRAM; }

namespace ballservo {
namespace {

using testing::HasSubstr;

class BoardSheetTest : public test::ProgramTest {
 protected:
  nlohmann::json sheet(const std::string& board, double square_m) const {
    const Ending ending = run(fmt::format(
        "calibrate board --board {} --square {} -o board.pdf --json sheet.json --force", board, square_m));
    EXPECT_EQ(ending.code, 0) << ending.messages;
    return nlohmann::json::parse(contents("sheet.json"));
  }
  /// As a printer would put it on paper.
  cv::Mat printed(int dots_per_inch) const {
    const std::string command = fmt::format("cd '{}' && pdftoppm -r {} -gray -singlefile board.pdf paper",
                                            dir.string(), dots_per_inch);
    return std::system(command.c_str()) == 0 ? cv::imread((dir / "paper.pgm").string(), cv::IMREAD_GRAYSCALE)
                                             : cv::Mat();
  }
  std::string words() const {
    const std::string command = "cd '" + dir.string() + "' && pdftotext board.pdf words.txt";
    return std::system(command.c_str()) == 0 ? contents("words.txt") : "";
  }
  using Ending = test::Ending;
};

bool can_print() { return std::system("which pdftoppm pdftotext >/dev/null") == 0; }

TEST_F(BoardSheetTest, APrintedBoardIsFoundInItsSize) {
  if (!can_print()) GTEST_SKIP() << "no poppler-utils";
  struct Case {
    const char *board, *page;
    double square_m, width_mm, height_mm;
  };
  for (const Case& c : {Case{"chessboard:9x6", "A4 landscape", 0.025, 297, 210},
                        Case{"chessboard:6x9", "A4 portrait", 0.025, 210, 297},
                        Case{"chessboard:9x6", "A3 landscape", 0.03, 420, 297},
                        Case{"circles:6x6", "A4 landscape", 0.02, 297, 210},
                        Case{"acircles:4x11", "A4 portrait", 0.02, 210, 297},
                        Case{"chessboard:4x3", "a page of its own size", 0.25, 1375, 1139}}) {
    SCOPED_TRACE(fmt::format("{} {}", c.board, c.square_m));
    const nlohmann::json said = sheet(c.board, c.square_m);
    EXPECT_EQ(said["page"], c.page);
    const int dots_per_inch = static_cast<int>(3 / c.square_m);
    const double dots_per_m = dots_per_inch / 0.0254;
    const cv::Mat paper = printed(dots_per_inch);
    ASSERT_FALSE(paper.empty());
    EXPECT_NEAR(paper.cols, c.width_mm / 1000 * dots_per_m, 1);
    EXPECT_NEAR(paper.rows, c.height_mm / 1000 * dots_per_m, 1);
    EXPECT_NEAR(said["page_width_m"].get<double>(), c.width_mm / 1000, 1e-9);
    EXPECT_NEAR(said["page_height_m"].get<double>(), c.height_mm / 1000, 1e-9);
    const Board board = parse_board(c.board, c.square_m);
    const BoardFinding found = find_board(paper, board);
    ASSERT_TRUE(found.view) << found.reason;
    const BoardView& view = *found.view;
    ASSERT_EQ(view.size(), board.points().size());
    double found_px = 0, true_px = 0;  // over all pairs
    for (std::size_t i = 0; i < view.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) {
        const double pair_px = (view.points_m[i] - view.points_m[k]).norm() * dots_per_m;
        true_px += pair_px;
        found_px += (view.corners_px[i] - view.corners_px[k]).norm();
        // The printer puts edges on quarters of a dot.
        EXPECT_NEAR((view.corners_px[i] - view.corners_px[k]).norm(), pair_px, 0.5);
      }
    EXPECT_NEAR(found_px / true_px, 1, 1e-3);
    EXPECT_THAT(words(), HasSubstr(fmt::format("--board {} --square {}", c.board, c.square_m)));
  }
}

TEST_F(BoardSheetTest, TheLineIsAsLongAsItSays) {
  if (!can_print()) GTEST_SKIP() << "no poppler-utils";
  for (const auto& [board, length_mm] :
       {std::pair("chessboard:9x6", 200), std::pair("chessboard:6x9", 100)}) {
    sheet(board, 0.025);
    const cv::Mat paper = printed(200);
    ASSERT_FALSE(paper.empty());
    EXPECT_THAT(words(), HasSubstr(fmt::format("{} mm between the ends", length_mm)));
    int longest_px = 0;
    for (int row = paper.rows - 1; row > paper.rows * 9 / 10; --row) {
      int run_px = 0;
      for (int column = 0; column < paper.cols; ++column)
        longest_px =
            std::max(longest_px, run_px = paper.at<std::uint8_t>(row, column) < 128 ? run_px + 1 : 0);
    }
    EXPECT_NEAR(longest_px, length_mm / 25.4 * 200, 4);
  }
}

TEST_F(BoardSheetTest, WhatNobodyCanPrintIsRefused) {
  for (const char* words : {"--board chessboard:9x6 --square 0", "--board chessboard:9x6 --square nan",
                            "--board chessboard:9x6 --square 1e-9",
                            "--board chessboard:100x100 --square 0.06", "--board chessboard:9 --square 0.025",
                            "--board stars:9x6 --square 0.025", "--square 0.025", "--board chessboard:9x6"}) {
    EXPECT_EQ(run(std::string("calibrate board -o board.pdf ") + words).code, 2) << words;
    EXPECT_EQ(names().count("board.pdf"), 0u) << words;
  }
  for (const char* name : {"board.png", "board", ".pdf"}) {
    const Ending ending =
        run(std::string("calibrate board --board chessboard:9x6 --square 0.025 -o ") + name);
    EXPECT_EQ(ending.code, 2) << name;
    EXPECT_THAT(ending.messages, HasSubstr("a name that ends in .pdf"));
    EXPECT_EQ(names().count(name), 0u);
  }
  put("board.pdf", "mine");
  EXPECT_EQ(run("calibrate board --board chessboard:9x6 --square 0.025 -o board.pdf").code, 2);
  EXPECT_EQ(contents("board.pdf"), "mine");
}

}  // namespace
}  // namespace ballservo
