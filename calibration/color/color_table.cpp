#include "calibration/color/color_table.hpp"

namespace ballservo {

std::optional<ClassIndex> ColorTable::find(const std::string& name) const {
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (classes[i].name == name) return static_cast<ClassIndex>(i + 1);
  }
  return {};
}

}  // namespace ballservo
