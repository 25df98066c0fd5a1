// Colours and surfaces in scenarios.
#pragma once

#include <string>

#include "calibration/base/strict_yaml.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// A colour by its word (`color: red`) or its reflectances (`rgb: [0.7, 0.05, 0.03]`), the keys with this
/// suffix; the fallback where there is neither.
Rgb read_color(YamlNode& node, const Rgb& fallback, const std::string& suffix = "");

/// `color`, `color_2`, `pattern`, `scale_m`, `specular` and `shininess`, each as the fallback's where it is
/// missing.
Material read_material(YamlNode& node, const Material& fallback);

}  // namespace ballservo
