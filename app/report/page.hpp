// One report as one HTML file: no script, nothing from the network, every text escaped.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/report/html_text.hpp"
#include "app/report/picture.hpp"
#include "app/report/svg.hpp"

namespace ballservo {

/// Rows of text under headings. Cells that are numbers stand right-aligned (`number_columns`, all but the
/// first when empty). Rows may be shorter than the heading.
struct PageTable {
  std::vector<std::string> heading;
  std::vector<std::vector<std::string>> rows;
  std::string caption;
  std::vector<bool> number_columns;
};

/// A drawing or picture with what it means.
struct PageFigure {
  std::string markup;  ///< made by `drawing` and `photo` below only
  std::string caption;
  bool wide = false;  ///< on a phone it keeps its size and is scrolled, and says so
};
PageFigure drawing(const Svg& svg, std::string caption);
/// `alternative` is said where the picture can't be seen. `width_px` 0: as large as the picture, at most the
/// page.
PageFigure photo(const cv::Mat& picture, std::string caption, PictureFormat format = PictureFormat::jpeg,
                 int width_px = 0);

/// A page that is filled from top to bottom. Well-formed as XML and as HTML 5, light and dark as the reader's
/// system is.
class Page {
 public:
  explicit Page(std::string title, std::string subtitle = "");

  void heading(std::string_view text, int level = 2);  ///< level 2 to 4
  void paragraph(std::string_view text);
  void note(std::string_view text);  ///< a paragraph set apart: the result, a warning
  void bullets(const std::vector<std::string>& items);
  void code(std::string_view text);
  void key_values(const std::vector<std::pair<std::string, std::string>>& rows);
  void table(const PageTable& table);
  void figure(const PageFigure& figure);
  /// Figures side by side where the window is wide enough; `small` ones four in a row.
  void figures(const std::vector<PageFigure>& figures, bool small = false);
  /// A link to a file beside the page. Throws std::invalid_argument for anything but a relative path.
  void link(std::string_view text, std::string_view relative_path, std::string_view remark = "");
  /// A player for a video file beside the page; the path as for `link`.
  void video(std::string_view relative_path, std::string_view caption);
  /// What follows is folded away under `summary` until `end_details`; they may be nested.
  void begin_details(std::string_view summary, bool open = false);
  void end_details();

  /// The whole file. Details that are still open are closed.
  std::string html() const;

 private:
  std::string title_, subtitle_, body_;
  int open_details_ = 0;
};

}  // namespace ballservo
