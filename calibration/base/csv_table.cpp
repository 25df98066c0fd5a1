#include "calibration/base/csv_table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "calibration/base/numbers.hpp"
#include "calibration/base/system_file.hpp"

namespace ballservo {
namespace {

/// Whether a spreadsheet would take the text for a formula: written, it gets an apostrophe, which is taken
/// off again when it is read; so does what already begins with apostrophes before such a text.
bool is_formula(std::string_view text) {
  const std::size_t first = text.find_first_not_of('\'');
  return first != std::string_view::npos && !parse_number(text.substr(first)) &&
         std::string_view("=+-@\t\r").find(text[first]) != std::string_view::npos;
}

/// Takes the cells of one record off the text; quoted cells may hold commas and ends of lines.
class Records {
 public:
  Records(const std::string& text, const std::string& name, std::size_t max_cells)
      : text_(text), name_(name), max_cells_(max_cells) {
    if (text_.compare(0, 3, "\xef\xbb\xbf") == 0) at_ = 3;
  }

  bool at_end() const { return at_ >= text_.size(); }
  int line() const { return line_; }

  std::vector<std::string> next() {
    std::vector<std::string> cells;
    for (;;) {
      cells.push_back(cell());
      if (cells.back()[0] == '\'' && is_formula(cells.back())) cells.back().erase(0, 1);
      if (cells.size() > max_cells_)
        throw InputError(fmt::format("{}:{}", name_, line_), "too many cells",
                         fmt::format("at most {}", max_cells_));
      if (!at_end() && text_[at_] == ',') {
        ++at_;
        continue;
      }
      if (!at_end() && text_[at_] == '\r') ++at_;
      if (!at_end() && text_[at_] == '\n') ++at_, ++line_;
      return cells;
    }
  }

 private:
  std::string cell() {
    while (!at_end() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
    if (!at_end() && text_[at_] == '"') return quoted();
    const std::size_t end = std::min(text_.find_first_of(",\r\n", at_), text_.size());
    const std::string_view found = trimmed(std::string_view(text_).substr(at_, end - at_), " \t");
    at_ = end;
    return std::string(found);
  }

  std::string quoted() {
    const int opened = line_;
    std::string result;
    for (++at_; !at_end(); ++at_) {
      if (text_[at_] == '\n') ++line_;
      if (text_[at_] != '"') {
        result += text_[at_];
      } else if (at_ + 1 < text_.size() && text_[at_ + 1] == '"') {
        result += '"', ++at_;
      } else {
        const std::size_t end = std::min(text_.find_first_of(",\r\n", ++at_), text_.size());
        if (!trimmed(std::string_view(text_).substr(at_, end - at_), " \t").empty())
          throw InputError(fmt::format("{}:{}", name_, line_), "text after a closing quote",
                           "a comma or the end of the line");
        at_ = end;
        return result;
      }
    }
    throw InputError(fmt::format("{}:{}", name_, opened), "a quote that is not closed", "a second \"");
  }

  const std::string& text_;
  const std::string& name_;
  std::size_t max_cells_, at_ = 0;
  int line_ = 1;
};

void check_columns(const CsvTable& table, int line, const std::vector<std::string>& required,
                   const std::vector<std::string>& optional, FaultList& faults) {
  std::vector<std::string> known = required;
  known.insert(known.end(), optional.begin(), optional.end());
  const std::string allowed = fmt::format("columns {}{}{}", fmt::join(required, ","),
                                          optional.empty() ? "" : " and any of ", fmt::join(optional, ","));
  const std::string place = fmt::format("{}:{}", table.name, line);
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const std::string& column = table.columns[i];
    if (std::find(known.begin(), known.end(), column) == known.end())
      faults.add(place, "a column \"" + column + "\"", allowed);
    else if (table.column(column) != static_cast<int>(i))
      faults.add(place, "the column " + column + " twice", "each once");
  }
  for (const std::string& column : required)
    if (table.column(column) < 0) faults.add(place, "no column " + column, allowed);
}

}  // namespace

int CsvTable::column(const std::string& column_name) const {
  const auto found = std::find(columns.begin(), columns.end(), column_name);
  return found == columns.end() ? -1 : static_cast<int>(found - columns.begin());
}

std::string CsvTable::place(std::size_t row, const std::string& column_name) const {
  return fmt::format("{}:{}: {}", name, lines[row], column_name);
}

CsvTable parse_csv(const std::string& text, const std::string& name, const std::vector<std::string>& required,
                   const std::vector<std::string>& optional, const CsvLimits& limits) {
  if (text.size() > limits.bytes)
    throw InputError(name, fmt::format("{} bytes", text.size()),
                     fmt::format("at most {} bytes", limits.bytes));
  CsvTable table;
  table.name = name;
  FaultList faults;
  Records records(text, name, limits.columns);
  while (!records.at_end()) {
    const int line = records.line();
    std::vector<std::string> cells = records.next();
    if (cells.size() == 1 && cells[0].empty()) continue;
    if (table.columns.empty()) {
      table.columns = std::move(cells);
      check_columns(table, line, required, optional, faults);
      faults.throw_if_any();
    } else if (cells.size() != table.columns.size()) {
      faults.add(fmt::format("{}:{}", name, line), fmt::format("{} cells", cells.size()),
                 fmt::format("{}, as the heading has", table.columns.size()));
    } else if (table.rows.size() == limits.rows) {
      throw InputError(name, "too many rows", fmt::format("at most {}", limits.rows));
    } else {
      table.rows.push_back(std::move(cells));
      table.lines.push_back(line);
    }
  }
  if (table.columns.empty())
    faults.add(name, "no heading", fmt::format("a first line {}", fmt::join(required, ",")));
  faults.throw_if_any();
  return table;
}

CsvTable read_csv(const std::filesystem::path& file, const std::vector<std::string>& required,
                  const std::vector<std::string>& optional, const CsvLimits& limits) {
  return parse_csv(read_file_bytes(file, limits.bytes), file.string(), required, optional, limits);
}

const std::string& CsvRow::text(const std::string& column) const {
  static const std::string nothing;
  const int index = table_.column(column);
  return index < 0 ? nothing : table_.rows[row_][static_cast<std::size_t>(index)];
}

std::optional<double> CsvRow::number(const std::string& column, const NumberRange& range) const {
  const std::string& cell = text(column);
  if (cell.empty()) return std::nullopt;
  const auto value = parse_number(cell);
  if (value && range.contains(*value)) return value;
  fault(column, "\"" + cell + "\"", range.to_text());
  return std::nullopt;
}

long long CsvRow::count(const std::string& column) const {
  const auto value = parse_integer(text(column));
  if (!value || *value < 0) fault(column, "\"" + text(column) + "\"", "a whole number of at least 0");
  return value.value_or(0);
}

void CsvRow::fault(const std::string& column, const std::string& found, const std::string& allowed) const {
  faults_.add(table_.place(row_, column), found, allowed);
}

std::string csv_cell(std::string_view text) {
  const std::string apostrophe = is_formula(text) ? "'" : "";
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return apostrophe + std::string(text);
  std::string quoted = '"' + apostrophe;
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string csv_cell(double value) { return number_text(value); }

}  // namespace ballservo
