// Tables in CSV (RFC 4180): read strictly, as users write them, and written.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "calibration/base/fault.hpp"
#include "calibration/base/strict_yaml.hpp"

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

/// A row of a table, read cell by cell. What is not as it should be becomes a fault.
class CsvRow {
 public:
  CsvRow(const CsvTable& table, std::size_t row, FaultList& faults)
      : table_(table), row_(row), faults_(faults) {}

  const std::string& text(const std::string& column) const;  ///< empty, too, where there is no such column
  /// Nothing for an empty cell.
  std::optional<double> number(const std::string& column, const NumberRange& range) const;
  long long count(const std::string& column) const;  ///< 0 or more
  void fault(const std::string& column, const std::string& found, const std::string& allowed) const;

 private:
  const CsvTable& table_;
  std::size_t row_;
  FaultList& faults_;
};

/// A cell to be written: text is quoted where it has to be (RFC 4180), numbers round-trip, what is not known
/// (NaN, nothing) stays empty, and a truth value is 0 or 1.
std::string csv_cell(std::string_view text);
std::string csv_cell(double value);
template <class Integer>
std::enable_if_t<std::is_integral_v<Integer>, std::string> csv_cell(Integer value) {
  return std::to_string(value);
}
template <class T>
std::string csv_cell(const std::optional<T>& value) {
  return value ? csv_cell(*value) : "";
}
inline std::string csv_cell(const char* text) { return csv_cell(std::string_view(text)); }
inline std::string csv_cell(const std::string& text) { return csv_cell(std::string_view(text)); }

/// A row to be written, with its line end.
template <class First, class... Rest>
std::string csv_row(const First& first, const Rest&... rest) {
  std::string row = csv_cell(first);
  ((row += ',', row += csv_cell(rest)), ...);
  return row += '\n';
}

}  // namespace ballservo
