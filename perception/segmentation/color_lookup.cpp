#include "perception/segmentation/color_lookup.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "calibration/base/fault.hpp"
#include "perception/segmentation/color_boxes.hpp"

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

CellBits bits_of(const std::vector<ColorBox>& boxes) {
  CellBits bits{};
  unsigned bit = 1;
  for (const ColorBox& box : boxes) {
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t cell = box.low[c]; cell <= box.high[c]; ++cell)
        bits[c][cell] = static_cast<std::uint8_t>(bits[c][cell] | bit);
    }
    bit <<= 1;
  }
  return bits;
}

// For every two cells, so that they are safe for both.
template <class Join>
BoxTables pairs(const CellBits& bits, const Join& join) {
  BoxTables tables;
  constexpr std::size_t entries = ColorTable::side / 2;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < entries; ++i) {
      tables.bits[c][i] = static_cast<std::uint8_t>(join(bits[c][2 * i], bits[c][2 * i + 1]));
    }
  }
  return tables;
}

}  // namespace

LightCells LightCells::as_taught() {
  LightCells light;
  for (auto& channel : light.taught_cell) std::iota(channel.begin(), channel.end(), std::uint8_t{0});
  return light;
}

ColorLookup::ColorLookup(std::shared_ptr<const ColorTable> colors) : colors_(std::move(colors)) {
  check(*colors_);
  entries_ = colors_->table.data();
  constexpr int bits = 8;
  const std::vector<ColorBox> inner = inner_boxes(*colors_, bits);
  taught_outer_ = bits_of(outer_boxes(*colors_, bits));
  taught_inner_ = bits_of(inner);
  boxes_.classes = classes();
  for (std::size_t i = 0; i < inner.size(); ++i) {
    std::uint8_t& own = boxes_.inner_of_class[inner[i].color_class - 1];
    own = static_cast<std::uint8_t>(own | (1u << i));
  }
  set_light(LightCells::as_taught());
}

void ColorLookup::set_light(const LightCells& light) {
  constexpr std::size_t levels = 256 / ColorTable::side, dark = LightCells::dark;
  CellBits outer, inner;
  unsigned holds_dark = 255;  // the inner boxes that hold a dark colour
  for (std::size_t c = 0; c < 3; ++c) {
    unsigned in_channel = 0;
    for (std::size_t cell = 0; cell < ColorTable::side; ++cell) {
      const std::size_t taught = light.taught_cell[c][cell];
      std::fill_n(&offset_[c][levels * cell], levels, static_cast<std::uint32_t>(taught << (6 * c)));
      inner[c][cell] = taught_inner_[c][taught];
      outer[c][cell] = taught_outer_[c][taught];
      if (cell >= dark) continue;
      // A dark cell is looked up at itself or elsewhere, by the other channels: it may be in either's box.
      outer[c][cell] = static_cast<std::uint8_t>(outer[c][cell] | taught_outer_[c][cell]);
      in_channel |= inner[c][cell];
    }
    holds_dark &= in_channel;
  }
  // And is surely in none.
  for (std::size_t cell = 0; cell < dark; ++cell)
    inner[0][cell] = static_cast<std::uint8_t>(inner[0][cell] & ~holds_dark);
  boxes_.outer = pairs(outer, [](unsigned a, unsigned b) { return a | b; });
  boxes_.inner = pairs(inner, [](unsigned a, unsigned b) { return a & b; });
}

}  // namespace ballservo
