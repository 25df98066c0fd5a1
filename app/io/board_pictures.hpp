// Pictures of a calibration board, and the board found in each.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/io/image_source.hpp"
#include "calibration/base/image_size.hpp"
#include "calibration/boards/board.hpp"

namespace ballservo {

/// What became of one picture.
struct BoardPicture {
  std::filesystem::path file;
  int frame = -1;                 ///< of a video or camera; -1 for a still
  cv::Mat decoded;                ///< empty: a still, read again where it is needed
  std::optional<ImageSize> size;  ///< from the header; nothing where only the decoder can tell
  std::optional<BoardView> view;
  std::optional<std::pair<int, int>> seen;  ///< size of the chessboard that is there, the larger side first
  std::string rejected;                     ///< why it is not used; empty for those that are
  std::string remark;                       ///< what is special about one that is used; mostly empty

  std::string name() const;  ///< "left01.jpg", or "boards.mp4 frame 12"
  cv::Mat picture(double max_pixels) const;
};

struct BoardPictures {
  std::vector<BoardPicture> all;
  ImageSize size;  ///< that most pictures have, hence the camera's

  std::vector<const BoardPicture*> used() const;
};

struct BoardSearch {
  Board board;
  std::string board_text;  ///< as the user named it, for messages
  double max_pixels = 0;
  int threads = 0;  ///< 0: as many as the machine has
  bool quiet = false;
};

/// The pictures of a video or camera in which the board stands elsewhere than in those taken before, at most
/// 40; where there is none, one that says so. A camera is looked through for two minutes at most.
std::vector<BoardPicture> pictures_of_moving_board(FrameSequence& sequence, const SourceFile& source,
                                                   const BoardSearch& search);

/// Looks for the board in all pictures, several at a time; what is found does not depend on how many. Of
/// videos and cameras those that pictures_of_moving_board takes.
///
/// Pictures one or two pixels larger or smaller than most are used as they stand, the top-left pixel being
/// the same (a shift of a pixel is next to nothing for the pose that absorbs it), and carry a remark.
/// InputError: a file that cannot be read, pictures of different cameras (sizes further apart). Refusal:
/// chessboards that agree on another size than the one named, or no board at all.
BoardPictures find_boards(const std::vector<std::string>& sources, const BoardSearch& search);
/// The same of stills that no file holds, 8-bit BGR or grey: "picture 1" and so on.
BoardPictures find_boards(const std::vector<cv::Mat>& stills, const BoardSearch& search);

}  // namespace ballservo
