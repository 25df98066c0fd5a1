// ballservo calibrate board: a calibration board to print.

#include <limits>

#include "app/commands/command.hpp"
#include "app/report/board_sheet.hpp"

namespace ballservo {
namespace {

struct CalibrateBoardOptions {
  CommonOptions common;
  std::string board;
  double square_m = std::numeric_limits<double>::quiet_NaN();
  std::filesystem::path output;
};

int calibrate_board(const CalibrateBoardOptions& options) {
  const Board board = parse_board(options.board, options.square_m);
  if (options.output.extension() != ".pdf")
    throw InputError("-o", options.output.string(), "a name that ends in .pdf");
  const BoardSheet sheet = draw_board_sheet(board, options.board);
  OutputFile file(options.output, options.common.overwrite(options.output));
  file.write(sheet.pdf);
  options.common.files->commit(file);
  write_json_results(options.common, {{"board", options.board},
                                      {"square_m", board.square_m},
                                      {"page", sheet.page},
                                      {"page_width_m", sheet.width_m},
                                      {"page_height_m", sheet.height_m}});
  if (!options.common.quiet)
    print_result("{}: {}, {:.0f} x {:.0f} mm; print it at 100 %, without \"fit to page\"\n",
                 options.output.string(), sheet.page, 1000 * sheet.width_m, 1000 * sheet.height_m);
  return exit_done;
}

}  // namespace

void add_calibrate_board_command(CLI::App& calibrate, Action& action) {
  const auto [command, options] = add_command<CalibrateBoardOptions>(
      calibrate, action, "board", "A board to print, at exact scale (PDF)", calibrate_board);
  command
      .add_option("--board", options.board,
                  "chessboard:9x6 (inner corners), circles:6x6 or acircles:4x11 (centres)")
      ->required();
  add_number_option(command, "--square", options.square_m, NumberRange::above(0, "m"),
                    "The side of a square, or the step between circles, in metres")
      ->required();
  add_output_option(command, "-o,--output", options.output, "FILE", "The sheet (PDF)")->required();
  add_common_options(command, options.common);
  command.footer(
      R"(The sheet is the smallest of A4 to A0 that holds the board with a white margin, landscape before portrait, or
has a size of its own. Print it at 100 %, measure the line below the board, and fix the sheet to something flat.
Exit: 0 done, 2 bad input.
Example:
  ballservo calibrate board --board chessboard:9x6 --square 0.025 -o board.pdf
  ballservo calibrate camera camera:0 --board chessboard:9x6 --square 0.025 -o camera.yaml)");
}

}  // namespace ballservo
