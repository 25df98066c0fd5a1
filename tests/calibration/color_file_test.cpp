#include "calibration/color/color_file.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "calibration/base/checksum.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/output.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

ColorTable example() {
  ColorTable colors;
  colors.classes.resize(2);
  colors.classes[0].name = "red";
  colors.classes[0].samples = 120;
  colors.classes[0].histogram.counts[5] = 100;
  colors.classes[0].histogram.counts[16000] = 20;
  colors.classes[0].cells = {{7, 90}, {262143, 30}};
  colors.classes[1].name = "green_2";
  colors.background = {{0, 5}, {9, 4000000000u}};
  colors.camera_settings = {{"exposure", 156}, {"gain", 0.5}};
  for (int i = 0; i < ColorTable::entries; i += 7) colors.table[i] = static_cast<ClassIndex>(i % 3);
  return colors;
}

/// The file with its body changed and its checksum made to fit again.
std::string with_body(const std::function<void(std::string&)>& change) {
  const std::string bytes = color_file_bytes(example());
  const auto body_at = bytes.find("settings ");
  std::string body = bytes.substr(body_at);
  change(body);
  return "ballservo colors\nversion 2\nsha256 " + sha256_hex(body) + "\n" + body;
}

void replace(std::string& text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  ASSERT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
}

/// The text of the fault, or "accepted".
std::string fault_of(const std::string& bytes) {
  try {
    parse_color_file(bytes, "my.colors");
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().size(), 1u);
    EXPECT_EQ(error.faults()[0].place.find("my.colors"), 0u);
    return to_text(error.faults()[0]);
  }
  return "accepted";
}

TEST(ColorFile, RoundTrip) {
  const ColorTable colors = example();
  const std::string bytes = color_file_bytes(colors);
  const ColorTable read = parse_color_file(bytes, "x");
  EXPECT_EQ(read.table, colors.table);
  ASSERT_EQ(read.classes.size(), 2u);
  EXPECT_EQ(read.classes[0].name, "red");
  EXPECT_EQ(read.classes[0].samples, 120u);
  EXPECT_EQ(read.classes[0].histogram.counts, colors.classes[0].histogram.counts);
  ASSERT_EQ(read.classes[0].cells.size(), 2u);
  EXPECT_EQ(read.classes[0].cells[1].cell, 262143u);
  EXPECT_EQ(read.classes[0].cells[1].count, 30u);
  ASSERT_EQ(read.background.size(), 2u);
  EXPECT_EQ(read.background[1].count, 4000000000u);
  EXPECT_EQ(read.camera_settings, colors.camera_settings);
  EXPECT_EQ(color_file_bytes(read), bytes);
  EXPECT_EQ(color_file_bytes(parse_color_file(color_file_bytes(ColorTable{}), "x")),
            color_file_bytes(ColorTable{}));
}

TEST(ColorFile, FromDisk) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "a.colors";
  write_file(file, color_file_bytes(example()), Overwrite::refuse);
  EXPECT_EQ(read_color_file(file).table, example().table);
  EXPECT_THROW(read_color_file(folder.path() / "missing.colors"), InputError);
  EXPECT_THROW(read_color_file(folder.path()), InputError);
}

TEST(ColorFile, EveryTruncationIsRefused) {
  const std::string bytes = color_file_bytes(example());
  for (std::size_t length = 0; length < bytes.size(); length += length < 400 ? 1 : 4001) {
    EXPECT_NE(fault_of(bytes.substr(0, length)), "accepted") << length;
  }
  EXPECT_NE(fault_of(bytes.substr(0, bytes.size() - 1)), "accepted");
}

TEST(ColorFile, EveryChangedByteIsRefused) {
  const std::string bytes = color_file_bytes(example());
  for (std::size_t at = 0; at < bytes.size(); at += at < 400 ? 1 : 1009) {
    std::string changed = bytes;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    EXPECT_NE(fault_of(changed), "accepted") << at;
  }
}

TEST(ColorFile, NamesWhatIsWrong) {
  std::string other_version = color_file_bytes(example());
  replace(other_version, "version 2", "version 1");
  EXPECT_NE(fault_of(other_version).find("version"), std::string::npos);
  EXPECT_NE(fault_of(other_version).find("learn the colours again"), std::string::npos);
  replace(other_version, "version 1", "version 3");
  EXPECT_NE(fault_of(other_version).find("by a newer program"), std::string::npos);
  std::string other_sum = color_file_bytes(example());
  replace(other_sum, "\nclass red 120", "\nclass red 121");
  EXPECT_NE(fault_of(other_sum).find("checksum"), std::string::npos);
  EXPECT_NE(fault_of("").find("empty"), std::string::npos);
  EXPECT_NE(fault_of("\x89PNG\r\n").find("ballservo colors"), std::string::npos);
  EXPECT_NE(fault_of(std::string(color_file_max_bytes + 1, 'x')).find("bytes"), std::string::npos);
}

