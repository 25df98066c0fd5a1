#include "calibration/camera/files/xml_element.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

constexpr int max_depth = 16;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
         c == '.' || c == ':' || static_cast<unsigned char>(c) >= 0x80;
}

class Parser {
 public:
  Parser(const std::string& text, const std::string& name) : text_(text), name_(name) {}

  XmlElement document() {
    if (starts_with("\xef\xbb\xbf")) at_ += 3;
    skip_between();
    if (at_ == text_.size()) fail("nothing", "an XML document");
    XmlElement root = element(1);
    skip_between();
    if (at_ != text_.size()) fail("text after the document's end", "nothing more");
    return root;
  }

 private:
  [[noreturn]] void fail(const std::string& found, const std::string& allowed) const {
    throw InputError(name_ + ":" + std::to_string(line()), found, allowed);
  }
  /// The line of the present position, counted on from the last time.
  int line() const {
    line_ += static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(counted_),
                                         text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n'));
    counted_ = at_;
    return line_;
  }
  bool starts_with(std::string_view what) const { return text_.compare(at_, what.size(), what) == 0; }

  void skip_past(std::string_view end, const std::string& what) {
    const auto found = text_.find(end, at_);
    if (found == std::string::npos) fail(what + " that does not end", std::string(end));
    at_ = found + end.size();
  }

  /// A comment or a processing instruction; false where there is none.
  bool skip_remark() {
    if (starts_with("<!--")) {
      skip_past("-->", "a comment");
      return true;
    }
    if (starts_with("<?")) {
      skip_past("?>", "an instruction");
      return true;
    }
    if (starts_with("<!")) fail("a document type or CDATA section", "elements, text and comments only");
    return false;
  }

  void skip_between() {
    while (at_ < text_.size()) {
      if (is_blank(text_[at_]))
        ++at_;
      else if (!skip_remark())
        return;
    }
  }

  std::string element_name() {
    const std::size_t start = at_;
    while (at_ < text_.size() && is_name_character(text_[at_])) ++at_;
    if (at_ == start) fail("no name after <", "an element");
    return text_.substr(start, at_ - start);
  }

  char character() {
    static constexpr std::array<std::pair<std::string_view, char>, 5> entities{
        {{"&lt;", '<'}, {"&gt;", '>'}, {"&amp;", '&'}, {"&quot;", '"'}, {"&apos;", '\''}}};
    if (text_[at_] != '&') {
      if (text_[at_] == '\0') fail("a zero byte", "text");
      return text_[at_++];
    }
    for (const auto& [entity, value] : entities) {
      if (!starts_with(entity)) continue;
      at_ += entity.size();
      return value;
    }
    fail("an entity of the file's own, or a bare &", "&lt; &gt; &amp; &quot; &apos;");
  }

  /// The rest of a start tag; true if the element is empty ("/>").
  bool end_of_start_tag() {
    char quote = 0;
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (quote) {
        if (c == quote) quote = 0;
      } else if (c == '"' || c == '\'') {
        quote = c;
      } else if (c == '<') {
        fail("< inside a tag", ">");
      } else if (c == '>') {
        ++at_;
        return text_[at_ - 2] == '/';
      }
    }
    fail("a tag that does not end", ">");
  }

  XmlElement element(int depth) {
    if (!starts_with("<")) fail("text outside any element", "an XML element");
    if (depth > max_depth) fail("elements nested too deep", "at most " + std::to_string(max_depth));
    XmlElement result;
    result.line = line();
    ++at_;
    result.name = element_name();
    if (end_of_start_tag()) return result;
    while (true) {
      if (at_ >= text_.size()) fail("the file's end inside <" + result.name + ">", "</" + result.name + ">");
      if (starts_with("</")) {
        at_ += 2;
        const std::string name = element_name();
        if (name != result.name) fail("</" + name + ">", "</" + result.name + ">");
        while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
        if (!starts_with(">")) fail("an end tag that does not end", ">");
        ++at_;
        break;
      }
      if (text_[at_] != '<')
        result.text += character();
      else if (!skip_remark())
        result.children.push_back(element(depth + 1));
    }
    while (!result.text.empty() && is_blank(result.text.back())) result.text.pop_back();
    result.text.erase(
        0, static_cast<std::size_t>(std::find_if_not(result.text.begin(), result.text.end(), is_blank) -
                                    result.text.begin()));
    return result;
  }

  const std::string& text_;
  const std::string& name_;
  std::size_t at_ = 0;
  mutable std::size_t counted_ = 0;
  mutable int line_ = 1;
};

}  // namespace

XmlElement parse_xml(const std::string& text, const std::string& name) {
  return Parser(text, name).document();
}

}  // namespace ballservo
