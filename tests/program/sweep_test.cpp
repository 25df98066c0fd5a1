// Sweeps from outside: the same bytes however they are split, killed and resumed.
#include <functional>
#include <nlohmann/json.hpp>

#include "tests/program/program_run.hpp"

namespace ballservo::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class SweepTest : public ProgramTest {
 protected:
  Ending sweep(const std::string& arguments, const std::string& before = "") const {
    return run("sweep '" + scenario() + "' --perception truth " + arguments, before);
  }
  static std::string scenario() {
    return (project_data_dir() / "scenarios" / "static_ball.yaml").lexically_normal().string();
  }
  void expect_same(const std::string& a, const std::string& b) const {
    for (const char* file : {"trials.csv", "traces.jsonl", "summary.json", "report.json", "manifest.json"}) {
      EXPECT_EQ(contents(a + "/" + file), contents(b + "/" + file)) << file;
      EXPECT_FALSE(contents(a + "/" + file).empty()) << file;
    }
  }
};

TEST_F(SweepTest, PartsMergedAreTheWholeAtAnyNumberOfThreads) {
  ASSERT_EQ(sweep("-o whole --trials 9 --seed 5 --threads 1").code, 0);
  ASSERT_EQ(sweep("-o whole_3 --trials 9 --seed 5 --threads 3").code, 0);
  expect_same("whole", "whole_3");
  for (const std::string part : {"1", "2", "3", "4"}) {
    ASSERT_EQ(sweep("-o part_" + part + " --trials 9 --seed 5 --shard " + part + "/4").code, 0);
  }
  const Ending merge = run("sweep merge part_3 part_1 part_4 part_2 -o merged");
  ASSERT_EQ(merge.code, 0) << merge.messages;
  EXPECT_THAT(merge.out, HasSubstr("9 of 9 reached"));
  expect_same("whole", "merged");
}

TEST_F(SweepTest, AKilledSweepIsResumedToTheSameBytes) {
  ASSERT_EQ(sweep("-o whole --trials 40 --threads 1").code, 0);
  // Killed again and again, in the middle of whatever it was doing.
  int kills = 0;
  for (const char* seconds : {"0.15", "0.3", "0.2", "0.25"}) {
    const Ending killed =
        sweep("-o killed --trials 40 --threads 2 --resume", "timeout -s KILL " + std::string(seconds));
    kills += killed.code != 0 ? 1 : 0;
    const std::string trials = contents("killed/trials.csv");
    EXPECT_TRUE(trials.empty() || trials == contents("whole/trials.csv"));
  }
  EXPECT_GE(kills, 1);
  ASSERT_EQ(sweep("-o killed --trials 40 --resume").code, 0);
  expect_same("whole", "killed");
  EXPECT_EQ(names().count("unfinished.journal"), 0u);
  EXPECT_EQ(sweep("-o killed --trials 40 --resume").code, 0);
}

TEST_F(SweepTest, FewerTrialsThanAreDoneAreRefused) {
  const auto journal = [&] { return contents("begun/unfinished.journal"); };
  const auto lines = [&] {
    const std::string text = journal();
    return std::count(text.begin(), text.end(), '\n');
  };
  for (int tries = 0; tries < 100 && lines() < 4; ++tries)
    sweep("-o begun --trials 4000 --threads 1 --resume", "timeout -s KILL 0.3");
  const std::string before = journal();
  const Ending fewer = sweep("-o begun --trials 2 --resume");
  EXPECT_EQ(fewer.code, 2);
  EXPECT_THAT(fewer.messages, HasSubstr("--trials: found 2 where"));
  EXPECT_EQ(journal(), before);
}

TEST_F(SweepTest, MoreTrialsAreAddedToWhatIsFinishedOrWasKilled) {
  ASSERT_EQ(sweep("-o whole --trials 40").code, 0);
  ASSERT_EQ(sweep("-o grown --trials 3 --resume").code, 0);
  sweep("-o grown --trials 20 --threads 1 --resume", "timeout -s KILL 0.3");
  ASSERT_EQ(sweep("-o grown --trials 40 --resume").code, 0);
  expect_same("whole", "grown");
  EXPECT_EQ(sweep("-o grown --trials 39 --resume").code, 2) << "fewer";
  EXPECT_EQ(sweep("-o grown --trials 41 --resume --set law.gain_per_s=1").code, 2) << "another job";
  EXPECT_EQ(sweep("-o grown --trials 41").code, 2) << "without --resume";
  expect_same("whole", "grown");
}

