// FILES.md names every column of every table that the program writes, and no other.
#include <fstream>
#include <map>
#include <regex>
#include <set>

#include "tests/program/program_run.hpp"

namespace ballservo {
namespace {

using Columns = std::set<std::string>;

/// What FILES.md says of one table.
struct Section {
  Columns columns, optional;
};

std::map<std::string, Section> sections() {
  std::ifstream page(test::project_data_dir().parent_path() / "FILES.md");
  std::map<std::string, Section> result;
  std::vector<std::string> tables;
  const std::regex quoted("`([^`]+)`"), table("([a-z]+\\.csv)");
  for (std::string line; std::getline(page, line);) {
    const auto matches = [](const std::string& text, const std::regex& pattern) {
      std::vector<std::string> found;
      for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at)
        found.push_back((*at)[1]);
      return found;
    };
    if (line.rfind("## ", 0) == 0) tables = matches(line, table);
    if (line.rfind("| `", 0) != 0) continue;
    const bool is_optional = line.find("optional") != std::string::npos;
    for (const std::string& name : matches(line.substr(0, line.find('|', 1)), quoted))
      for (const std::string& file : tables)
        (is_optional ? result[file].optional : result[file].columns).insert(name);
  }
  return result;
}

class FileReferenceTest : public test::ProgramTest {
 protected:
  Columns header(const std::string& file) const {
    std::stringstream line(contents(file).substr(0, contents(file).find('\n')));
    Columns columns;
    for (std::string name; std::getline(line, name, ',');)
      columns.insert(name.rfind("drawn.", 0) == 0  ? "drawn.KEY"
                     : name.rfind("vary.", 0) == 0 ? "vary.KEY"
                                                   : name);
    return columns;
  }
};

TEST_F(FileReferenceTest, EveryColumnIsDescribedAndNoOther) {
  const std::string scenario = (test::project_data_dir() / "scenarios/static_ball.yaml").string();
  put("plan.yaml",
      "frames: 2\nmethods: [vote, paper_one_step, paper_converged]\nconditions: [{name: base}]\n");
  ASSERT_EQ(run("servo " + scenario + " -o run --perception geometric --quiet").code, 0);
  ASSERT_EQ(run("sweep " + scenario + " -o sweep --trials 2 --quiet").code, 0);
  ASSERT_EQ(run("sweep " + scenario + " -o grid --trials 2 --vary law.gain_per_s=1,2 --quiet").code, 0);
  ASSERT_EQ(run("compare plan.yaml -o compare --quiet").code, 0);
  ASSERT_EQ(run("render " + scenario + " -o pictures --frames 1 --quiet").code, 0);

  const auto described = sections();
  for (const std::string file :
       {"run/log.csv", "run/tracks.csv", "sweep/trials.csv", "grid/grid.csv", "pictures/truth.csv",
        "compare/compare.csv", "compare/fits.csv", "compare/frames.csv", "compare/pairs.csv",
        "compare/tests.csv", "compare/certificate.csv", "compare/timing.csv"}) {
    const auto section = described.find(file.substr(file.find('/') + 1));
    ASSERT_NE(section, described.end()) << file;
    const Columns written = header(file);
    for (const std::string& name : written)
      EXPECT_TRUE(section->second.columns.count(name) || section->second.optional.count(name))
          << file << " has a column that FILES.md does not describe: " << name;
    for (const std::string& name : section->second.columns)
      EXPECT_TRUE(written.count(name))
          << "FILES.md describes a column that " << file << " does not have: " << name;
  }
}

}  // namespace
}  // namespace ballservo
