// Tables in CSV: what users and spreadsheets write, and what is refused.
#include "calibration/base/csv_table.hpp"

#include <gtest/gtest.h>

#include "tests/support/faults.hpp"

namespace ballservo {
namespace {

CsvTable parsed(const std::string& text) {
  return parse_csv(text, "t.csv", {"source", "distance_m"}, {"sigma_m"});
}

std::string csv_faults(const std::string& text) {
  return test::fault_lines([&] { parsed(text); });
}

TEST(CsvTables, AsSpreadsheetsWriteThem) {
  const CsvTable table = parsed(
      "\xef\xbb\xbf"
      "distance_m, source\r\n1.5,\"a, b.png\"\r\n\r\n 2 ,\"say \"\"x\"\".png\" \r\n0.5,c.png");
  ASSERT_EQ(table.rows.size(), 3u);
  EXPECT_EQ(table.column("source"), 1);
  EXPECT_EQ(table.column("sigma_m"), -1);
  EXPECT_EQ(table.rows[0][1], "a, b.png");
  EXPECT_EQ(table.rows[1][0], "2");
  EXPECT_EQ(table.rows[1][1], "say \"x\".png");
  EXPECT_EQ(table.lines, (std::vector<int>{2, 4, 5}));
  EXPECT_EQ(table.place(1, "source"), "t.csv:4: source");
}

TEST(CsvTables, FaultsWithTheirLines) {
  EXPECT_NE(csv_faults("").find("no heading"), std::string::npos);
  EXPECT_NE(csv_faults("source\n").find("no column distance_m"), std::string::npos);
  EXPECT_NE(csv_faults("source,distance_m,source\n").find("twice"), std::string::npos);
  EXPECT_NE(csv_faults("source,distance_m,colour\n").find("\"colour\""), std::string::npos);
  const std::string faults = csv_faults("source,distance_m\na\nb,1\nc,1,2\n");
  EXPECT_NE(faults.find("t.csv:2: found 1 cells"), std::string::npos) << faults;
  EXPECT_NE(faults.find("t.csv:4: found 3 cells"), std::string::npos) << faults;
  EXPECT_NE(csv_faults("source,distance_m\n\"a,1\n").find("t.csv:2: found a quote"), std::string::npos);
  EXPECT_NE(csv_faults("source,distance_m\n\"a\"b,1\n").find("after a closing quote"), std::string::npos);
  EXPECT_NE(csv_faults(std::string(5u << 20, 'a')).find("bytes"), std::string::npos);
  EXPECT_NE(csv_faults(std::string(1000, ',')).find("too many cells"), std::string::npos);
}

}  // namespace
}  // namespace ballservo