class GridTest : public SweepTest {
 protected:
  Ending grid(const std::string& arguments, const std::string& before = "") const {
    return sweep("--trials 4 --seed 3 --vary law.gain_per_s=0.5,1 --vary law.name=cone,visp " + arguments,
                 before);
  }
  void expect_same_grid(const std::string& a, const std::string& b) const {
    for (const char* file : {"trials.csv", "grid.csv", "summary.json", "report.json", "manifest.json"}) {
      EXPECT_EQ(contents(a + "/" + file), contents(b + "/" + file)) << file;
      EXPECT_FALSE(contents(a + "/" + file).empty()) << file;
    }
  }
  /// Leaves the whole in a folder of that name.
  void expect_parts_and_threads_make_the_whole(
      const std::function<Ending(const std::string& arguments)>& sweep) const {
    ASSERT_EQ(sweep("-o whole --threads 1").code, 0);
    ASSERT_EQ(sweep("-o whole_3 --threads 3").code, 0);
    expect_same_grid("whole", "whole_3");
    for (const std::string part : {"1", "2", "3"})
      ASSERT_EQ(sweep("-o part_" + part + " --shard " + part + "/3").code, 0);
    ASSERT_EQ(run("sweep merge part_3 part_1 part_2 -o merged").code, 0);
    expect_same_grid("whole", "merged");
  }
};

TEST_F(GridTest, PartsMergedAndResumedAreTheWholeAtAnyNumberOfThreads) {
  expect_parts_and_threads_make_the_whole([&](const std::string& arguments) { return grid(arguments); });
  int kills = 0;
  for (const char* seconds : {"0.3", "0.5", "0.7"})
    kills +=
        grid("-o killed --threads 1 --resume", "timeout -s KILL " + std::string(seconds)).code != 0 ? 1 : 0;
  EXPECT_GE(kills, 1);
  ASSERT_EQ(grid("-o killed --resume").code, 0);
  expect_same_grid("whole", "killed");
  EXPECT_EQ(grid("-o killed --resume").code, 0);
  EXPECT_EQ(grid("-o killed").code, 2);
}

TEST_F(GridTest, MoreTrialsAreAddedToEachCell) {
  ASSERT_EQ(grid("-o whole").code, 0);
  const std::string fewer =
      "--trials 2 --seed 3 --vary law.gain_per_s=0.5,1 --vary law.name=cone,visp -o grown";
  ASSERT_EQ(sweep(fewer).code, 0);
  ASSERT_EQ(grid("-o grown --resume").code, 0);
  expect_same_grid("whole", "grown");
}

TEST_F(GridTest, EveryCellIsTheSweepThatItsValuesAre) {
  ASSERT_EQ(grid("-o grid").code, 0);
  ASSERT_EQ(sweep("-o first --trials 4 --seed 3 --set law.gain_per_s=0.5 --set law.name=cone").code, 0);
  ASSERT_EQ(
      sweep("-o cell --trials 4 --seed 3 --set law.gain_per_s=1 --set law.name=visp --against first").code,
      0);
  const auto all = nlohmann::json::parse(contents("grid/summary.json"));
  const auto alone = nlohmann::json::parse(contents("cell/summary.json"));
  EXPECT_EQ(all["trials"], 16);
  ASSERT_EQ(all["cells"].size(), 4u);
  const nlohmann::json& cell = all["cells"][3];
  EXPECT_EQ(cell["values"], (nlohmann::json{{"law.gain_per_s", "1"}, {"law.name", "visp"}}));
  for (const char* key : {"scenario_hash", "success_rate", "success_ci95", "settled_s", "range_rms_m", "law"})
    EXPECT_EQ(cell[key], alone[key]) << key;
  EXPECT_EQ(cell["settled_less_first_s"], alone["against"]["median_differences"]["settled_s"]["median"]);
  const std::string rows = contents("cell/trials.csv");
  EXPECT_THAT(contents("grid/trials.csv"), HasSubstr(rows.substr(rows.find('\n') + 1)));
}

