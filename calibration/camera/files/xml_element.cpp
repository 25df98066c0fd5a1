#include "calibration/camera/files/xml_element.hpp"

#include <libxml/parser.h>
#include <libxml/tree.h>

#include <memory>
#include <string_view>

#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

constexpr int max_depth = 16;

std::string without_blanks_around(std::string_view text) {
  const auto start = text.find_first_not_of(" \t\r\n");
  if (start == std::string_view::npos) return "";
  return std::string(text.substr(start, text.find_last_not_of(" \t\r\n") - start + 1));
}

std::string line_of(const std::string& name, long line) { return name + ":" + std::to_string(line); }

XmlElement element_of(xmlNode* node, const std::string& name, int depth) {
  XmlElement result;
  result.name = reinterpret_cast<const char*>(node->name);
  result.line = static_cast<int>(xmlGetLineNo(node));
  if (depth > max_depth)
    throw InputError(line_of(name, result.line), "elements nested too deep",
                     "at most " + std::to_string(max_depth));
  for (xmlNode* child = node->children; child; child = child->next) {
    if (child->type == XML_ELEMENT_NODE) result.children.push_back(element_of(child, name, depth + 1));
    if (child->type == XML_TEXT_NODE || child->type == XML_CDATA_SECTION_NODE)
      result.text += reinterpret_cast<const char*>(child->content);
  }
  result.text = without_blanks_around(result.text);
  return result;
}

}  // namespace

XmlElement parse_xml(const std::string& text, const std::string& name) {
  const std::unique_ptr<xmlParserCtxt, void (*)(xmlParserCtxt*)> parser(xmlNewParserCtxt(),
                                                                        xmlFreeParserCtxt);
  const std::unique_ptr<xmlDoc, void (*)(xmlDoc*)> document(
      xmlCtxtReadMemory(parser.get(), text.data(), static_cast<int>(text.size()), name.c_str(), nullptr,
                        XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING),
      xmlFreeDoc);
  if (!document) {
    const xmlError* error = xmlCtxtGetLastError(parser.get());
    const std::string found = error && error->message ? without_blanks_around(error->message) : "no XML";
    throw InputError(line_of(name, error ? error->line : 1), found, "a well-formed XML document");
  }
  if (document->intSubset) throw InputError(name, "a document type", "elements, text and comments only");
  return element_of(xmlDocGetRootElement(document.get()), name, 1);
}

}  // namespace ballservo
