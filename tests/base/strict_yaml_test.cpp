#include "calibration/base/strict_yaml.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "tests/support/faults.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using test::faults_of;
using testing::HasSubstr;

/// The faults of reading `text` by `reader`, which includes unknown keys.
std::vector<Fault> reading_faults(const std::string& text, const std::function<void(YamlNode)>& reader) {
  return faults_of([&] {
    StrictYaml yaml = StrictYaml::from_text(text, "file.yaml");
    reader(yaml.root());
    yaml.finish();
  });
}

std::string only(const std::vector<Fault>& faults) {
  std::string all;
  for (const Fault& fault : faults) all += to_text(fault) + "\n";
  EXPECT_EQ(faults.size(), 1u) << all;
  return all;
}

TEST(StrictYaml, ReadsWhatIsThere) {
  StrictYaml yaml = StrictYaml::from_text(
      "duration_s: 30\n"
      "camera: {file: wide.yaml, rate_hz: 30, noise: {read: 1.5}}\n"
      "balls:\n"
      "  - {name: target, diameter_m: 0.12}\n"
      "  - {name: other, diameter_m: .1}\n"
      "matrix: [1, 2.5, -3e-1]\n"
      "flag: true\n"
      "law: cone\n",
      "file.yaml");
  YamlNode root = yaml.root();
  EXPECT_EQ(root.number("duration_s", NumberRange::above(0, "s")), 30);
  YamlNode camera = root.map("camera");
  EXPECT_EQ(camera.text("file"), "wide.yaml");
  EXPECT_EQ(camera.integer("rate_hz", 1, 1000), 30);
  EXPECT_EQ(camera.map("noise").number("read", NumberRange::any("")), 1.5);
  EXPECT_EQ(camera.number("latency_s", NumberRange::at_least(0, "s"), 0.033), 0.033);
  auto balls = root.list("balls");
  ASSERT_EQ(balls.size(), 2u);
  EXPECT_EQ(balls[1].text("name"), "other");
  EXPECT_EQ(balls[1].number("diameter_m", NumberRange::above(0, "m")), 0.1);
  EXPECT_EQ(balls[1].place("diameter_m"), "file.yaml:5: balls[1].diameter_m");
  EXPECT_EQ(balls[0].text("name"), "target");
  EXPECT_EQ(balls[0].number("diameter_m", NumberRange::above(0, "m")), 0.12);
  EXPECT_EQ(root.numbers("matrix", NumberRange::any(""), 3), (std::vector<double>{1, 2.5, -0.3}));
  EXPECT_TRUE(root.boolean("flag"));
  EXPECT_EQ(root.choice("law", {"cone", "visp"}), "cone");
  EXPECT_NO_THROW(yaml.finish());
}

TEST(StrictYaml, NamesEveryFaultAtOnceWithItsLine) {
  const auto faults = reading_faults("a: -1\nb: text\nc: 3\nd: [1, x]\nd: 2\n", [](YamlNode root) {
    root.number("a", NumberRange::above(0, "m"));
    root.number("b", NumberRange::any("m"));
    root.numbers("d", NumberRange::any(""), 2);
    root.number("missing", NumberRange::any("s"));
  });
  std::vector<std::string> texts;
  for (const Fault& fault : faults) texts.push_back(to_text(fault));
  EXPECT_THAT(texts,
              testing::UnorderedElementsAre(
                  "file.yaml:1: a: found -1; allowed: a number above 0 (m)",
                  "file.yaml:2: b: found text; allowed: a finite number (m)",
                  "file.yaml:3: c: found an unknown key; allowed: one of a, b, d, missing",
                  "file.yaml:4: d[1]: found x; allowed: a finite number",
                  "file.yaml:5: d: found the key a second time (first on line 4); allowed: each key once",
                  "file.yaml:1: missing: found nothing; allowed: a finite number (s)"));
}