TEST(ColorFile, ContentsThatContradictThemselves) {
  const std::vector<std::pair<std::string, std::string>> changes = {
      {"classes 2", "classes 3"},
      {"classes 2", "classes 16"},
      {"classes 2", "classes -1"},
      {"classes 2", "classes 99999999999999999999"},
      {"class red", "class Red"},
      {"class red", "class 1red"},
      {"class red", "class red/../x"},
      {"class red", "class "},
      {"class red", "class green_2"},
      {"red 120", "red 119"},  // the histogram counts more
      {"red 120", "red 1e2"},
      {"red 120 2 2", "red 120 16385 2"},
      {"red 120 2 2", "red 120 3 2"},
      {"red 120 2 2", "red 120 2 262145"},
      {"red 120 2 2", "red 120 2 3"},
      {"red 120 2 2", "red 120 2"},
      {"\n7 90", "\n7 0"},
      {"\n7 90", "\n7 91"},       // the cells count more than the samples
      {"\n7 90", "\n262143 90"},  // out of order
      {"\n262143 30", "\n262144 30"},
      {"background 2", "background 1"},
      {"background 2", "background -2"},
      {"settings 2", "settings 65"},
      {"settings 2", "settings 1"},
      {"exposure 156", "exposure nan"},
      {"exposure 156", "Exposure 156"},
      {"exposure 156", "gain 156"},  // twice
      {"\n5 0 100", "\n5 0 0"},
      {"\n5 0 100", "\n5 0 4294967296"},
      {"\n5 0 100", "\n128 0 100"},
      {"\n5 0 100", "\n5 128 100"},
      {"\n5 0 100", "\n0 126 100"},  // out of order
      {"\n5 0 100", "\n 5 0 100"},
      {"\n5 0 100", "\n5 0 nan"},
      {"\n1 1\n", "\n1 3\n"},  // a class number without a class
      {"\n1 1\n", "\n2 1\n"},  // too many entries
      {"\n1 1\n", "\n0 1\n"},
      {"\n1 1\n", "\n262144 1\n"},
      {"\nend\n", "\nend\nmore\n"},
      {"\nend\n", "\nEnd\n"},
      {"\nend\n", "\n"},
  };
  for (const auto& [from, to] : changes) {
    const std::string bytes =
        with_body([&, from = from, to = to](std::string& body) { replace(body, from, to); });
    const std::string fault = fault_of(bytes);
    EXPECT_NE(fault, "accepted") << from << " -> " << to;
    EXPECT_EQ(fault.find("checksum"), std::string::npos) << from << " -> " << to;
  }
  EXPECT_EQ(fault_of(with_body([](std::string&) {})), "accepted");
}

TEST(ColorFile, WhatCouldNotBeReadBackIsNotWritten) {
  ColorTable colors = example();
  colors.table[3] = 3;
  EXPECT_THROW(color_file_bytes(colors), std::invalid_argument);
  colors = example();
  colors.table.pop_back();
  EXPECT_THROW(color_file_bytes(colors), std::invalid_argument);
  colors = example();
  colors.classes[1].name = "red";
  EXPECT_THROW(color_file_bytes(colors), std::invalid_argument);
  colors = example();
  colors.classes[0].samples = 3;
  EXPECT_THROW(color_file_bytes(colors), std::invalid_argument);
  colors = example();
  std::swap(colors.background[0], colors.background[1]);
  EXPECT_THROW(color_file_bytes(colors), std::invalid_argument);
  colors = example();
  colors.camera_settings["a b"] = 1;
  EXPECT_THROW(color_file_bytes(colors), std::invalid_argument);
}

TEST(ColorTable, ClassifiesBySixBitsAChannel) {
  ColorTable colors = example();
  colors.table.assign(ColorTable::entries, no_class);
  colors.table[ColorTable::index(255, 0, 64)] = 2;
  EXPECT_EQ(colors.classify(252, 3, 67), 2);
  EXPECT_EQ(colors.classify(251, 3, 67), no_class);
  EXPECT_EQ(colors.classify(252, 4, 67), no_class);
  EXPECT_EQ(colors.classify(252, 3, 68), no_class);
  EXPECT_EQ(colors.find("green_2"), ClassIndex{2});
  EXPECT_FALSE(colors.find("blue"));
}

}  // namespace
}  // namespace ballservo
