// The file is text, so that it can be read, compared and kept under version control:
//
//     ballservo colors
//     version 2
//     sha256 <of every byte after this line>
//     settings 1                  of the camera, where known: name, value
//     exposure 156
//     classes 2
//     class red 5310 207 640      name, samples, occupied cells of the histogram and of the table, which
//     follow: 87 76 12                    column (of a), row (of b), count; cells in rising order
//     ...
//     231122 4                    cell of the table, count; cells in rising order
//     ...
//     background 17320            occupied cells of the table, as above
//     ...
//     table 4192                  runs of equal entries in the order of ColorTable: length, class number
//     51234 0
//     ...
//     end
#include "calibration/color/color_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <stdexcept>
#include <vector>

#include "calibration/base/checksum.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/system_file.hpp"

namespace ballservo {
namespace {

constexpr std::string_view magic = "ballservo colors";
constexpr std::uint64_t max_settings = 64;
constexpr std::uint64_t max_samples = std::uint64_t{1} << 53;  // exact in JSON's and everybody's doubles

/// What a message may show of a hostile file: short, printable.
std::string shown(std::string_view text) {
  std::string result = "\"";
  for (const char c : text.substr(0, 40)) result += c >= 0x20 && c < 0x7f ? c : '?';
  return result + (text.size() > 40 ? "...\"" : "\"");
}

/// Walks over the lines of a file and complains with their numbers.
class Lines {
 public:
  Lines(std::string_view bytes, const std::string& place) : rest_(bytes), place_(place) {}

  /// The next line, without its end; every line must have one.
  std::string_view next(const char* wanted) {
    const auto end = rest_.find('\n');
    if (end == std::string_view::npos) {
      throw InputError(fmt::format("{}:{}", place_, line_ + 1),
                       rest_.empty() ? "the end of the file" : "a cut line", wanted);
    }
    current_ = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    ++line_;
    return current_;
  }

  std::string_view rest() const { return rest_; }

  [[noreturn]] void fail(const std::string& allowed) const { fail(shown(current_), allowed); }
  [[noreturn]] void fail(const std::string& found, const std::string& allowed) const {
    throw InputError(fmt::format("{}:{}", place_, line_), found, allowed);
  }

  /// The words of the next line: exactly `count`, separated by single spaces, the first being `key` unless
  /// empty.
  std::vector<std::string_view> words(std::string_view key, std::size_t count, const char* wanted) {
    std::string_view line = next(wanted);
    std::vector<std::string_view> result;
    while (result.size() <= count) {
      const auto space = line.find(' ');
      result.push_back(line.substr(0, space));
      if (space == std::string_view::npos) break;
      line.remove_prefix(space + 1);
    }
    if (result.size() != count || (!key.empty() && result[0] != key)) fail(wanted);
    return result;
  }

  /// The number of a line "KEY NUMBER", named `what` in messages.
  std::uint64_t number_of(std::string_view key, const char* wanted, std::uint64_t low, std::uint64_t high,
                          const char* what) {
    return number(words(key, 2, wanted)[1], low, high, what);
  }

  std::uint64_t number(std::string_view word, std::uint64_t low, std::uint64_t high, const char* what) const {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || value < low || value > high) {
      fail(shown(word), fmt::format("{}: a whole number from {} to {}", what, low, high));
    }
    return value;
  }

 private:
  std::string_view rest_, current_;
  std::string place_;
  long line_ = 0;
};

/// The words of lines that count cells of some table, and what their message says of them.
struct CellLines {
  const char* wanted;
  const char* order;
  std::size_t words;
};

/// `count` such lines, whose cells (`cell_of(words)`) rise and whose pixels come to at most `limit`.
template <class CellOf>
OccupiedCells parse_counts(Lines& lines, const CellLines& kind, std::uint64_t count, std::uint64_t limit,
                           const std::string& allowed, const CellOf& cell_of) {
  OccupiedCells result;
  std::uint64_t next = 0, total = 0;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto words = lines.words("", kind.words, kind.wanted);
    const std::uint64_t cell = cell_of(words);
    const std::uint64_t pixels =
        lines.number(words.back(), 1, std::numeric_limits<std::uint32_t>::max(), "count");
    if (cell < next) lines.fail(kind.order);
    next = cell + 1;
    total += pixels;
    if (total > limit) lines.fail(fmt::format("{} counted so far", total), allowed);
    result.push_back({static_cast<std::uint32_t>(cell), static_cast<std::uint32_t>(pixels)});
  }
  return result;
}

