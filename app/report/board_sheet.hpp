// A calibration board to print: a PDF at exact scale.
#pragma once

#include <string>

#include "calibration/boards/board.hpp"

namespace ballservo {

struct BoardSheet {
  std::string pdf;
  std::string page;  ///< "A4 landscape", or "a page of its own size"
  double width_m = 0, height_m = 0;
};

/// The board on the smallest of A4 to A0, landscape before portrait, on which it and its white margin fit,
/// else on a page of its own size, with a line to check the printer by and what to tell `calibrate camera`
/// of it (`board_text` of --board). Throws InputError for a board that no printer or PDF viewer can take.
BoardSheet draw_board_sheet(const Board& board, const std::string& board_text);

}  // namespace ballservo
