#include "calibration/base/fault.hpp"

#include <gtest/gtest.h>

namespace ballservo {
namespace {

TEST(Fault, SaysPlaceFoundAndAllowed) {
  EXPECT_EQ(to_text(Fault{"scene.yaml:12: camera.rate_hz", "-30", "a number above 0 (Hz)"}),
            "scene.yaml:12: camera.rate_hz: found -30; allowed: a number above 0 (Hz)");
}

TEST(Fault, StaysOnOneLineAndWithoutControlCharacters) {
  const std::string text = to_text(Fault{"a\nb", "x\x1b[2Jy\r", std::string("z\0", 2)});
  for (const char c : text) EXPECT_GE(static_cast<unsigned char>(c), 0x20) << text;
}

TEST(Fault, CutsWhatIsLongBetweenCharacters) {
  std::string found;
  for (int i = 0; i < 1000; ++i) found += "\xC3\xA4";
  const std::string text = to_text(Fault{"p", "x" + found, "a"});
  EXPECT_LT(text.size(), 400u);
  const std::size_t cut = text.find("...");
  ASSERT_NE(cut, std::string::npos);
  EXPECT_EQ(text[cut - 1], '\xA4');
}

TEST(InputError, KeepsEveryFaultInItsOrder) {
  FaultList list;
  EXPECT_NO_THROW(list.throw_if_any());
  list.add("a", "1", "2");
  list.add("b", "3", "4");
  try {
    list.throw_if_any();
    FAIL() << "two faults must throw";
  } catch (const InputError& error) {
    ASSERT_EQ(error.faults().size(), 2u);
    EXPECT_EQ(error.faults()[0].place, "a");
    EXPECT_EQ(error.faults()[1].place, "b");
    EXPECT_STREQ(error.what(), "a: found 1; allowed: 2\nb: found 3; allowed: 4");
  }
}

}  // namespace
}  // namespace ballservo
