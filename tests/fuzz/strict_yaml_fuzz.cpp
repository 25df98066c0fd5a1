// Strict YAML by itself: everything that a reader may ask of any document, and `--set`.
#include "calibration/base/fault.hpp"
#include "calibration/base/strict_yaml.hpp"
#include "tests/fuzz/fuzz_folder.hpp"

using namespace ballservo;

namespace {

void visit(YamlNode node, int depth) {
  int kind = depth;
  for (const std::string& key : node.keys()) {
    switch (kind++ % 7) {
      case 0:
        node.number(key, NumberRange::above(0, "m"));
        break;
      case 1:
        node.integer(key, -3, 1000000, 1);
        break;
      case 2:
        node.text(key, "");
        break;
      case 3:
        node.numbers(key, NumberRange::any(""), 3);
        break;
      case 4:
        for (YamlNode item : node.list(key)) {
          visit(item, depth + 1);
          item.as_text();
        }
        break;
      case 5:
        visit(node.map(key, false), depth + 1);
        break;
      default:
        node.leave_aside(key);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text = fuzz::text_of(data + 1, size - 1);
  try {
    StrictYaml yaml =
        StrictYaml::from_text(text, "fuzz.yaml", data[0] & 1 ? YamlTags::opencv : YamlTags::refused);
    if (data[0] & 2) {
      const std::size_t end = std::min(text.find('\n'), text.size()), equals = text.find('=');
      if (equals < end) yaml.set(text.substr(0, equals), text.substr(equals + 1, end - equals - 1));
    }
    yaml.resolved_json();
    visit(yaml.root(), data[0] >> 2);
    yaml.finish();
  } catch (const InputError&) {
  }
  return 0;
}
