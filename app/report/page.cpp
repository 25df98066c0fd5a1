#include "app/report/page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace ballservo {
namespace {

constexpr std::string_view style_sheet = R"(
:root { color-scheme: light dark; --paper: #fdfdfc; --ink: #1d2126; --faint: #5d6670; --line: #d9dde1; --panel: #f2f4f5; --accent: #0072b2; }
@media (prefers-color-scheme: dark) { :root { --paper: #16191d; --ink: #e3e6e9; --faint: #9aa4ad; --line: #343b42; --panel: #1f2429; --accent: #56b4e9; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.25rem 4rem; max-width: 68rem; background: var(--paper); color: var(--ink); font: 16px/1.55 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .3rem; }
h2 { font-size: 1.35rem; margin: 2.4rem 0 .6rem; padding-top: .8rem; border-top: 1px solid var(--line); }
h3 { font-size: 1.1rem; margin: 1.6rem 0 .4rem; }
h4 { font-size: 1rem; margin: 1.2rem 0 .3rem; }
p, ul { max-width: 46rem; margin: .6rem 0; }
.subtitle { color: var(--faint); margin: 0 0 1.2rem; }
.note { border-left: 4px solid var(--accent); background: var(--panel); padding: .7rem 1rem; border-radius: 0 6px 6px 0; max-width: 48rem; }
.scroll { overflow-x: auto; margin: .8rem 0 1.2rem; }
table { border-collapse: collapse; font-size: .92rem; }
caption { text-align: left; color: var(--faint); padding: 0 0 .4rem; }
th, td { padding: .28rem .6rem; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
thead th { border-bottom: 2px solid var(--faint); vertical-align: bottom; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; }
td.number { white-space: nowrap; }
table.keys th { font-weight: 500; color: var(--faint); }
figure { margin: 1rem 0 1.4rem; }
figure svg, figure img, figure video { max-width: 100%; height: auto; display: block; }
figure img, figure video { border-radius: 4px; }
figcaption { color: var(--faint); font-size: .9rem; max-width: 46rem; margin-top: .4rem; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr)); gap: 0 1.4rem; align-items: start; }
.figures.small { grid-template-columns: repeat(auto-fit, minmax(min(100%, 13rem), 1fr)); }
pre { background: var(--panel); padding: .7rem 1rem; border-radius: 6px; overflow-x: auto; font: .88rem/1.45 ui-monospace, "DejaVu Sans Mono", monospace; }
a { color: var(--accent); }
@media (max-width: 40rem) { figure.wide { overflow-x: auto; } figure.wide svg { min-width: 32rem; } figure.wide::before, .scroll.wide::before { content: "\2194  wider than the screen: scroll sideways"; color: var(--faint); font-size: .85rem; position: sticky; left: 0; } }
details { margin: 1rem 0; border: 1px solid var(--line); border-radius: 6px; padding: .4rem .9rem; }
summary { cursor: pointer; font-weight: 600; }
)";

bool is_number_column(const PageTable& table, std::size_t column) {
  if (table.number_columns.empty()) return column > 0;
  return column < table.number_columns.size() && table.number_columns[column];
}

std::string table_cells(const PageTable& table, const std::vector<std::string>& cells, std::string_view tag) {
  std::string row = "<tr>";
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const char* number = is_number_column(table, k) ? " class=\"number\"" : "";
    row += fmt::format("<{0}{1}>{2}</{0}>", tag, number, html_escape(cells[k]));
  }
  return row + "</tr>\n";
}

// Percent-encodes what a path may hold but an URL may not; a scheme, a host or an absolute path is refused.
std::string relative_url(std::string_view path) {
  const bool absolute = path.empty() || path.front() == '/' || path.front() == '\\';
  if (absolute || path.find("..") == 0 || path.find("/../") != std::string_view::npos) {
    throw std::invalid_argument(fmt::format("a page links to files beside it only, not to '{}'", path));
  }
  std::string url;
  for (const char c : path) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '/' || c == '.' || c == '-' || c == '_' || c == '~';
    url += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return url;
}

std::string figure_markup(const PageFigure& figure) {
  std::string markup = (figure.wide ? "<figure class=\"wide\">\n" : "<figure>\n") + figure.markup;
  if (!figure.caption.empty())
    markup += fmt::format("<figcaption>{}</figcaption>\n", html_escape(figure.caption));
  return markup + "</figure>\n";
}

}  // namespace

