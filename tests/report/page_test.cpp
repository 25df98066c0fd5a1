#include "app/report/page.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "app/report/svg_canvas.hpp"
#include "app/report/svg_plot.hpp"
#include "tests/report/markup_check.hpp"

namespace ballservo {
namespace {

const std::string hostile = "\"><script>alert(1)</script>&'\x01 http";

Page full_page() {
  Page page(hostile, hostile);
  page.heading(hostile);
  page.heading(hostile, 99);
  page.paragraph(hostile);
  page.note(hostile);
  page.bullets({hostile, ""});
  page.code(hostile);
  page.key_values({{hostile, hostile}});
  page.table({{hostile, "b"}, {{hostile, "1"}, {"shorter"}, {}}, hostile, {true, false}});
  PlotOptions options;
  options.title = options.x.label = options.y.label = hostile;
  options.lines = {{false, 0.5, hostile}};
  page.figure(drawing(line_plot({{hostile, {0, 1}, {0, 1}}}, options), hostile));
  SvgCanvasOptions canvas_options;
  canvas_options.title = canvas_options.x_label = canvas_options.y_label = hostile;
  SvgCanvas canvas(canvas_options);
  canvas.text({0.5, 0.5}, hostile);
  page.figures({drawing(canvas.svg(), hostile),
                drawing(bar_plot({hostile}, {{hostile, {1}}}, options), hostile),
                photo(cv::Mat(8, 8, CV_8UC3, cv::Scalar(10, 200, 30)), hostile, PictureFormat::png)});
  page.video("a video.mp4", hostile);
  page.link(hostile, "folder/log.csv", hostile);
  page.begin_details(hostile);
  page.begin_details("inner", true);
  page.paragraph("within");
  return page;
}

TEST(Page, IsWellFormedWhateverTheTexts) { EXPECT_EQ(test::markup_fault(full_page().html()), ""); }

// On a phone it is scrolled, with a hint; narrower drawings are scaled.
TEST(Page, MarksDrawingsThatAreWiderThanAPhone) {
  PlotOptions options;
  const auto markup = [&](int width_px) {
    options.width_px = width_px;
    Page page("title");
    page.figure(drawing(line_plot({{"a", {0, 1}, {0, 1}}}, options), "plot"));
    return page.html();
  };
  EXPECT_EQ(test::occurrences(markup(480), "<figure class=\"wide\">"), 0);
  EXPECT_EQ(test::occurrences(markup(640), "<figure class=\"wide\">"), 1);
}

TEST(Page, NeverTurnsTextIntoMarkup) {
  const std::string html = full_page().html();
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_EQ(html.find('\x01'), std::string::npos);
}

TEST(Page, LoadsNothingFromTheNetwork) {
  Page page("title");
  page.figure(drawing(line_plot({{"a", {0, 1}, {0, 1}}}, {}), "plot"));
  page.figure(photo(cv::Mat(8, 8, CV_8UC3, cv::Scalar(10, 200, 30)), "photo"));
  page.link("log", "log.csv");
  const std::string html = page.html();
  for (const std::string_view loader : {"http", "@import", "url(", "<script", "<link", "<iframe"}) {
    EXPECT_EQ(test::occurrences(html, loader), 0) << loader;
  }
  // Base 64 may hold two slashes; nothing else may.
  std::string without_pictures = html;
  for (std::size_t at; (at = without_pictures.find("data:image")) != std::string::npos;) {
    without_pictures.erase(at, without_pictures.find('"', at) - at);
  }
  EXPECT_EQ(test::occurrences(without_pictures, "//"), 0);
}

TEST(Page, LinksToRelativePathsOnly) {
  Page page("title");
  for (const std::string path : {"", "/etc/passwd", "../secret", "a/../../b", "\\\\host\\share"}) {
    EXPECT_THROW(page.link("x", path), std::invalid_argument) << path;
    EXPECT_THROW(page.video(path, "x"), std::invalid_argument) << path;
  }
  page.link("x", "javascript:alert(1)");
  EXPECT_NE(page.html().find("javascript%3Aalert%281%29"), std::string::npos);
  EXPECT_EQ(page.html().find("javascript:"), std::string::npos);
}

TEST(Page, ClosesDetailsThatStayOpenAndOnlyThose) {
  Page page("title");
  page.end_details();
  page.begin_details("one");
  EXPECT_EQ(test::markup_fault(page.html()), "");
  page.end_details();
  page.end_details();
  EXPECT_EQ(test::markup_fault(page.html()), "");
  EXPECT_EQ(test::occurrences(page.html(), "</details>"), 1);
}

TEST(Page, AnEmptyOneIsStillAPage) {
  const std::string html = Page("").html();
  EXPECT_EQ(test::markup_fault(html), "");
  EXPECT_EQ(html.rfind("<!DOCTYPE html>", 0), 0u);
}

}  // namespace
}  // namespace ballservo
