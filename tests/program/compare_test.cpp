// Comparisons from outside: the same bytes however they are split, killed and resumed; bad input.
#include "tests/program/program_run.hpp"

namespace ballservo {
namespace {

using testing::HasSubstr;

const char* const plan =
    "seed: 4\nframes: 8\nmethods: [vote, paper_one_step, paper_steps_2, paper_converged, hsv_contour]\n"
    "defaults: {camera: {focal_px: 200, width_px: 160, height_px: 120}, noise: {read: 2}, blur_px: 0.7, "
    "depth_m: 0.4}\n"
    "conditions: [{name: base}, {name: noisy, noise: {read: 6}}]\n"
    // Not in the alphabet's order, which is not that of the conditions.
    "design: {type: one_at_a_time, vary: {occlusion: [0.4], blur_px: [1.5]}}\n";

class CompareTest : public test::ProgramTest {
 protected:
  void SetUp() override { put("plan.yaml", plan); }
  std::vector<std::string> pictures_of(const std::string& page) const {
    std::vector<std::string> pictures;
    const std::string html = contents(page), mark = "src=\"data:image/";
    for (std::size_t at = html.find(mark); at != std::string::npos; at = html.find(mark, at + 1))
      pictures.push_back(html.substr(at, html.find('"', at + mark.size()) - at));
    return pictures;
  }
  void expect_same(const std::string& a, const std::string& b) const {
    for (const char* name : {"/compare.csv", "/fits.csv", "/frames.csv", "/pairs.csv", "/tests.csv",
                             "/certificate.csv", "/tables.tex"}) {
      EXPECT_FALSE(contents(a + name).empty()) << name;
      EXPECT_EQ(contents(a + name), contents(b + name)) << name;
    }
  }
};

TEST_F(CompareTest, PartsKilledAndResumedMergeIntoTheWhole) {
  pages_drawn = true;
  ASSERT_EQ(run("compare plan.yaml -o whole --threads 1 --quiet --json ran.json").code, 0);
  pages_drawn = false;
  ASSERT_EQ(run("compare plan.yaml -o whole --quiet --resume --json resumed.json").code, 0);
  EXPECT_EQ(contents("resumed.json"), contents("ran.json"));
  for (const char* part : {"1", "2"}) {
    const std::string command = std::string("compare plan.yaml --threads 2 --quiet --resume -o part_") +
                                part + " --shard " + part + "/2";
    run(command, "timeout -s KILL 0.7");
    run(command, "timeout -s KILL 1.1");
    ASSERT_EQ(run(command).code, 0);
    EXPECT_EQ(run(command).code, 0);  // nothing is left to be done
  }
  pages_drawn = true;
  ASSERT_EQ(run("compare merge part_2 part_1 -o merged --quiet").code, 0);
  expect_same("whole", "merged");
  EXPECT_GT(pictures_of("whole/report.html").size(), 8u);
  EXPECT_EQ(pictures_of("merged/report.html"), pictures_of("whole/report.html"));
  const test::Ending missing = run("compare merge part_1 -o too_few");
  EXPECT_EQ(missing.code, 2);
  EXPECT_THAT(missing.messages, HasSubstr("2/2"));
  EXPECT_THAT(run("compare merge whole -o again").messages, HasSubstr("whole: found a whole comparison"));
  EXPECT_EQ(run("compare merge part_1 part_2 -o merged").code, 2);  // it is there already
  // Another plan's folder is not gone on with.
  put("plan.yaml", std::string(plan) + "claims: paper\n");
  EXPECT_EQ(run("compare plan.yaml -o part_1 --shard 1/2 --resume").code, 2);
}

TEST_F(CompareTest, EndsWithItsAnswerAndThePathOfItsPage) {
  pages_drawn = true;
  const std::string out = run("compare plan.yaml -o answered").out;
  EXPECT_THAT(out, testing::StartsWith("Nearest to the truth in 3-D: "));
  EXPECT_THAT(out, HasSubstr("one step is enough in "));
  EXPECT_THAT(out, testing::EndsWith((dir / "answered/report.html\n").string()));
  EXPECT_EQ(run("compare plan.yaml -o answered --resume").out, out);
  EXPECT_EQ(run("compare plan.yaml -o answered --resume --quiet").out, "");
  EXPECT_THAT(contents("answered/report.html"), HasSubstr("<h1>plan: is one step enough?</h1>"));
}

TEST_F(CompareTest, RefusesWhatCannotBeMeant) {
  put("huge.yaml", "frames: 1000000000\nconditions: [{name: a}]\n");
  const test::Ending huge = run("compare huge.yaml -o huge");
  EXPECT_EQ(huge.code, 2);
  EXPECT_THAT(huge.messages, HasSubstr("--force"));
  EXPECT_THAT(huge.messages, HasSubstr("days"));
  put("bad.yaml", "methods: [best]\nconditions: [{name: a, colour: red}]\n");
  const test::Ending bad = run("compare bad.yaml -o bad --shard 3/2");
  EXPECT_EQ(bad.code, 2);
  for (const char* fault : {"best", "colour", "--shard"}) EXPECT_THAT(bad.messages, HasSubstr(fault));
  EXPECT_EQ(run("compare plan.yaml").code, 2);
  EXPECT_EQ(run("compare -o nothing").code, 2);
  EXPECT_EQ(run("compare --images nowhere --truth none.csv --start truth -o x").code, 2);
  EXPECT_EQ(run("compare plan.yaml --images . --truth none.csv -o x").code, 2);
  EXPECT_EQ(names().count("huge") + names().count("bad") + names().count("x"), 0u);
}

TEST_F(CompareTest, UsersPictures) {
  put_grey_picture("grey.png");
  put("truth.csv", "source,cx_px,cy_px,r_px\ngrey.png,80,60,20\n");
  const auto ending = run("compare --images . --truth truth.csv --start truth -o own");
  ASSERT_EQ(ending.code, 0);
  EXPECT_THAT(ending.messages, HasSubstr("without --colors"));
  EXPECT_THAT(contents("own/fits.csv"), HasSubstr("pictures,grey.png,0,vote,1,"));
  EXPECT_THAT(contents("own/fits.csv"), HasSubstr("pictures,grey.png,0,hough_gradient,0,,"));
}

}  // namespace
}  // namespace ballservo
