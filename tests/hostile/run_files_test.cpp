// Outputs that would take the place of what the run reads, or of each other; earlier results under Ctrl-C.
#include "app/io/run_files.hpp"

#include "calibration/base/fault.hpp"
#include "tests/hostile/commands.hpp"

namespace ballservo {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class RunFilesTest : public test::Hostile {
 protected:
  RunFilesTest() {
    put("camera.yaml", "a camera");
    put("camera.yaml.covariance.json", "{}");
    fs::create_directories(dir / "pictures");
    put("pictures/a.png", "a picture");
    put("pictures/camera.yaml", "of an earlier run");
    fs::create_directories(dir / "results");
    put("results/manifest.json", "{}");
    put("results/trials.csv", "1");
    fs::create_symlink("camera.yaml", dir / "link");
    fs::create_hard_link(dir / "camera.yaml", dir / "twin");
    fs::create_directory_symlink("pictures", dir / "album");
  }
  bool clash(const std::string& output, const std::string& input) const {
    RunFiles files;
    files.writes("--json", dir / output, false);
    try {
      files.reads("--camera", dir / input);
    } catch (const InputError&) {
      return true;
    }
    return false;
  }
  std::string scenario() const {
    return "'" + (test::project_data_dir() / "scenarios/static_ball.yaml").lexically_normal().string() + "'";
  }
};

TEST_F(RunFilesTest, AnInputIsKnownByItsInode) {
  for (const char* output :
       {"camera.yaml", "pictures/../camera.yaml", "link", "twin", "camera.yaml.covariance.json"})
    EXPECT_TRUE(clash(output, "camera.yaml")) << output;
  EXPECT_TRUE(clash("camera.yaml", "link"));
  EXPECT_FALSE(clash("new.yaml", "camera.yaml"));
}

TEST_F(RunFilesTest, AFolderIsReadForItsPicturesAndAFolderOfResultsWhole) {
  EXPECT_TRUE(clash("pictures/a.png", "album"));
  EXPECT_TRUE(clash("album", "pictures"));
  EXPECT_TRUE(clash("pictures", "pictures/a.png"));
  EXPECT_FALSE(clash("pictures/camera.yaml", "pictures"));
  EXPECT_FALSE(clash("pictures/found", "pictures"));
  EXPECT_TRUE(clash("results/trials.csv", "results"));
}

TEST_F(RunFilesTest, OutputsHaveNamesOfTheirOwn) {
  RunFiles files;
  files.writes("-o", dir / "new.yaml", false);
  EXPECT_THROW(files.writes("--json", dir / "pictures" / ".." / "new.yaml", false), InputError);
  EXPECT_THROW(files.writes("--json", dir / "new.yaml.covariance.json", false), InputError);
  EXPECT_THROW(files.writes("--json", "", true), InputError);
  EXPECT_THROW(files.writes("--json", std::string(300, 'x'), true), InputError);
  EXPECT_THROW(files.writes("--report", "-", false), InputError);
  EXPECT_NO_THROW(files.writes("--json", "-", true));
  EXPECT_NO_THROW(files.require(dir / "new.yaml"));
  EXPECT_THROW(files.require(dir / "other.yaml"), std::logic_error);
}

TEST_F(RunFilesTest, WhatAKilledRunLeftGoesWithTheNext) {
  put(".new.partial-999999999-0.yaml", "half");
  put(".new.partial-1-0.yaml", "of one at work");
  RunFiles().writes("-o", dir / "new.yaml", false);
  EXPECT_EQ(names().count(".new.partial-999999999-0.yaml"), 0u);
  EXPECT_EQ(names().count(".new.partial-1-0.yaml"), 1u);
}

TEST_F(RunFilesTest, WhatAScenarioNamesIsReadToo) {
  for (const char* of : {"cameras/wide.yaml", "colors/red.colors"}) {
    const fs::path file = test::project_data_dir() / of;
    fs::copy_file(file, dir / file.filename());
  }
  std::ifstream stream(test::project_data_dir() / "scenarios/static_ball.yaml");
  const std::string text = (std::stringstream() << stream.rdbuf()).str();
  put("s.yaml", std::regex_replace(text, std::regex(R"(\.\./[a-z]*/)"), ""));
  for (const char* command : {"render s.yaml -o out", "servo s.yaml -o out", "servo s.yaml --teach -o out",
                              "sweep s.yaml --trials 1 -o out"})
    for (const char* input : {"s.yaml", "wide.yaml", "red.colors"}) {
      const auto ending = run(std::string(command) + " --force --json " + input);
      EXPECT_EQ(ending.code, 2) << command << input;
      EXPECT_THAT(ending.messages, HasSubstr("which is read")) << command << input;
    }
  EXPECT_EQ(run("servo s.yaml --teach -o s.yaml --force").code, 2);
  EXPECT_EQ(run("servo s.yaml --perception truth -o . --force").code, 2);
}

TEST_F(RunFilesTest, AnInterruptedRunLeavesTheEarlierResult) {
  for (const std::string& command :
       {"servo " + scenario() + " --perception truth -o out --force --json out.json",
        "sweep " + scenario() + " --trials 9 --perception truth -o all --force --json all.json"}) {
    ASSERT_EQ(run(command).code, 0);
    std::map<std::string, std::string> before;
    for (const std::string file :
         {"out/log.csv", "out/summary.json", "out.json", "all/trials.csv", "all/manifest.json", "all.json"})
      before[file] = contents(file);
    std::string longer = std::regex_replace(command, std::regex("--trials 9 --perception truth"),
                                            "--trials 900 --perception image");
    longer = std::regex_replace(longer, std::regex("--perception truth"), "--perception image");
    EXPECT_EQ(run(longer, "timeout --preserve-status -s INT 1").code, 130);
    for (const auto& [file, held] : before) EXPECT_EQ(contents(file), held) << file;
  }
}

TEST_F(RunFilesTest, JsonOnStdoutIsAlone) {
  const auto ending = run("servo " + scenario() + " --perception truth -o out --json -");
  EXPECT_EQ(ending.code, 0);
  EXPECT_EQ(ending.out.front(), '{');
  EXPECT_THAT(ending.out, testing::Not(HasSubstr("reached\n")));
}

}  // namespace
}  // namespace ballservo