/// `count` lines of a table's cell and its count, which come to at most `limit`.
OccupiedCells parse_cells(Lines& lines, std::uint64_t count, std::uint64_t limit) {
  return parse_counts(lines, {"CELL COUNT of a cell of the table", "cells in rising order, each once", 2},
                      count, limit, fmt::format("at most {}", limit), [&](const auto& words) {
                        return lines.number(words[0], 0, ColorTable::entries - 1, "cell");
                      });
}

std::map<std::string, double> parse_settings(Lines& lines) {
  std::map<std::string, double> result;
  const std::uint64_t count = lines.number_of("settings", "settings COUNT", 0, max_settings, "settings");
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto words = lines.words("", 2, "NAME VALUE of a camera setting");
    const auto value = parse_number(words[1]);
    if (!is_class_name(words[0]) || !value) lines.fail("a setting's name and its finite value");
    if (!result.emplace(words[0], *value).second) lines.fail("each setting once");
  }
  return result;
}

ColorClass parse_class(Lines& lines) {
  const auto words = lines.words("class", 5, "class NAME SAMPLES HISTOGRAM_CELLS TABLE_CELLS");
  ColorClass color;
  color.name = words[1];
  if (!is_class_name(color.name)) lines.fail(shown(words[1]), std::string("a name: ") + class_name_rule);
  color.samples = lines.number(words[2], 0, max_samples, "samples");
  constexpr std::uint64_t side = ChromaHistogram::side;
  const std::uint64_t cells = lines.number(words[3], 0, side * side, "histogram cells");
  const OccupiedCells histogram = parse_counts(
      lines, {"COLUMN ROW COUNT of a histogram cell", "histogram cells in rising order, each once", 3}, cells,
      color.samples, fmt::format("at most the {} samples of the class", color.samples),
      [&](const auto& cell) {
        const std::uint64_t column = lines.number(cell[0], 0, side - 1, "column");
        return lines.number(cell[1], 0, side - 1, "row") * side + column;
      });
  for (const auto& [cell, pixels] : histogram) color.histogram.counts[cell] = pixels;
  color.cells =
      parse_cells(lines, lines.number(words[4], 0, ColorTable::entries, "table cells"), color.samples);
  return color;
}

void parse_table(Lines& lines, ColorTable& result) {
  const std::uint64_t runs = lines.number_of("table", "table RUNS", 1, ColorTable::entries, "runs");
  std::uint64_t filled = 0;
  for (std::uint64_t i = 0; i < runs; ++i) {
    const auto run = lines.words("", 2, "LENGTH CLASS of a run");
    const std::uint64_t left = ColorTable::entries - filled;
    const std::uint64_t length = lines.number(run[0], 1, ColorTable::entries, "length of a run");
    if (length > left)
      lines.fail(fmt::format("{} entries too many", length - left),
                 fmt::format("{} entries in all", ColorTable::entries));
    const std::uint64_t index = lines.number(run[1], 0, result.classes.size(), "class number");
    std::fill_n(result.table.begin() + static_cast<std::ptrdiff_t>(filled), length,
                static_cast<ClassIndex>(index));
    filled += length;
  }
  if (filled != ColorTable::entries) {
    lines.fail(fmt::format("{} table entries", filled),
               fmt::format("{} entries in all", ColorTable::entries));
  }
}

void append_cells(fmt::memory_buffer& body, const OccupiedCells& cells) {
  for (const CellCount& cell : cells)
    fmt::format_to(std::back_inserter(body), "{} {}\n", cell.cell, cell.count);
}

}  // namespace

bool is_class_name(std::string_view name) {
  if (name.empty() || name.size() > 64 || name[0] < 'a' || name[0] > 'z') return false;
  return std::all_of(name.begin(), name.end(),
                     [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; });
}

