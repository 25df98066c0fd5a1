// The little of XML that camera files need, read by libxml2: elements and text. Document types are refused,
// and with them entities of a file's own (a small file could unfold without bound).
#pragma once

#include <string>
#include <vector>

namespace ballservo {

struct XmlElement {
  std::string name;
  std::string text;  ///< of the element itself, entities replaced, surrounding blanks removed
  int line = 0;      ///< of its start tag, from 1
  std::vector<XmlElement> children;
};

/// The root element. InputError (with line) for what is not well-formed or nested deeper than 16. `name`
/// stands for the file. Attributes are passed over.
XmlElement parse_xml(const std::string& text, const std::string& name);

}  // namespace ballservo
