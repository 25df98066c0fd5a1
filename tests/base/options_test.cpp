#include "calibration/base/options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "tests/support/faults.hpp"

namespace ballservo {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

enum class Shape { disc, box };

struct Part {
  double speed_mps = 0.5;
  std::array<double, 2> range_m{1, 2};
};
void declare(OptionVisitor& v, Part& part) {
  v.number("speed_mps", part.speed_mps, NumberRange::above(0, 10, "m/s"), "how fast");
  v.vector("range_m", part.range_m, NumberRange::at_least(0, "m"), "how far");
  v.require(part.range_m[0] <= part.range_m[1], "range_m", "falling", "rising");
}
}  // namespace

struct Thing {  // not in the unnamed namespace: `part` finds what stands beside it
  double size_m = 0;
};
void declare(OptionVisitor& v, Thing& thing) {
  v.number("size_m", thing.size_m, NumberRange::above(0, "m"), "how large", required);
}

namespace {

struct Sample {
  int count = 3;
  bool on = true;
  std::string name = "x";
  Shape shape = Shape::disc;
  double height_m = 0.2, radius_m = 0.1;
  std::optional<double> angle_rad;
  Part part;
  std::optional<Thing> thing;
  std::vector<Thing> things;
  std::vector<std::string> words;
};
void declare(OptionVisitor& v, Sample& s) {
  v.integer("count", s.count, 1, 9, "how many");
  v.boolean("on", s.on, "whether");
  v.text("name", s.name, "what it is called");
  v.one_of("shape", s.shape, {{"disc", Shape::disc}, {"box", Shape::box}}, "which");
  v.only_if(s.shape == Shape::box, "shape: box",
            [&] { v.number("height_m", s.height_m, NumberRange::within(0, 1, "m"), "of the box"); });
  v.only_if(s.shape == Shape::disc, "shape: disc",
            [&] { v.number("radius_m", s.radius_m, NumberRange::within(0, 1, "m"), "of the disc"); });
  v.maybe("angle_rad", s.angle_rad, [&](const std::string& key, double& angle_rad) {
    v.number(key, angle_rad, NumberRange::within(-1, 1, "rad"), "turned", otherwise("by chance"));
  });
  v.map("part", [&] { declare(v, s.part); });
  v.maybe("thing", s.thing, [&](const std::string& key, Thing& thing) { v.part(key, thing); });
  v.list("things", s.things.size(), {}, [&](std::size_t i) {
    if (i == s.things.size()) s.things.emplace_back();
    declare(v, s.things[i]);
  });
  v.texts("words", s.words, "any words");
}

Sample read(const std::string& text) {
  StrictYaml yaml = StrictYaml::from_text(text, "f.yaml");
  OptionReader reader(yaml, yaml.root());
  Sample sample;
  declare(reader, sample);
  yaml.finish();
  return sample;
}

std::vector<std::string> texts_of(const std::vector<Fault>& faults) {
  std::vector<std::string> texts;
  for (const Fault& fault : faults) texts.push_back(to_text(fault));
  return texts;
}

std::vector<std::string> option_faults(const std::string& text) {
  return texts_of(test::faults_of([&] { read(text); }));
}

std::vector<std::string> sample_faults(const Sample& sample) {
  FaultList faults;
  Sample copy = sample;
  OptionChecker checker(faults, "sample");
  declare(checker, copy);
  return texts_of(faults.faults());
}

TEST(OptionReader, ReadsWhatTheFileSaysAndKeepsTheRest) {
  const Sample plain = read("{}");
  EXPECT_EQ(plain.count, 3);
  EXPECT_EQ(plain.part.speed_mps, 0.5);
  EXPECT_FALSE(plain.angle_rad || plain.thing);
  const Sample sample = read(
      "count: 4\non: false\nname: y\nshape: box\nheight_m: 0.7\nangle_rad: 0.5\npart: {range_m: [3, 4]}\n"
      "thing: {size_m: 2}\nthings: [{size_m: 1}, {size_m: 5}]\nwords: [a, b]\n");
  EXPECT_EQ(sample.count, 4);
  EXPECT_FALSE(sample.on);
  EXPECT_EQ(sample.name, "y");
  EXPECT_EQ(sample.shape, Shape::box);
  EXPECT_EQ(sample.height_m, 0.7);
  EXPECT_EQ(sample.angle_rad, 0.5);
  EXPECT_EQ(sample.part.speed_mps, 0.5);
  EXPECT_THAT(sample.part.range_m, ElementsAre(3, 4));
  EXPECT_EQ(sample.thing.value().size_m, 2);
  ASSERT_EQ(sample.things.size(), 2u);
  EXPECT_EQ(sample.things[1].size_m, 5);
  EXPECT_THAT(sample.words, ElementsAre("a", "b"));
}

TEST(OptionReader, SaysEveryFaultAtOnce) {
  EXPECT_THAT(
      option_faults(
          "count: 10\non: yes\nshape: ball\nheight_m: 0.5\npart:\n  speed_mps: 0\n  range_m: [2, 1]\n"
          "thing: {}\nthings:\n  - {size_m: .nan}\nunknown: 1\n"),
      testing::UnorderedElementsAre(
          "f.yaml:1: count: found 10; allowed: a whole number from 1 to 9",
          "f.yaml:2: on: found yes; allowed: true or false",
          "f.yaml:3: shape: found ball; allowed: one of disc, box", HasSubstr("f.yaml:4: height_m: found an"),
          "f.yaml:6: part.speed_mps: found 0; allowed: a number above 0 up to 10 (m/s)",
          "f.yaml:7: part.range_m: found falling; allowed: rising",
          "f.yaml:8: thing.size_m: found nothing; allowed: a number above 0 (m)",
          "f.yaml:10: things[0].size_m: found .nan; allowed: a number above 0 (m)",
          HasSubstr("f.yaml:11: unknown: found an unknown key")));
}

TEST(OptionChecker, JudgesAStructByTheSameDeclaration) {
  Sample sample;
  EXPECT_THAT(sample_faults(sample), ElementsAre());
  sample.count = 0;
  sample.radius_m = 2;
  sample.height_m = 2;  // of a box, which it is not
  sample.angle_rad = std::numeric_limits<double>::quiet_NaN();
  sample.part.speed_mps = std::numeric_limits<double>::infinity();
  sample.part.range_m = {2, 1};
  sample.thing = Thing{-1};
  sample.things = {{1}, {0}, {std::numeric_limits<double>::infinity()}};
  EXPECT_THAT(sample_faults(sample),
              ElementsAre("sample.count: found 0; allowed: a whole number from 1 to 9",
                          "sample.radius_m: found 2; allowed: a number from 0 to 1 (m)",
                          "sample.angle_rad: found NaN; allowed: a number from -1 to 1 (rad)",
                          "sample.part.speed_mps: found inf; allowed: a number above 0 up to 10 (m/s)",
                          "sample.part.range_m: found falling; allowed: rising",
                          "sample.thing.size_m: found -1; allowed: a number above 0 (m)",
                          "sample.things[1].size_m: found 0; allowed: a number above 0 (m)",
                          "sample.things[2].size_m: found inf; allowed: a number above 0 (m)"));
}

TEST(OptionLister, ListsEveryAlternative) {
  Sample sample;
  OptionLister lister;
  declare(lister, sample);
  std::vector<std::string> lines;
  for (const OptionRow& row : lister.rows()) {
    std::string line = row.path + "|" + row.unit + "|" + row.fallback + "|" + row.allowed + "|" + row.help;
    for (const std::string& condition : row.conditions) line += "|" + condition;
    lines.push_back(line);
  }
  EXPECT_THAT(
      lines,
      ElementsAre("count||3|whole, [1, 9]|how many", "on||true|true, false|whether",
                  "name||x|text|what it is called", "shape||disc|disc, box|which",
                  "height_m|m|0.2|[0, 1]|of the box|shape: box",
                  "radius_m|m|0.1|[0, 1]|of the disc|shape: disc", "angle_rad|rad|by chance|[-1, 1]|turned",
                  "part.speed_mps|m/s|0.5|(0, 10]|how fast", "part.range_m|m|[1, 2]|2 in [0, inf)|how far",
                  "thing.size_m|m|required|(0, inf)|how large",
                  "things[].size_m|m|required|(0, inf)|how large", "words||[]|a list of texts|any words"));
  const std::string page = option_page("sample", lister.rows());
  EXPECT_THAT(page, HasSubstr("# Every key of a sample"));
  EXPECT_THAT(page, HasSubstr("| `things[].size_m` | m    | required | (0, inf) | how large |\n"));
}

TEST(NumberFinder, ReachesOneNumberByItsPath) {
  Sample sample;
  const auto set = [&sample](const std::string& path, double value) {
    bool found = false;
    NumberFinder finder(path, [&](double& number, const Option&) {
      number = value;
      found = true;
    });
    declare(finder, sample);
    return found;
  };
  EXPECT_TRUE(set("part.speed_mps", 7));
  EXPECT_EQ(sample.part.speed_mps, 7);
  EXPECT_TRUE(set("angle_rad", 0.25));
  EXPECT_EQ(sample.angle_rad, 0.25);
  EXPECT_FALSE(set("angle", 1) || set("part", 1) || set("count", 1) || set("", 1));
  EXPECT_FALSE(sample.thing);
}

}  // namespace
}  // namespace ballservo