TEST_F(GridTest, FaultsAreNamedAtTheirKeyBeforeAnyWork) {
  const auto faults = [&](const std::string& arguments) {
    const Ending ending = sweep("--trials 2 -o never " + arguments);
    EXPECT_EQ(ending.code, 2) << arguments;
    EXPECT_EQ(names().count("never"), 0u);
    return ending.messages;
  };
  const std::string several = faults("--vary law.gain_per_s=1,-1,abc --vary law.nam=x");
  EXPECT_THAT(several, HasSubstr("--vary law.gain_per_s: found -1; allowed: a number above 0"));
  EXPECT_THAT(several, HasSubstr("--vary law.gain_per_s: found abc"));
  EXPECT_THAT(several, HasSubstr("--vary law.nam: found an unknown key"));
  EXPECT_THAT(several, Not(HasSubstr("--set")));
  for (const char* key : {"balls.0.diameter_m", "balls[0].diameter_m"})
    EXPECT_THAT(faults("--vary '" + std::string(key) + "=1,-1'"),
                HasSubstr("--vary balls[0].diameter_m: found -1"));
  for (const char* odd : {"law.gain_per_s", "law.gain_per_s=", "law.gain_per_s=1,,2", "=1"})
    EXPECT_THAT(faults(std::string("--vary ") + odd), HasSubstr("KEY=V1,V2")) << odd;
  EXPECT_THAT(faults("--vary law.gain_per_s=1,1"), HasSubstr("values that differ"));
  EXPECT_THAT(faults("--set law.gain_per_s=1 --vary law.gain_per_s=1,2"), HasSubstr("twice"));
  EXPECT_THAT(faults("--vary 'balls[0].diameter_m=1,2' --vary balls.0.diameter_m=1,2"), HasSubstr("twice"));
}

TEST_F(GridTest, ACellAloneIsMergedAndResumed) {
  const std::string one = "--trials 2 --vary law.name=visp -o one ";
  ASSERT_EQ(sweep(one).code, 0);
  EXPECT_EQ(run("sweep merge one -o merged").code, 0);
  expect_same_grid("one", "merged");
  EXPECT_EQ(sweep(one + "--resume").code, 0);
}

class SuiteTest : public GridTest {
 protected:
  void SetUp() override {
    GridTest::SetUp();
    const std::string moving = (project_data_dir() / "scenarios" / "moving_ball.yaml").string();
    put("suite.yaml", "scenarios: [" + scenario() + ", " + moving + "]\n");
  }
  Ending suite(const std::string& arguments) const {
    return run("sweep suite.yaml --perception truth --trials 4 --seed 3 " + arguments);
  }
  std::string faults(const std::string& text) const {
    put("bad.yaml", text);
    const Ending ending = run("sweep bad.yaml -o never --trials 2");
    EXPECT_EQ(ending.code, 2) << text;
    EXPECT_EQ(names().count("never"), 0u);
    return ending.messages;
  }
};

TEST_F(SuiteTest, PartsMergedAreTheWholeAtAnyNumberOfThreadsAndMoreTrialsAreAdded) {
  expect_parts_and_threads_make_the_whole([&](const std::string& arguments) { return suite(arguments); });
  ASSERT_EQ(run("sweep suite.yaml --perception truth --trials 2 --seed 3 -o grown").code, 0);
  ASSERT_EQ(suite("-o grown --resume").code, 0);
  expect_same_grid("whole", "grown");
}

