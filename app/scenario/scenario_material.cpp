#include "app/scenario/scenario_material.hpp"

#include <string>
#include <vector>

namespace ballservo {

Rgb read_color(YamlNode& node, const Rgb& fallback, const std::string& suffix) {
  const std::string word_key = "color" + suffix, rgb_key = "rgb" + suffix;
  static const std::vector<std::string> words{"red",    "orange", "yellow", "green", "cyan", "blue",
                                              "purple", "pink",   "white",  "black", "grey", "brown"};
  if (node.has(word_key)) {
    if (node.has(rgb_key)) node.fault(rgb_key, "both " + word_key + " and " + rgb_key, "one of them");
    return *color_from_word(node.choice(word_key, words));
  }
  const std::vector<double> rgb = node.numbers(rgb_key, NumberRange::within(0, 1, ""), 3,
                                               std::vector<double>{fallback.x(), fallback.y(), fallback.z()});
  return {rgb[0], rgb[1], rgb[2]};
}

Material read_material(YamlNode& node, const Material& fallback) {
  Material material = fallback;
  const NumberRange share = NumberRange::within(0, 1, "");
  std::vector<std::string> patterns;
  for (const Pattern pattern : all_patterns) patterns.emplace_back(pattern_name(pattern));
  const std::string name =
      node.choice("pattern", patterns, std::string(pattern_name(fallback.texture.pattern)));
  for (const Pattern pattern : all_patterns) {
    if (pattern_name(pattern) == name) material.texture.pattern = pattern;
  }
  material.texture.color = read_color(node, fallback.texture.color);
  material.texture.color_2 = read_color(node, fallback.texture.color_2, "_2");
  material.texture.scale_m = node.number("scale_m", {0.01, 10, false, false, "m"}, fallback.texture.scale_m);
  material.specular = node.number("specular", share, fallback.specular);
  material.shininess = node.number("shininess", NumberRange::within(1, 1000, ""), fallback.shininess);
  return material;
}

}  // namespace ballservo
