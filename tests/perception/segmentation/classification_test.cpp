#include "perception/segmentation/classification.hpp"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <array>
#include <string>

#include "calibration/base/fault.hpp"
#include "tests/perception/painted_ball.hpp"
#include "tests/perception/segmentation/class_pictures.hpp"

namespace ballservo {
namespace {

/// Blocks of fifteen classes and single cells of them everywhere, the darkest too.
std::shared_ptr<const ColorTable> scattered_table() {
  auto colors = std::make_shared<ColorTable>();
  colors->classes.resize(max_classes);
  auto engine = random_stream(2, "classification_test");
  for (int i = 0; i < ColorTable::entries; ++i) {
    const int block = ((i >> 15) * 5 + (i >> 8) % 16 + i % 64 / 12) % 23;
    const bool alone = uniform_index(engine, 50) == 0;
    const std::uint32_t found = alone                 ? uniform_index(engine, max_classes + 1)
                                : block > max_classes ? 0
                                                      : block;
    colors->table[static_cast<std::size_t>(i)] = static_cast<ClassIndex>(found);
  }
  return colors;
}

LightCells some_light() {
  LightCells light = LightCells::as_taught();
  for (std::size_t cell = 0; cell < ColorTable::side; ++cell) {
    light.taught_cell[0][cell] = static_cast<std::uint8_t>(std::min<std::size_t>(63, cell + cell / 3 + 1));
    light.taught_cell[1][cell] = static_cast<std::uint8_t>(cell / 2);
    light.taught_cell[2][cell] = static_cast<std::uint8_t>(63 - cell);
  }
  return light;
}

/// What the classification is to be, by its definition.
ClassIndex expected_class(const ColorTable& colors, const LightCells& light, const std::uint8_t* bgr) {
  std::array<std::size_t, 3> cell;
  for (std::size_t c = 0; c < 3; ++c) cell[c] = bgr[c] / 4;
  const bool dark = cell[0] < 3 && cell[1] < 3 && cell[2] < 3;
  for (std::size_t c = 0; c < 3 && !dark; ++c) cell[c] = light.taught_cell[c][cell[c]];
  return colors.table[(cell[2] * 64 + cell[1]) * 64 + cell[0]];
}

/// Of those that are compiled for this kind of machine and run on this one.
class EveryProcessor : public testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

std::string name_of(const testing::TestParamInfo<std::int64_t>& target) {
  return hwy::TargetName(target.param);
}

INSTANTIATE_TEST_SUITE_P(Classification, EveryProcessor,
                         testing::ValuesIn(hwy::SupportedAndGeneratedTargets()), name_of);

TEST_P(EveryProcessor, GivesTheTablesAnswerForAllColours) {
  cv::Mat colors_of_a_red(256, 256, CV_8UC3);
  for (const auto& table : {test::red_and_green(), scattered_table()}) {
    ColorLookup lookup(table);
    for (const LightCells& light : {LightCells::as_taught(), some_light()}) {
      lookup.set_light(light);
      ClassPictures classes;
      long wrong = 0;
      for (int red = 0; red < 256; ++red) {
        for (int i = 0; i < 256 * 256; ++i) {
          colors_of_a_red.at<cv::Vec3b>(i / 256, i % 256) =
              cv::Vec3b(static_cast<std::uint8_t>(i % 256), static_cast<std::uint8_t>(i / 256),
                        static_cast<std::uint8_t>(red));
        }
        classify(colors_of_a_red, lookup, classes);
        const cv::Mat numbers = class_numbers(classes, colors_of_a_red.size());
        for (int i = 0; i < 256 * 256; ++i) {
          wrong += numbers.at<ClassIndex>(i / 256, i % 256) !=
                   expected_class(*table, light, colors_of_a_red.ptr(i / 256) + 3 * (i % 256));
        }
      }
      EXPECT_EQ(wrong, 0);
    }
  }
}

TEST_P(EveryProcessor, TakesRowsOfAnyWidthAnywhere) {
  const ColorLookup lookup(scattered_table());
  auto engine = random_stream(1, "classification_test");
  ClassPictures classes;
  for (int width = 1; width < 200; width += width < 70 ? 1 : 7) {
    // Rows end where their memory ends; in the window they begin anywhere and do not follow each other.
    cv::Mat whole(5, width + 3, CV_8UC3);
    for (int i = 0; i < 5 * 3 * (width + 3); ++i)
      whole.data[i] = static_cast<std::uint8_t>(uniform_index(engine, 256));
    for (const cv::Rect& window :
         {cv::Rect(0, 0, width + 3, 5), cv::Rect(3, 1, width, 4), cv::Rect(1, 2, width, 1)}) {
      const cv::Mat bgr = whole(window);
      classify(bgr, lookup, classes);
      ASSERT_TRUE(test::ends_are_clear(classes));
      const cv::Mat numbers = class_numbers(classes, bgr.size());
      for (int v = 0; v < bgr.rows; ++v) {
        for (int u = 0; u < bgr.cols; ++u) {
          const cv::Vec3b& p = bgr.at<cv::Vec3b>(v, u);
          ASSERT_EQ(numbers.at<ClassIndex>(v, u), lookup.colors().classify(p[0], p[1], p[2])) << width;
        }
      }
    }
  }
}

TEST(Classification, RefusesWhatIsNotColour) {
  const ColorLookup lookup(test::red_and_green());
  ClassPictures classes;
  EXPECT_THROW(classify(cv::Mat(8, 8, CV_8UC1), lookup, classes), InputError);
  EXPECT_THROW(classify(cv::Mat(8, 8, CV_16UC3), lookup, classes), InputError);
}

TEST(ColorLookup, RefusesATableOfClassesThatItDoesNotList) {
  auto colors = std::make_shared<ColorTable>(*test::red_and_green());
  colors->table[5] = 3;
  EXPECT_THROW(ColorLookup{colors}, InputError);
  colors->classes.resize(16);
  EXPECT_THROW(ColorLookup{colors}, InputError);
  EXPECT_EQ(ColorLookup(std::make_shared<ColorTable>()).classes(), 0);
}

}  // namespace
}  // namespace ballservo