TEST_F(SuiteTest, EachRowIsTheSweepOfItsScenarioAndIsComparedWithinIt) {
  const Ending all = suite("-o all --vary law.name=cone,visp");
  ASSERT_EQ(all.code, 0) << all.messages;
  const auto cells = nlohmann::json::parse(contents("all/summary.json")).at("cells");
  ASSERT_EQ(cells.size(), 4u);
  for (const std::size_t cell : {1u, 3u}) {
    const std::string name = cells[cell].at("values").at("scenario");
    const std::string file = (project_data_dir() / "scenarios" / (name + ".yaml")).string();
    for (const std::string law : {"cone", "visp"})
      ASSERT_EQ(run("sweep " + file + " -o " + name + law +
                    " --perception truth --trials 4 --seed 3 --set law.name=" + law +
                    (law == "visp" ? " --against " + name + "cone" : ""))
                    .code,
                0);
    const auto alone = nlohmann::json::parse(contents(name + "visp/summary.json"));
    for (const char* key : {"scenario_hash", "success_ci95", "settled_s", "range_rms_m", "touched"})
      EXPECT_EQ(cells[cell].at(key), alone.at(key)) << name << " " << key;
    EXPECT_EQ(cells[cell].at("settled_less_first_s"),
              alone.at("against").at("median_differences").at("settled_s").at("median"));
  }
  EXPECT_EQ(std::count(all.out.begin(), all.out.end(), '\n'), 5)
      << "a heading and a line a cell: " << all.out;
  EXPECT_THAT(all.out, HasSubstr("\nmoving_ball  visp      4       4         4 "));
  // What one scenario alone draws is a column that is empty for the others.
  const std::string trials = contents("all/trials.csv");
  EXPECT_THAT(trials.substr(0, trials.find('\n')), HasSubstr("drawn.balls.0.motion.speed_mps"));
}

TEST_F(SuiteTest, FaultsOfASuiteAreNamedInItBeforeAnyWork) {
  put("a.yaml", "duration_s: x\n");
  EXPECT_THAT(faults("scenarios: []\n"), HasSubstr("bad.yaml:1: scenarios: found an empty list"));
  EXPECT_THAT(faults("scenarios:\n"), HasSubstr("scenarios: found nothing; allowed: a list"));
  EXPECT_THAT(faults("scenarios: 3\n"), HasSubstr("scenarios: found 3; allowed: a list"));
  EXPECT_THAT(faults("scenarios: [{a: 1}]\n"), HasSubstr("scenarios[0]: found a map; allowed: text"));
  EXPECT_THAT(faults("scenarios: [a.yaml]\ntrails: 3\n"),
              HasSubstr("bad.yaml:2: trails: found an unknown key"));
  const std::string several = faults("scenarios:\n  - nowhere.yaml\n  - .\n  - a.yaml\n  - ./a.yaml\n");
  EXPECT_THAT(several, HasSubstr("bad.yaml:2: scenarios[0]: found nowhere.yaml; allowed: a scenario's file"));
  EXPECT_THAT(several, HasSubstr("bad.yaml:3: scenarios[1]"));
  EXPECT_THAT(several, HasSubstr("bad.yaml:5: scenarios[3]: found a twice"));
  EXPECT_THAT(faults("scenarios: [a.yaml]\n"), HasSubstr("a.yaml:1: duration_s: found x"));
  EXPECT_EQ(suite("-o never --against nowhere").code, 2);
  EXPECT_EQ(run("sweep suite.yaml -o never --trials 1000000").code, 2);
  EXPECT_EQ(names().count("never"), 0u);
}

TEST_F(SuiteTest, AScenarioWithoutColoursIsNamedBeforeAnyWork) {
  std::string text = contents(scenario());
  text.erase(text.find("\ncolors:"), text.find('\n', text.find("\ncolors:") + 1) - text.find("\ncolors:"));
  text.replace(text.find("../cameras"), 2, project_data_dir().string());
  put("blind.yaml", text);
  put("bad.yaml", "scenarios: [" + scenario() + ", blind.yaml]\n");
  const Ending ending = run("sweep bad.yaml -o never --trials 1 --perception image");
  EXPECT_EQ(ending.code, 2);
  EXPECT_THAT(ending.messages, HasSubstr("blind.yaml: colors: found nothing"));
  EXPECT_EQ(names().count("never"), 0u);
}

