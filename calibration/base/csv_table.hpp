// Tables in CSV (RFC 4180) as users write them, read strictly.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calibration/base/fault.hpp"

namespace ballservo {

/// The rows of a table below its heading.
struct CsvTable {
  std::string name;  ///< of the file, for messages
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  ///< each as long as `columns`; blanks around cells are gone
  std::vector<int> lines;                      ///< of each row, counted from 1

  /// The index of a column, or -1.
  int column(const std::string& column_name) const;
  std::string place(std::size_t row, const std::string& column_name) const;  ///< "file.csv:3: distance_m"
};

/// How large a table may be.
struct CsvLimits {
  std::size_t bytes = 4u << 20, rows = 100000, columns = 64;
};

/// Reads a table whose first line names its columns: all of `required` and any of `optional`, in any order.
/// Cells are parted by commas and may stand in double quotes; lines may end in CR LF; empty lines are left
/// out. Throws InputError with every fault: missing, unknown or repeated columns, rows of another length,
/// quotes that do not close, more than `limits` allow.
CsvTable parse_csv(const std::string& text, const std::string& name, const std::vector<std::string>& required,
                   const std::vector<std::string>& optional = {}, const CsvLimits& limits = {});
CsvTable read_csv(const std::filesystem::path& file, const std::vector<std::string>& required,
                  const std::vector<std::string>& optional = {}, const CsvLimits& limits = {});

}  // namespace ballservo
