#include "perception/color_lookup.hpp"

#include <algorithm>
#include <utility>

#include "calibration/files/fault.hpp"
#include "perception/color_boxes.hpp"

namespace ballservo {
namespace {

void check(const ColorTable& colors) {
  FaultList faults;
  const std::string list = std::to_string(colors.classes.size()) + " classes";
  if (colors.classes.size() > max_classes) faults.add("classes", list, "15 at most");
  if (colors.table.size() != ColorTable::entries) {
    faults.add("table", std::to_string(colors.table.size()) + " entries", "64 x 64 x 64");
  } else if (const int top = *std::max_element(colors.table.begin(), colors.table.end());
             top > static_cast<int>(colors.classes.size())) {
    faults.add("table", "class " + std::to_string(top), "one of its " + list);
  }
  faults.throw_if_any();
}

BoxTables tables_of(const std::vector<ColorBox>& boxes) {
  BoxTables tables;
  unsigned bit = 1;
  for (const ColorBox& box : boxes) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t cell = box.low[c]; cell <= box.high[c]; ++cell)
        tables.bits[c][cell] = static_cast<std::uint8_t>(tables.bits[c][cell] | bit);
    }
    bit <<= 1;
  }
  return tables;
}

}  // namespace

LightCells LightCells::as_taught() {
  LightCells light;
  for (auto& channel : light.taught_cell) {
    for (std::size_t cell = 0; cell < channel.size(); ++cell) channel[cell] = static_cast<std::uint8_t>(cell);
  }
  return light;
}

ColorLookup::ColorLookup(std::shared_ptr<const ColorTable> colors) : colors_(std::move(colors)) {
  check(*colors_);
  entries_ = colors_->table.data();
  constexpr int bits = 8;
  const std::vector<ColorBox> inner = inner_boxes(*colors_, bits);
  taught_boxes_.outer = tables_of(outer_boxes(*colors_, bits));
  taught_boxes_.inner = tables_of(inner);
  taught_boxes_.classes = classes();
  for (std::size_t i = 0; i < inner.size(); ++i) {
    std::uint8_t& own = taught_boxes_.inner_of_class[inner[i].color_class - 1];
    own = static_cast<std::uint8_t>(own | (1u << i));
  }
  set_light(LightCells::as_taught());
}

void ColorLookup::set_light(const LightCells& light) {
  constexpr std::size_t levels = 256 / ColorTable::side;
  boxes_ = taught_boxes_;
  unsigned holds_dark = 255;  // the inner boxes that hold a dark colour
  for (std::size_t c = 0; c < 3; ++c) {
    unsigned in_channel = 0;
    for (std::size_t cell = 0; cell < ColorTable::side; ++cell) {
      const std::size_t taught = light.taught_cell[c][cell];
      std::fill_n(&offset_[c][levels * cell], levels, static_cast<std::uint32_t>(taught << (6 * c)));
      boxes_.inner.bits[c][cell] = taught_boxes_.inner.bits[c][taught];
      // A dark cell is looked up at itself or elsewhere, as the other channels say: it must pass for both.
      const bool dark = cell < LightCells::dark;
      const unsigned itself = dark ? taught_boxes_.outer.bits[c][cell] : 0u;
      boxes_.outer.bits[c][cell] = static_cast<std::uint8_t>(taught_boxes_.outer.bits[c][taught] | itself);
      if (dark) in_channel |= boxes_.inner.bits[c][cell];
    }
    holds_dark &= in_channel;
  }
  // And is sure of neither.
  for (std::size_t cell = 0; cell < LightCells::dark; ++cell)
    boxes_.inner.bits[0][cell] = static_cast<std::uint8_t>(boxes_.inner.bits[0][cell] & ~holds_dark);
}

}  // namespace ballservo
