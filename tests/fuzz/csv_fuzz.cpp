// Tables in CSV: an InputError, or rows that are as long as the heading.
#include "calibration/base/csv_table.hpp"
#include "calibration/base/numbers.hpp"
#include "tests/fuzz/fuzz_folder.hpp"

using namespace ballservo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const CsvTable table =
        parse_csv(fuzz::text_of(data, size), "fuzz.csv", {"source", "distance_m"}, {"sigma_m"});
    fuzz::require(table.rows.size() == table.lines.size(), "a line for each row");
    for (const auto& row : table.rows) {
      fuzz::require(row.size() == table.columns.size(), "rows as long as the heading");
      for (const std::string& cell : row) parse_number(cell);
    }
  } catch (const InputError&) {
  }
  return 0;
}