TEST_F(SuiteTest, TheHardWorldsAreAllThere) {
  const Ending hard = run("sweep '" + (project_data_dir() / "suites" / "hard.yaml").string() +
                          "' -o hard --trials 1 --perception truth --set duration_s=0.2");
  ASSERT_EQ(hard.code, 0) << hard.messages;
  for (const char* name :
       {"corridor", "dead_end", "door", "poles", "dense", "corner", "movers", "flee", "towards", "shelf"})
    EXPECT_THAT(hard.out, HasSubstr(std::string("\n") + name + " ")) << hard.out;
}

TEST_F(SweepTest, AFinishedSweepResumedEndsAsIfItHadJustRun) {
  ASSERT_EQ(sweep("-o one --trials 4").code, 0);
  const Ending ran = sweep("-o two --trials 4 --set law.name=visp --against one --json ran.json");
  ASSERT_EQ(ran.code, 0) << ran.messages;
  ASSERT_EQ(sweep("-o three --trials 4 --set law.name=visp").code, 0);
  const Ending resumed =
      sweep("-o three --trials 4 --set law.name=visp --against one --json resumed.json --resume");
  EXPECT_EQ(resumed.code, 0);
  EXPECT_EQ(resumed.out, ran.out);
  EXPECT_THAT(resumed.messages, HasSubstr("success less that of one"));
  EXPECT_EQ(contents("resumed.json"), contents("ran.json"));
  EXPECT_THAT(contents("resumed.json"), HasSubstr("against"));
  expect_same("two", "three");
  // Without a comparison asked for, the one that is there stays.
  EXPECT_EQ(sweep("-o three --trials 4 --set law.name=visp --json again.json --resume").code, 0);
  EXPECT_THAT(contents("again.json"), Not(HasSubstr("against")));
  expect_same("two", "three");
}

TEST_F(SweepTest, AScenarioIsItselfWhereverItLies) {
  std::filesystem::create_directory_symlink(project_data_dir(), dir / "here");
  const std::string here = "sweep here/scenarios/static_ball.yaml --perception truth --trials 4 ";
  ASSERT_EQ(sweep("-o part_1 --trials 4 --shard 1/2").code, 0);
  EXPECT_EQ(run(here + "-o part_1 --shard 1/2 --resume").code, 0);
  ASSERT_EQ(run(here + "-o part_2 --shard 2/2").code, 0);
  const Ending merge = run("sweep merge part_1 part_2 -o merged");
  EXPECT_EQ(merge.code, 0) << merge.messages;
  EXPECT_THAT(sweep("-o part_1 --trials 3 --shard 1/2 --resume").messages, HasSubstr("differs in trials)"));
  EXPECT_THAT(sweep("-o part_1 --trials 2 --seed 3 --shard 1/2 --resume").messages,
              HasSubstr("differs in first_seed, trials)"));
}

TEST_F(SweepTest, AnInterruptedSweepKeepsWhatIsDoneAndGoesOn) {
  ASSERT_EQ(sweep("-o whole --trials 60 --threads 1").code, 0);
  // As soon as the first trials are noted, however slow the machine is.
  const std::string interrupt =
      R"(sh -c '"$@" & for i in $(seq 500); do [ -s out/unfinished.journal ] && break; sleep 0.02; done; )"
      R"(kill -INT $!; wait $!' sh)";
  const Ending interrupted = sweep("-o out --trials 60 --threads 1", interrupt);
  EXPECT_EQ(interrupted.code, 130);
  EXPECT_EQ(nlohmann::json::parse(contents("out/summary.json")).at("interrupted"), true);
  EXPECT_THAT(interrupted.messages, HasSubstr("--resume"));
  EXPECT_THAT(sweep("-o out --trials 60").messages, HasSubstr("--resume to go on"));
  ASSERT_EQ(sweep("-o out --trials 60 --resume").code, 0);
  expect_same("whole", "out");
}

