// Journals that hold what no run has noted.
#include <nlohmann/json.hpp>

#include "app/io/work_folder.hpp"
#include "tests/hostile/commands.hpp"

namespace ballservo {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using Note = std::pair<std::string, std::string>;

class Journals : public test::Hostile {
 protected:
  /// An unfinished run of the job whose results lie in `finished`.
  void begin(const std::string& folder, const std::string& finished, const std::vector<Note>& notes) const {
    const json manifest = json::parse(contents(finished + "/manifest.json"));
    const WorkJob job{manifest.at("job"), parse_shard(manifest.at("shard"))};
    std::string journal = json{"ballservo journal 1", job.sha256()}.dump() + "\n";
    for (const auto& [key, value] : notes) journal += json{key, value}.dump() + "\n";
    std::filesystem::remove_all(dir / folder);
    std::filesystem::create_directories(dir / folder);
    put(folder + "/unfinished.journal", journal);
  }
  std::string line(const std::string& file, int number) const {
    std::istringstream lines(contents(file));
    std::string text;
    for (int k = 0; k < number; ++k) std::getline(lines, text);
    return text + "\n";
  }
};

TEST_F(Journals, OfSweepsHoldTrials) {
  const std::string sweep = "sweep '" + (test::project_data_dir() / "scenarios/static_ball.yaml").string() +
                            "' --trials 3 --perception truth --resume -o ";
  ASSERT_EQ(run(sweep + "whole").code, 0);
  const std::string row = line("whole/trials.csv", 2), trace = line("whole/traces.jsonl", 1);
  for (const Note& bad : std::vector<Note>{{"0", "hello"},
                                           {"0", ""},
                                           {"0", row},
                                           {"0", trace},
                                           {"0", row + row + trace},
                                           {"0", row + line("whole/traces.jsonl", 2)},
                                           {"1", row + trace},
                                           {"3", row + trace},
                                           {"", row + trace}}) {
    begin("out", "whole", {bad});
    const auto ending = run(sweep + "out");
    EXPECT_EQ(ending.code, 2) << bad.first << bad.second;
    EXPECT_THAT(ending.messages, HasSubstr("unfinished.journal:2: found a damaged line")) << bad.second;
    EXPECT_EQ(line("out/unfinished.journal", 3), "\n") << "work was done";
  }
  begin("out", "whole", {{"0", row + trace}});
  EXPECT_EQ(run(sweep + "out").code, 0);
  EXPECT_EQ(contents("out/trials.csv"), contents("whole/trials.csv"));
}

TEST_F(Journals, OfComparisonsHoldRecords) {
  put("plan.yaml",
      "frames: 9\nmethods: [vote, paper_one_step]\ndefaults: {camera: {focal_px: 200, width_px: 160, "
      "height_px: 120}, depth_m: 0.4}\nconditions: [{name: base}]\n");
  for (const char* part : {"1", "2"})
    ASSERT_EQ(run(std::string("compare plan.yaml -o part_") + part + " --shard " + part + "/2").code, 0);
  const json settings = json::parse(line("part_1/notes.jsonl", 2)),
             unit = json::parse(line("part_1/notes.jsonl", 3));
  const std::string key = unit[0], records = unit[1];
  for (const Note& bad : std::vector<Note>{{key, "hello"},
                                           {key, "[]"},
                                           {key, ""},
                                           {"base/8", records},
                                           {"claims:paper", "{}"},
                                           {"settings:other", "x"}}) {
    const std::vector<Note> notes{{settings[0], settings[1]}, bad};
    begin("out", "part_1", notes);
    EXPECT_THAT(run("compare plan.yaml --shard 1/2 --resume -o out").messages,
                HasSubstr("unfinished.journal:3: found a damaged line"))
        << bad.first;
    if (bad.first == "base/8") continue;  // the other part's key
    std::filesystem::copy_file(dir / "out/unfinished.journal", dir / "part_1/notes.jsonl",
                               std::filesystem::copy_options::overwrite_existing);
    const auto merge = run("compare merge part_1 part_2 -o merged --force");
    EXPECT_EQ(merge.code, 2) << bad.first;
    EXPECT_THAT(merge.messages, HasSubstr("notes.jsonl:3: found a damaged line")) << bad.first;
  }
}

}  // namespace
}  // namespace ballservo
