#include "app/report/html_text.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/report/markup_check.hpp"

namespace ballservo {
namespace {

TEST(HtmlEscape, LeavesNothingThatCouldBeMarkup) {
  EXPECT_EQ(html_escape("<script>alert('x' & \"y\")</script>"),
            "&lt;script&gt;alert(&#39;x&#39; &amp; &quot;y&quot;)&lt;/script&gt;");
}

TEST(HtmlEscape, KeepsOrdinaryTextAndUtf8) {
  const std::string text = "R = 0.07 m, 28\xc2\xb0, \xe2\x89\xa4 1 px, \xf0\x9f\x94\xb4\tnext\nline";
  EXPECT_EQ(html_escape(text), text);
}

TEST(HtmlEscape, ReplacesControlCharactersAndBrokenUtf8) {
  const std::string mark = "\xef\xbf\xbd";
  EXPECT_EQ(html_escape(std::string("a\0b", 3)), "a" + mark + "b");
  EXPECT_EQ(html_escape("\x1b[31m"), mark + "[31m");
  EXPECT_EQ(html_escape("\r\x7f"), mark + mark);
  EXPECT_EQ(html_escape("\xc2\x85"), mark);                               // C1 control
  EXPECT_EQ(html_escape("\xff"), mark);                                   // never in UTF-8
  EXPECT_EQ(html_escape("\xc0\xbc"), mark + mark);                        // overlong "<"
  EXPECT_EQ(html_escape("\xed\xa0\x80"), mark + mark + mark);             // a surrogate
  EXPECT_EQ(html_escape("\xe2\x89"), mark + mark);                        // cut short
  EXPECT_EQ(html_escape("\xf4\x90\x80\x80"), mark + mark + mark + mark);  // above U+10FFFF
  EXPECT_EQ(html_escape("\xef\xbf\xbf"), mark);                           // U+FFFF is no XML character
}

TEST(HtmlEscape, MakesAnyBytesSafeAsContentAndAsAttribute) {
  std::mt19937_64 engine(7);
  for (int round = 0; round < 2000; ++round) {
    std::string bytes(engine() % 40, '\0');
    for (char& c : bytes) c = static_cast<char>(engine() % 256);
    const std::string escaped = html_escape(bytes);
    EXPECT_EQ(test::markup_fault("<p title=\"" + escaped + "\">" + escaped + "</p>"), "");
    EXPECT_EQ(escaped.find_first_of("<>\"'"), std::string::npos);
  }
}

}  // namespace
}  // namespace ballservo