TEST_F(SweepTest, ASweepAgainstItselfDiffersInNothing) {
  ASSERT_EQ(sweep("-o one --trials 8").code, 0);
  const Ending again = sweep("-o two --trials 8 --set law.name=visp --against one");
  ASSERT_EQ(again.code, 0) << again.messages;
  const auto json = nlohmann::json::parse(contents("two/summary.json")).at("against");
  EXPECT_EQ(json.at("success").at("both"), 8);
  EXPECT_EQ(json.at("success").at("difference"), 0);
  EXPECT_LT(json.at("success").at("difference_ci95")[0], 0);
  EXPECT_GT(json.at("success").at("difference_ci95")[1], 0);
  EXPECT_EQ(json.at("unmatched"), 0);
  EXPECT_EQ(json.at("pairs_with_other_worlds"), 0);
  ASSERT_EQ(sweep("-o three --trials 8 --set balls.0.position.x_m=3 --against one").code, 0);
  EXPECT_EQ(nlohmann::json::parse(contents("three/summary.json")).at("against").at("pairs_with_other_worlds"),
            8);
}

TEST_F(SweepTest, SeedsWhoseWorldCannotBeAreCountedApart) {
  // Beyond 3.2 m the ball would be in a box.
  const Ending ending = sweep(
      "-o out --trials 12 --set "
      "'obstacles=[{type: box, name: far, position: {x_m: 4.2, y_m: 0}, size: {x_m: 2, y_m: 3, z_m: 1}}]'");
  ASSERT_EQ(ending.code, 0) << ending.messages;
  const auto json = nlohmann::json::parse(contents("out/summary.json"));
  EXPECT_GT(json.at("infeasible"), 0);
  EXPECT_EQ(json.at("reached").get<int>() + json.at("infeasible").get<int>(), 12);
  EXPECT_EQ(json.at("success_rate"), 1.0);
}

TEST_F(SweepTest, BadInputIsRefusedInWords) {
  EXPECT_EQ(run("sweep -o out").code, 2);
  EXPECT_THAT(run("sweep -o out").messages, HasSubstr("--trials"));
  for (const char* bad :
       {"--trials 0", "--trials 1e3", "--trials -4", "--trials 3 --shard 4/3", "--trials 3 --shard x",
        "--trials 3 --against nowhere", "--trials 3 --set law.name=nonsense", "--trials 3 --set law.name",
        "--trials 3 --perception guess", "--trials 3 --shard 0/0"}) {
    EXPECT_EQ(run("sweep '" + scenario() + "' -o out " + bad).code, 2) << bad;
  }
  EXPECT_EQ(run("sweep nowhere.yaml -o out --trials 3").code, 2);
  EXPECT_TRUE(names().empty());
  ASSERT_EQ(sweep("-o a --trials 4 --shard 1/2").code, 0);
  ASSERT_EQ(sweep("-o b --trials 5 --shard 2/2").code, 0);
  const Ending merge = run("sweep merge a b -o out");
  EXPECT_EQ(merge.code, 2);
  EXPECT_THAT(merge.messages, HasSubstr("they differ in trials"));
  EXPECT_THAT(merge.messages, HasSubstr("2/2 missing"));
  put("a/trials.csv", contents("a/trials.csv") + "\n");
  EXPECT_THAT(run("sweep merge a -o out").messages, HasSubstr("checksum"));
  EXPECT_EQ(names().count("out"), 0u);
}

TEST_F(SweepTest, AManifestThatSaysTooLittleIsRefusedInWords) {
  ASSERT_EQ(sweep("-o whole --trials 2").code, 0);
  const auto manifest = nlohmann::json::parse(contents("whole/manifest.json"));
  for (const char* key : {"places", "law", "trials", "sets", "drawn"}) {
    for (const bool missing : {true, false}) {
      nlohmann::json less = manifest;
      if (missing) {
        less["job"].erase(key);
      } else {
        less["job"][key] = nullptr;
      }
      put("whole/manifest.json", less.dump());
      const Ending merge = run("sweep merge whole -o out");
      EXPECT_EQ(merge.code, 2) << key;
      EXPECT_THAT(merge.messages, HasSubstr("a manifest that is not a sweep's"));
    }
  }
  EXPECT_EQ(names().count("out"), 0u);
}

}  // namespace
}  // namespace ballservo::test