TEST(StrictYaml, TellsNumbersFromText) {
  const auto read = [](YamlNode root) { root.number("a", NumberRange::any("")); };
  for (const char* value : {"\"1\"", "'1'", ".nan", ".inf", "-.inf", "nan", "0x10", "1,5", "1e999", "[1]",
                            "{b: 1}", "|\n  1", "~", ""}) {
    EXPECT_EQ(reading_faults("a: " + std::string(value) + "\n", read).size(), 1u) << value;
  }
  for (const char* value : {"\"true\"", "yes", "1", "True"}) {
    EXPECT_EQ(
        reading_faults("a: " + std::string(value) + "\n", [](YamlNode root) { root.boolean("a"); }).size(),
        1u);
  }
  StrictYaml yaml = StrictYaml::from_text("a: 010\nb: '010'\n", "f");
  EXPECT_EQ(yaml.root().integer("a", 0, 100), 10);
  EXPECT_EQ(yaml.root().text("b"), "010");
}

TEST(StrictYaml, RefusesWholeDocumentsThatAreHostile) {
  std::string deep = "a: ";
  for (int i = 0; i < 40; ++i) deep += "[";
  const std::string endless = "a: " + std::string(1000000, '[');
  for (const std::string& text :
       {std::string("a: &x 1\n"), std::string("a: &x [1]\nb: *x\n"), std::string("a: 1\n---\nb: 2\n"),
        std::string("a: \xFF\n"), std::string("a: \xC0\xAF\n"), std::string("a: \xED\xA0\x80\n"),
        std::string("a: b\0c\n", 7), std::string("a: !!str 1\n"), std::string("? [a]\n: 1\n"),
        std::string("a: b: c\n"), std::string("a: [1\n"), std::string("{a: 1"), std::string("\t- a"), deep,
        endless, std::string("a: \"\x1b\"\n"), std::string("%YAML 1.2 3\n---\na: 1\n")}) {
    EXPECT_THROW(StrictYaml::from_text(text, "f").root(), InputError) << text.substr(0, 40);
  }
  EXPECT_THROW(StrictYaml::from_text(std::string(StrictYaml::max_bytes + 1, '\n'), "f"), InputError);
}

TEST(StrictYaml, SaysWhichLineIsNoYaml) {
  EXPECT_THAT(only(faults_of([] { StrictYaml::from_text("a: 1\nb: [2\nc: 3\n", "f.yaml"); })),
              HasSubstr("f.yaml:"));
  EXPECT_THAT(only(faults_of([] { StrictYaml::from_text("a: 1\nb: \xFF\n", "f.yaml"); })),
              HasSubstr("f.yaml:2:"));
  EXPECT_THAT(only(faults_of([] { StrictYaml::from_text("a: 1\nb: *x\n", "f.yaml"); })),
              HasSubstr("f.yaml:2"));
}

TEST(StrictYaml, AnEmptyFileIsOneFault) {
  for (const char* text : {"", "\n", " \t\r\n"})
    EXPECT_THAT(only(faults_of([&] { StrictYaml::from_text(text, "f.yaml"); })), HasSubstr("an empty file"));
}

TEST(StrictYaml, MissesAnEmptyDocumentOnlyWhereKeysAreRequired) {
  EXPECT_TRUE(reading_faults("# nothing\n", [](YamlNode root) {
                root.number("a", NumberRange::any(""), 1.0);
              }).empty());
  EXPECT_EQ(
      reading_faults("# nothing\n", [](YamlNode root) { root.number("a", NumberRange::any("")); }).size(),
      1u);
  only(reading_faults("[1, 2]\n", [](YamlNode root) {
    root.number("a", NumberRange::any(""));
    root.number("b", NumberRange::any(""));
  }));
}

TEST(StrictYaml, ReportsAMissingMapOnceAndNotItsKeys) {
  EXPECT_THAT(only(reading_faults("a: 1\n",
                                  [](YamlNode root) {
                                    root.number("a", NumberRange::any(""));
                                    root.map("camera").map("noise").number("read", NumberRange::any(""));
                                  })),
              HasSubstr("camera: found nothing"));
  EXPECT_THAT(only(reading_faults("a: {b: 1, c: {d: 1}}\n",
                                  [](YamlNode root) { root.number("a", NumberRange::any("")); })),
              HasSubstr("a: found a map"));
}

TEST(StrictYaml, FindsUnknownKeysAtAnyDepth) {
  EXPECT_THAT(only(reading_faults("balls:\n  - {name: x}\n  - name: y\n    colour: red\n",
                                  [](YamlNode root) {
                                    for (YamlNode ball : root.list("balls")) ball.text("name");
                                  })),
              HasSubstr("file.yaml:4: balls[1].colour: found an unknown key; allowed: one of name"));
  EXPECT_THAT(only(reading_faults("<<: {a: 1}\n", [](YamlNode) {})), HasSubstr("unknown key"));
}