PageFigure drawing(const Svg& svg, std::string caption) {
  constexpr int phone_px = 520;  // a drawing that is no wider can still be read when it is scaled to a phone
  return {svg.markup(), std::move(caption), svg.width_px() > phone_px};
}

PageFigure photo(const cv::Mat& picture, std::string caption, PictureFormat format, int width_px) {
  const int width = width_px > 0 ? width_px : picture.cols;
  std::string markup = fmt::format("<img src=\"{}\" alt=\"{}\" width=\"{}\"/>\n",
                                   picture_data_uri(picture, format), html_escape(caption), width);
  return {std::move(markup), std::move(caption), false};
}

Page::Page(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

void Page::heading(std::string_view text, int level) {
  body_ += fmt::format("<h{0}>{1}</h{0}>\n", std::clamp(level, 2, 4), html_escape(text));
}

void Page::paragraph(std::string_view text) { body_ += fmt::format("<p>{}</p>\n", html_escape(text)); }

void Page::note(std::string_view text) {
  body_ += fmt::format("<p class=\"note\">{}</p>\n", html_escape(text));
}

void Page::bullets(const std::vector<std::string>& items) {
  if (items.empty()) return;
  body_ += "<ul>\n";
  for (const std::string& item : items) body_ += fmt::format("<li>{}</li>\n", html_escape(item));
  body_ += "</ul>\n";
}

void Page::code(std::string_view text) { body_ += fmt::format("<pre>{}</pre>\n", html_escape(text)); }

void Page::key_values(const std::vector<std::pair<std::string, std::string>>& rows) {
  if (rows.empty()) return;
  body_ += "<div class=\"scroll\"><table class=\"keys\"><tbody>\n";
  for (const auto& [key, value] : rows) {
    body_ +=
        fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", html_escape(key), html_escape(value));
  }
  body_ += "</tbody></table></div>\n";
}

void Page::table(const PageTable& table) {
  constexpr std::size_t columns_of_a_phone = 4;
  body_ += table.heading.size() > columns_of_a_phone ? "<div class=\"scroll wide\"><table>\n"
                                                     : "<div class=\"scroll\"><table>\n";
  if (!table.caption.empty()) body_ += fmt::format("<caption>{}</caption>\n", html_escape(table.caption));
  if (!table.heading.empty()) body_ += "<thead>" + table_cells(table, table.heading, "th") + "</thead>\n";
  body_ += "<tbody>\n";
  for (const std::vector<std::string>& row : table.rows) body_ += table_cells(table, row, "td");
  body_ += "</tbody></table></div>\n";
}

void Page::figure(const PageFigure& figure) { body_ += figure_markup(figure); }

void Page::figures(const std::vector<PageFigure>& figures, bool small) {
  if (figures.empty()) return;
  body_ += small ? "<div class=\"figures small\">\n" : "<div class=\"figures\">\n";
  for (const PageFigure& figure : figures) body_ += figure_markup(figure);
  body_ += "</div>\n";
}

void Page::link(std::string_view text, std::string_view relative_path, std::string_view remark) {
  body_ += fmt::format("<p><a href=\"{}\">{}</a>{}{}</p>\n", html_escape(relative_url(relative_path)),
                       html_escape(text), remark.empty() ? "" : " ", html_escape(remark));
}

void Page::video(std::string_view relative_path, std::string_view caption) {
  body_ += fmt::format(
      "<figure>\n<video controls=\"controls\" preload=\"metadata\" "
      "src=\"{}\"></video>\n<figcaption>{}</figcaption>\n"
      "</figure>\n",
      html_escape(relative_url(relative_path)), html_escape(caption));
}

void Page::begin_details(std::string_view summary, bool open) {
  body_ +=
      fmt::format("<details{}>\n<summary>{}</summary>\n", open ? " open=\"open\"" : "", html_escape(summary));
  ++open_details_;
}

void Page::end_details() {
  if (open_details_ == 0) return;
  body_ += "</details>\n";
  --open_details_;
}

std::string Page::html() const {
  std::string closing;
  for (int k = 0; k < open_details_; ++k) closing += "</details>\n";
  const std::string subtitle =
      subtitle_.empty() ? "" : fmt::format("<p class=\"subtitle\">{}</p>\n", html_escape(subtitle_));
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{0}</title>\n"
      "<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n{2}{3}{4}</body>\n</html>\n",
      html_escape(title_), style_sheet, subtitle, body_, closing);
}

}  // namespace ballservo
