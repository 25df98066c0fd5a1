#include "calibration/teaching/merge_colors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "calibration/base/fault.hpp"
#include "calibration/teaching/class_table.hpp"

namespace ballservo {
namespace {

constexpr double same_class_share = 1.0 / 3;

/// The second one rounded.
std::uint32_t capped_sum(std::uint32_t a, double b) {
  return static_cast<std::uint32_t>(
      std::min<std::int64_t>(a + std::llround(b), std::numeric_limits<std::uint32_t>::max()));
}

/// `a`, and that part of `b`'s counts, rounded.
OccupiedCells sum_of(const OccupiedCells& a, const OccupiedCells& b, double part = 1) {
  CellCounts counts = all_counts(a);
  for (const CellCount& cell : b) counts[cell.cell] = capped_sum(counts[cell.cell], part * cell.count);
  return occupied(counts);
}

std::uint64_t total_of(const OccupiedCells& cells) {
  std::uint64_t total = 0;
  for (const CellCount& cell : cells) total += cell.count;
  return total;
}

/// Adds a part of `other`'s counts.
void unite(ColorClass& into, const ColorClass& other, double part) {
  into.samples += other.samples;
  for (std::size_t i = 0; i < into.histogram.counts.size(); ++i) {
    std::uint32_t& count = into.histogram.counts[i];
    count = capped_sum(count, part * other.histogram.counts[i]);
  }
  into.cells = sum_of(into.cells, other.cells, part);
}

/// All tables' classes of that name as one. A table is made from densities, so that what a lesson of one
/// picture says must not drown in one of a video: none counts more than three times the smallest.
ColorClass united(const std::string& name, const std::vector<ColorTable>& tables) {
  constexpr double most_weight = 3;
  ColorClass result;
  result.name = name;
  std::uint64_t smallest = std::numeric_limits<std::uint64_t>::max();
  for (const ColorTable& table : tables) {
    for (const ColorClass& color : table.classes) {
      if (color.name == name && !color.cells.empty()) smallest = std::min(smallest, total_of(color.cells));
    }
  }
  for (const ColorTable& table : tables) {
    for (const ColorClass& color : table.classes) {
      if (color.name != name) continue;
      const auto total = static_cast<double>(std::max<std::uint64_t>(1, total_of(color.cells)));
      unite(result, color, std::min(1.0, most_weight * static_cast<double>(smallest) / total));
    }
  }
  return result;
}

/// The part of a class's pixels that a table gives to any class.
double kept(const ColorClass& color, const ColorTable& table) {
  const std::vector<double> pixels = pixels_of_classes(color.cells, table);
  const double all = std::accumulate(pixels.begin(), pixels.end(), 0.0);
  return all > 0 ? (all - pixels[no_class]) / all : 1;
}

/// One class is one connected group of chromas: what was taught under one name must be one colour.
void refuse_lost_colors(const std::vector<ColorTable>& tables, const ColorTable& merged) {
  constexpr double least_kept = 0.5;
  std::string lost;
  for (std::size_t i = 0; i < tables.size(); ++i) {
    for (const ColorClass& color : tables[i].classes) {
      const double now = kept(color, merged), before = kept(color, tables[i]);
      if (now >= least_kept * before) continue;
      lost +=
          fmt::format("\n  {} of number {} of {}, in the order given: {:.0f} % of its pixels would be left",
                      color.name, i + 1, tables.size(), 100 * now);
    }
  }
  if (lost.empty()) return;
  throw Refusal(
      "what is to be merged does not go together; where two things of one name have different colours, give "
      "one of them another name (--class NAME=IMAGE):" +
      lost);
}

}  // namespace

ColorTable merge_colors(const std::vector<ColorTable>& tables) {
  ColorTable result;
  for (const ColorTable& table : tables) {
    for (const ColorClass& color : table.classes) {
      if (color.samples > 0 && color.cells.empty()) {
        throw Refusal(
            fmt::format("class {} comes without the pixels that it was learnt from; learn it again from "
                        "its pictures",
                        color.name));
      }
      if (!result.find(color.name)) result.classes.push_back(united(color.name, tables));
    }
    result.background = sum_of(result.background, table.background);
    for (auto setting = result.camera_settings.begin(); setting != result.camera_settings.end();) {
      const auto other = table.camera_settings.find(setting->first);
      const bool agrees = other != table.camera_settings.end() && other->second == setting->second;
      setting = agrees ? std::next(setting) : result.camera_settings.erase(setting);
    }
    if (&table == &tables.front()) result.camera_settings = table.camera_settings;
  }
  if (result.classes.size() > max_classes) {
    throw Refusal(fmt::format("together that is {} classes; a colours file holds {}", result.classes.size(),
                              max_classes));
  }
  rebuild(result);
  refuse_lost_colors(tables, result);
  return result;
}

std::vector<std::string> names_to_join(const ColorTable& learnt, const ColorTable& base) {
  std::set<std::string> used;
  std::vector<std::vector<float>> densities;
  for (const ColorClass& color : base.classes) {
    used.insert(color.name);
    densities.push_back(lab_density(color.cells));
  }
  std::vector<std::string> names;
  for (const ColorClass& color : learnt.classes) {
    const std::vector<float> density = lab_density(color.cells);
    std::string name;
    double most = same_class_share;
    for (std::size_t k = 0; k < densities.size(); ++k) {
      const double shared = common_area(density, densities[k]);
      if (shared >= most) name = base.classes[k].name, most = shared;
    }
    const std::string word = color.name.substr(0, color.name.find('_'));
    if (name.empty()) {
      name = word;
      for (int n = 2; !used.insert(name).second; ++n) name = fmt::format("{}_{}", word, n);
    }
    names.push_back(name);
  }
  return names;
}

}  // namespace ballservo
