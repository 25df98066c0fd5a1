// Pictures of a calibration board that somebody holds before a camera: which are taken, what camera they
// give, and where the board is to be held next.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/base/image_size.hpp"
#include "calibration/boards/board.hpp"
#include "calibration/boards/board_calibration.hpp"
#include "calibration/boards/board_detector.hpp"
#include "calibration/camera/camera.hpp"

namespace ballservo {

/// Takes a picture by itself once the board has been held still somewhere new.
class BoardLessons {
 public:
  static constexpr double still_s = 0.5;         ///< so long the board has to keep still,
  static constexpr double still_motion = 0.001;  ///< within this, of the picture's width
  static constexpr int still_pictures = 3;       ///< in so many pictures at least
  static constexpr double new_motion = 0.02;     ///< of the picture's width, from every picture taken
  static constexpr std::size_t most_taken = 60;  ///< more settle nothing, and take long

  enum class Seen { nothing, moving, known, taken };

  /// Throws InputError as parse_board.
  BoardLessons(const std::string& board_text, double square_m);
  const Board& board() const { return board_; }
  const std::string& board_text() const { return board_text_; }

  /// What was found in a picture of that size, taken at that time.
  Seen look(BoardFinding finding, ImageSize size, double time_s);
  /// Gives back the picture that was taken last; as long as the board stays there, it is not taken again.
  /// Throws Refusal where there is none.
  void undo();

  const std::vector<BoardView>& taken() const { return taken_; }
  const std::optional<BoardView>& newest() const { return newest_; }  ///< the board of the newest picture
  const std::string& words() const { return words_; }                 ///< what is to be said of that picture
  ImageSize size() const { return size_; }

 private:
  struct Still {
    BoardView view;
    double since_s;
    int pictures;
  };
  std::string fault_of(const BoardFinding& finding, ImageSize size) const;

  std::string board_text_;
  Board board_;
  ImageSize size_;
  std::vector<BoardView> taken_;
  std::optional<BoardView> newest_, given_back_;
  std::optional<Still> still_;
  std::string words_;
};

/// The camera that pictures of a board give.
struct BoardFit {
  static constexpr std::size_t least_boards = 4;
  static constexpr double diameter_m = 0.070, range_m = 1;  ///< of the ball that the map is about
  static constexpr std::size_t good_boards = 10;
  static constexpr double good_mm = 2;        ///< typically, where boards were
  static constexpr double good_worst_mm = 3;  ///< anywhere

  std::size_t boards = 0;
  std::optional<BoardCalibration> calibration;  ///< nothing where it is refused
  std::string refused;                          ///< why
  std::optional<BallSigmaMap> map;
  std::vector<std::string> lacks;  ///< as calibration_lacks has them

  /// From `good_boards` on, where this uncertainty (1 sigma) moves the ball by no more than that.
  bool is_good_enough() const;
  /// Where in the map the ball is most uncertain; nothing where there is no map.
  std::optional<std::size_t> worst_place() const;
};

/// Fits a camera of one of the models as `calibrate camera` does. Never throws.
BoardFit fit_boards(ImageSize size, const std::vector<BoardView>& views,
                    const std::vector<LensModel>& models);

/// A board that somebody is asked to hold.
struct AskedBoard {
  Eigen::Vector2d place_px{0, 0};  ///< of its middle, as far as the board is in the picture there
  std::size_t side = 0;            ///< that is tilted towards the camera: right, upper, left, lower
  double span = 0.35;              ///< of the picture's width or height, whichever is more
};

/// Where its four outermost points are seen (px), in turn from the upper left; none where the camera sees no
/// such board.
std::vector<Eigen::Vector2d> outline_of(const AskedBoard& asked, const Board& board, const Camera& camera);

/// Where the next board says most, and how it is to be held there.
struct BoardHint {
  Eigen::Vector2d place_px{0, 0};
  std::string words;
  std::vector<Eigen::Vector2d> outline_px;  ///< its outermost points then; none where it can't be said
};

/// Where the ball is most uncertain; without a fit, where the picture has fewest corners yet. Tilted to the
/// side to which fewest boards were, nearer or farther where all were alike.
BoardHint next_board(const Board& board, ImageSize size, const std::vector<BoardView>& views,
                     const BoardFit* fit);

}  // namespace ballservo
