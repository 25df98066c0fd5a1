#include "app/report/board_sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

constexpr double points_per_m = 72 / 0.0254;
constexpr double printers_margin_m = 0.008, footer_m = 0.014, ruler_step_m = 0.1, tick_step_m = 0.01;
constexpr double least_square_m = 0.001, largest_page_m = 14400 / points_per_m;  // a PDF's limit

/// A drawing of a page, in metres from its bottom left corner.
class Page {
 public:
  Page(double width_m, double height_m) : width_m_(width_m), height_m_(height_m) {}

  void rectangle(double x_m, double y_m, double width_m, double height_m) {
    put("{} {} {} {} re\n", x_m, y_m, width_m, height_m);
  }
  void circle(double x_m, double y_m, double radius_m) {
    // Four cubic curves are round to 0.03 % of the radius with this share of it between their control points.
    const double r = radius_m, k = 0.5522847498 * r;
    put("{} {} m\n", x_m + r, y_m);
    put("{} {} {} {} {} {} c\n", x_m + r, y_m + k, x_m + k, y_m + r, x_m, y_m + r);
    put("{} {} {} {} {} {} c\n", x_m - k, y_m + r, x_m - r, y_m + k, x_m - r, y_m);
    put("{} {} {} {} {} {} c\n", x_m - r, y_m - k, x_m - k, y_m - r, x_m, y_m - r);
    put("{} {} {} {} {} {} c\n", x_m + k, y_m - r, x_m + r, y_m - k, x_m + r, y_m);
  }
  void text(double x_m, double y_m, const std::string& words) {
    put("BT /F1 9 Tf {} {} Td (", x_m, y_m);
    drawing_ += words + ") Tj ET\n";
  }

  /// What was drawn, filled with black.
  std::string pdf() const {
    const std::string contents = drawing_ + "f\n";
    const std::string objects[] = {
        "<</Type /Catalog /Pages 2 0 R>>", "<</Type /Pages /Kids [3 0 R] /Count 1>>",
        fmt::format("<</Type /Page /Parent 2 0 R /MediaBox [0 0 {} {}] /Contents 4 0 R /Resources <</Font "
                    "<</F1 5 0 R>>>>>>",
                    in_points(width_m_), in_points(height_m_)),
        fmt::format("<</Length {}>>\nstream\n{}\nendstream", contents.size() + 1, contents),
        "<</Type /Font /Subtype /Type1 /BaseFont /Helvetica>>"};
    std::string file = "%PDF-1.4\n", places = "0000000000 65535 f \n";
    int number = 0;
    for (const std::string& object : objects) {
      places += fmt::format("{:010} 00000 n \n", file.size());
      file += fmt::format("{} 0 obj\n{}\nendobj\n", ++number, object);
    }
    return file + fmt::format("xref\n0 {0}\n{1}trailer\n<</Size {0} /Root 1 0 R>>\nstartxref\n{2}\n%%EOF\n",
                              number + 1, places, file.size());
  }

 private:
  static std::string in_points(double length_m) { return fmt::format("{:.5f}", length_m * points_per_m); }
  template <class... Lengths>
  void put(fmt::string_view format, Lengths... lengths_m) {
    drawing_ += fmt::format(fmt::runtime(format), in_points(lengths_m)...);
  }

  double width_m_, height_m_;
  std::string drawing_;
};

struct Size {
  double width_m, height_m;
};

/// Of all that is black, and the white around it.
Size printed_size(const Board& board) {
  const auto points = board.points();
  double right_m = 0, bottom_m = 0;
  for (const Eigen::Vector3d& point : points)
    right_m = std::max(right_m, point.x()), bottom_m = std::max(bottom_m, point.y());
  const double around_m = board.pattern == BoardPattern::chessboard ? 2 * board.square_m : board.square_m;
  return {right_m + around_m, bottom_m + around_m};
}

void draw_board(Page& page, const Board& board, double left_m, double top_m) {
  const double side_m = board.square_m;
  if (board.pattern == BoardPattern::chessboard) {
    for (int row = 0; row <= board.rows; ++row)
      for (int column = row % 2; column <= board.columns; column += 2)
        page.rectangle(left_m + side_m * column, top_m - side_m * (row + 1), side_m, side_m);
    return;
  }
  const double nearest_m = board.pattern == BoardPattern::acircles ? M_SQRT2 * side_m : side_m;
  for (const Eigen::Vector3d& point : board.points())
    page.circle(left_m + side_m / 2 + point.x(), top_m - side_m / 2 - point.y(), nearest_m / 4);
}

void draw_footer(Page& page, const Board& board, const std::string& board_text, double width_m) {
  constexpr double line_m = 0.0003, tick_m = 0.003, x_m = printers_margin_m, y_m = printers_margin_m;
  const double length_m = ruler_step_m * std::floor((width_m - 2 * printers_margin_m) / ruler_step_m + 1e-9);
  page.rectangle(x_m, y_m, length_m, line_m);
  for (long tick = 0; tick <= std::lround(length_m / tick_step_m); ++tick)
    page.rectangle(x_m + tick_step_m * static_cast<double>(tick) - line_m / 2, y_m, line_m, tick_m);
  page.text(
      x_m, y_m + 0.005,
      fmt::format("{:.0f} mm between the ends of this line, else print again at 100 %. {} of {:.6g} mm: "
                  "--board {} --square {}",
                  1000 * length_m, board.pattern == BoardPattern::chessboard ? "Squares" : "Steps",
                  1000 * board.square_m, board_text, board.square_m));
}

}  // namespace

BoardSheet draw_board_sheet(const Board& board, const std::string& board_text) {
  const Size black = printed_size(board);
  // A finder needs some white around the outermost squares; circles have it between them.
  const double margin_m = std::max(printers_margin_m, board.square_m / 4);
  const Size needed{black.width_m + 2 * margin_m, black.height_m + 2 * margin_m + footer_m};
  if (board.square_m < least_square_m || std::max(needed.width_m, needed.height_m) > largest_page_m)
    throw InputError("--square", fmt::format("{}", board.square_m),
                     fmt::format("at least {} m, and a sheet of at most {:.2f} m (now {:.3g} x {:.3g} m)",
                                 least_square_m, largest_page_m, needed.width_m, needed.height_m));
  BoardSheet sheet{"", "a page of its own size", std::max(needed.width_m, ruler_step_m + 2 * margin_m),
                   needed.height_m};
  static constexpr Size portraits[] = {
      {0.210, 0.297}, {0.297, 0.420}, {0.420, 0.594}, {0.594, 0.841}, {0.841, 1.189}};
  for (int name = 4; name >= 0; --name) {
    const Size portrait = portraits[4 - name];
    const auto holds = [&](const Size& size) {
      return needed.width_m <= size.width_m && needed.height_m <= size.height_m;
    };
    const Size landscape{portrait.height_m, portrait.width_m};
    if (!holds(landscape) && !holds(portrait)) continue;
    const Size size = holds(landscape) ? landscape : portrait;
    sheet = {"", fmt::format("A{} {}", name, holds(landscape) ? "landscape" : "portrait"), size.width_m,
             size.height_m};
    break;
  }
  Page page(sheet.width_m, sheet.height_m);
  draw_board(page, board, (sheet.width_m - black.width_m) / 2,
             (sheet.height_m + footer_m + black.height_m) / 2);
  draw_footer(page, board, board_text, sheet.width_m);
  sheet.pdf = page.pdf();
  return sheet;
}

}  // namespace ballservo
