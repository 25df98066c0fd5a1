// A csv file's rows, by the names of its columns.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "calibration/base/numbers.hpp"

namespace ballservo::test {

using Row = std::map<std::string, std::string>;

inline std::vector<Row> read_csv(const std::filesystem::path& file) {
  std::ifstream stream(file);
  const auto cells_of = [](const std::string& line) {
    std::vector<std::string> cells;
    std::stringstream text(line + ",");
    for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
    return cells;
  };
  std::string line;
  std::getline(stream, line);
  const std::vector<std::string> names = cells_of(line);
  std::vector<Row> rows;
  while (std::getline(stream, line)) {
    const std::vector<std::string> cells = cells_of(line);
    Row row;
    for (std::size_t i = 0; i < names.size(); ++i) row[names[i]] = cells.at(i);
    rows.push_back(row);
  }
  return rows;
}

inline double number(const Row& row, const char* name) { return parse_number(row.at(name)).value(); }

}  // namespace ballservo::test
