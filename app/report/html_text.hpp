// The one function through which every text reaches a page.
#pragma once

#include <string>
#include <string_view>

namespace ballservo {

/// `text` made harmless as content and as a quoted attribute of HTML, XHTML and SVG: & < > " ' become
/// character references; control characters (tab and line feed apart) and bytes that are not UTF-8 become
/// U+FFFD, because XML has no way to hold them.
std::string html_escape(std::string_view text);

}  // namespace ballservo
