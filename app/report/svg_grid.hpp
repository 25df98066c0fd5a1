// Several drawings as one.
#pragma once

#include <string>
#include <vector>

#include "app/report/svg.hpp"

namespace ballservo {

/// Row by row, `columns` (1 at least) in each, every cell as large as the largest drawing. `label` is what a
/// screen reader says.
Svg svg_grid(const std::vector<Svg>& drawings, int columns, const std::string& label);

}  // namespace ballservo