std::string color_file_bytes(const ColorTable& table) {
  fmt::memory_buffer body;
  const auto out = std::back_inserter(body);
  fmt::format_to(out, "settings {}\n", table.camera_settings.size());
  for (const auto& [name, value] : table.camera_settings)
    fmt::format_to(out, "{} {}\n", name, number_text(value));
  fmt::format_to(out, "classes {}\n", table.classes.size());
  for (const ColorClass& color : table.classes) {
    const auto& counts = color.histogram.counts;
    fmt::format_to(out, "class {} {} {} {}\n", color.name, color.samples,
                   counts.size() - static_cast<std::size_t>(std::count(counts.begin(), counts.end(), 0u)),
                   color.cells.size());
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] == 0) continue;
      fmt::format_to(out, "{} {} {}\n", i % ChromaHistogram::side, i / ChromaHistogram::side, counts[i]);
    }
    append_cells(body, color.cells);
  }
  fmt::format_to(out, "background {}\n", table.background.size());
  append_cells(body, table.background);
  std::vector<std::pair<std::size_t, int>> runs;
  for (const ClassIndex index : table.table) {
    if (runs.empty() || runs.back().second != index) runs.emplace_back(0, index);
    ++runs.back().first;
  }
  fmt::format_to(out, "table {}\n", runs.size());
  for (const auto& [length, index] : runs) fmt::format_to(out, "{} {}\n", length, index);
  fmt::format_to(out, "end\n");
  const std::string text = fmt::to_string(body);
  const std::string file =
      fmt::format("{}\nversion {}\nsha256 {}\n", magic, color_file_version, sha256_hex(text)) + text;
  try {
    parse_color_file(file, "colours");
  } catch (const InputError& error) {
    throw std::invalid_argument(std::string("a colour table that can't be written: ") + error.what());
  }
  return file;
}

ColorTable parse_color_file(std::string_view bytes, const std::string& place) {
  if (bytes.size() > color_file_max_bytes) {
    throw InputError(place, fmt::format("{} bytes", bytes.size()),
                     fmt::format("at most {} bytes", color_file_max_bytes));
  }
  Lines lines(bytes, place);
  if (bytes.empty()) throw InputError(place, "an empty file", "a colours file");
  if (bytes.substr(0, magic.size()) != magic || lines.next("a colours file") != magic) {
    throw InputError(place, shown(bytes.substr(0, bytes.find('\n'))),
                     fmt::format("a colours file, which begins with \"{}\"", magic));
  }
  const auto version = lines.words("version", 2, "version NUMBER");
  if (version[1] != fmt::format("{}", color_file_version)) {
    const bool newer = parse_integer(version[1]).value_or(0) > color_file_version;
    lines.fail("version " + shown(version[1]),
               fmt::format("version {}; {}", color_file_version,
                           newer ? "the file was written by a newer program than this one"
                                 : "learn the colours again from their pictures"));
  }
  const auto checksum = lines.words("sha256", 2, "sha256 CHECKSUM");
  if (checksum[1] != sha256_hex(lines.rest())) {
    lines.fail("a checksum that does not fit the contents (the file is truncated or was changed)",
               "a colours file as it was written");
  }
  ColorTable result;
  result.camera_settings = parse_settings(lines);
  const std::uint64_t count = lines.number_of("classes", "classes COUNT", 0, max_classes, "classes");
  for (std::uint64_t i = 0; i < count; ++i) {
    ColorClass color = parse_class(lines);
    if (result.find(color.name)) lines.fail("a second class named " + color.name, "each name once");
    result.classes.push_back(std::move(color));
  }
  const std::uint64_t background =
      lines.number_of("background", "background CELLS", 0, ColorTable::entries, "background cells");
  result.background = parse_cells(lines, background, max_samples);
  parse_table(lines, result);
  if (lines.next("end") != "end") lines.fail("end");
  if (!lines.rest().empty()) lines.fail("more after the end", "nothing");
  return result;
}

ColorTable read_color_file(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored))
    throw InputError(file.string(), "no such file",
                     "a colours file, as `ballservo calibrate colors` writes it");
  return parse_color_file(read_text_file(file, color_file_max_bytes), file.string());
}

}  // namespace ballservo