TEST(StrictYaml, TakesAReadersOwnFaults) {
  EXPECT_THAT(only(reading_faults("x:\n  file: none\n",
                                  [](YamlNode root) { root.map("x").fault("file", "none", "a file"); })),
              HasSubstr("file.yaml:2: x.file: found none; allowed: a file"));
}

TEST(StrictYamlSet, ReplacesAndCreates) {
  StrictYaml yaml = StrictYaml::from_text("camera: {rate_hz: 30}\nballs: [{d: 1}, {d: 2}]\n", "f");
  yaml.set("camera.rate_hz", "60");
  yaml.set("camera.noise.read", "1.5");
  yaml.set("balls.1.d", "[3, 4]");
  yaml.set("balls[0].d", "5");
  EXPECT_EQ(yaml.resolved_json(),
            R"({"balls":[{"d":5},{"d":[3,4]}],"camera":{"noise":{"read":1.5},"rate_hz":60}})");
  YamlNode camera = yaml.root().map("camera");
  EXPECT_EQ(camera.place("rate_hz"), "--set: camera.rate_hz");
  EXPECT_EQ(camera.number("rate_hz", NumberRange::any("")), 60);
}

TEST(StrictYamlSet, FaultsAreFoundLikeThoseOfTheFile) {
  const auto faults = faults_of([] {
    StrictYaml yaml = StrictYaml::from_text("a: 1\nb: [1]\n", "f");
    yaml.set("a.c", "1");
    yaml.set("b.1", "1");
    yaml.set("b.x", "1");
    yaml.set("", "1");
    yaml.set("d", "[1");
    yaml.set("e", "nan");
    yaml.set("unknown.key", "1");
    yaml.root().number("a", NumberRange::any(""));
    yaml.root().numbers("b", NumberRange::any(""), 1);
    yaml.root().number("e", NumberRange::any(""));
    yaml.finish();
  });
  EXPECT_EQ(faults.size(), 7u);
  for (const Fault& fault : faults) EXPECT_THAT(fault.place, HasSubstr("--set")) << to_text(fault);
}

TEST(StrictYaml, RefusesFilesThatCannotBeRead) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(StrictYaml::from_file(folder.path() / "none.yaml"), InputError);
  EXPECT_THROW(StrictYaml::from_file(folder.path()), InputError);
}

TEST(NumberRange, HoldsItsEndsAsItSays) {
  EXPECT_FALSE(NumberRange::above(0, "m").contains(0));
  EXPECT_TRUE(NumberRange::at_least(0, "m").contains(0));
  EXPECT_TRUE(NumberRange::within(0, 1, "").contains(1));
  EXPECT_FALSE(NumberRange::any("").contains(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(NumberRange::within(0, 1, "m").to_text(), "a number from 0 to 1 (m)");
  EXPECT_EQ((NumberRange{0, 1, true, ""}).to_text(), "a number above 0 up to 1");
}

// Whatever the bytes, reading ends in a document or an InputError.
TEST(StrictYaml, SurvivesDamagedDocuments) {
  const std::string whole =
      "# comment\nduration_s: 30\ncamera: {file: 'a b', list: [1, 2, {x: y}]}\nballs:\n  - name: \"q\\n\"\n  "
      "  d: |\n"
      "      text\n  - [1, 2]\n? last\n: x\n...\n";
  std::mt19937 engine(3);
  int read = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text = whole.substr(0, 1 + engine() % whole.size());
    for (unsigned k = engine() % 4; k > 0; --k) {
      const char* tokens = "{}[]:,-?&*!|>'\"%@`#\n\t \\~a0\x80\xC3";
      text[engine() % text.size()] = tokens[engine() % 28];
    }
    try {
      StrictYaml yaml = StrictYaml::from_text(text, "f");
      YamlNode root = yaml.root();
      for (const std::string& key : root.keys()) root.has(key);
      yaml.set("camera.list.2.x", "1");
      yaml.resolved_json();
      ++read;
      yaml.finish();
    } catch (const InputError& error) {
      EXPECT_FALSE(error.faults().empty());
    }
  }
  EXPECT_GT(read, 100);
}

}  // namespace
}  // namespace ballservo
