#include "calibration/color/color_space.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <set>
#include <string>

#include "calibration/color/color_names.hpp"

namespace ballservo {
namespace {

/// OpenCV's own conversion of one colour, in floats.
Eigen::Vector3d by_opencv(int b, int g, int r, int code) {
  const cv::Mat3f in(1, 1,
                     cv::Vec3f(static_cast<float>(b), static_cast<float>(g), static_cast<float>(r)) / 255.0f);
  cv::Mat3f out;
  cv::cvtColor(in, out, code);
  return {out(0, 0)[0], out(0, 0)[1], out(0, 0)[2]};
}

TEST(ColorSpace, AgreesWithOpenCv) {
  for (int r = 0; r < 256; r += 15) {
    for (int g = 0; g < 256; g += 15) {
      for (int b = 0; b < 256; b += 15) {
        const auto bytes = [](int v) { return static_cast<std::uint8_t>(v); };
        const Eigen::Vector3d lab = lab_from_bgr(bytes(b), bytes(g), bytes(r));
        const Eigen::Vector3d luv = luv_from_bgr(bytes(b), bytes(g), bytes(r));
        // OpenCV interpolates its conversion in a table: a few tenths.
        EXPECT_LT((lab - by_opencv(b, g, r, cv::COLOR_BGR2Lab)).norm(), 0.6) << r << ' ' << g << ' ' << b;
        EXPECT_LT((luv - by_opencv(b, g, r, cv::COLOR_BGR2Luv)).norm(), 0.6) << r << ' ' << g << ' ' << b;
      }
    }
  }
}

TEST(ColorSpace, LookedUpLabIsTheSame) {
  for (int k = 0; k < 1 << 24; k += 997) {
    const auto b = static_cast<std::uint8_t>(k), g = static_cast<std::uint8_t>(k >> 8),
               r = static_cast<std::uint8_t>(k >> 16);
    ASSERT_LT((fast_lab()(b, g, r).cast<double>() - lab_from_bgr(b, g, r)).cwiseAbs().maxCoeff(), 1e-4) << k;
  }
}

TEST(ColorSpace, PublishedValues) {
  EXPECT_TRUE(lab_from_bgr(0, 0, 255).isApprox(Eigen::Vector3d(53.2408, 80.0925, 67.2032), 2e-4));
  EXPECT_TRUE(luv_from_bgr(0, 0, 255).isApprox(Eigen::Vector3d(53.2408, 175.0151, 37.7564), 2e-4));
  EXPECT_TRUE(lab_from_bgr(255, 0, 0).isApprox(Eigen::Vector3d(32.2970, 79.1875, -107.8602), 2e-4));
}

TEST(ColorSpace, GreyHasNoChroma) {
  for (int v = 0; v < 256; ++v) {
    const auto grey = static_cast<std::uint8_t>(v);
    EXPECT_LT(lab_from_bgr(grey, grey, grey).tail<2>().norm(), 1e-9);
    EXPECT_LT(luv_from_bgr(grey, grey, grey).tail<2>().norm(), 1e-9);
  }
  EXPECT_NEAR(lab_from_bgr(255, 255, 255).x(), 100, 1e-9);
  EXPECT_NEAR(lab_from_bgr(0, 0, 0).x(), 0, 1e-9);
}

TEST(ColorNames, EverydayColors) {
  const auto word = [](std::uint8_t r, std::uint8_t g, std::uint8_t b) {
    return color_word(lab_from_bgr(b, g, r));
  };
  EXPECT_EQ(word(255, 0, 0), "red");
  EXPECT_EQ(word(120, 10, 10), "red");
  EXPECT_EQ(word(220, 20, 60), "red");
  EXPECT_EQ(word(255, 140, 0), "orange");
  EXPECT_EQ(word(255, 255, 0), "yellow");
  EXPECT_EQ(word(230, 200, 40), "yellow");
  EXPECT_EQ(word(0, 255, 0), "green");
  EXPECT_EQ(word(20, 90, 40), "green");
  EXPECT_EQ(word(0, 255, 255), "cyan");
  EXPECT_EQ(word(0, 0, 255), "blue");
  EXPECT_EQ(word(60, 120, 240), "blue");
  EXPECT_EQ(word(128, 0, 128), "purple");
  EXPECT_EQ(word(255, 105, 180), "pink");
  EXPECT_EQ(word(255, 182, 193), "pink");
}

TEST(ColorNames, EveryHueHasAWordAndEveryWordItsHues) {
  std::set<std::string> seen;
  for (int degree = 0; degree < 360; ++degree) {
    const double angle = degree * 3.14159265358979 / 180;
    const std::string word = color_word({55, 50 * std::cos(angle), 50 * std::sin(angle)});
    seen.insert(word);
    EXPECT_EQ(hue_distance_to_word_deg(word, degree), 0) << degree;
  }
  EXPECT_EQ(seen.size(), color_words().size());
}

TEST(ColorNames, HueIsACircle) {
  EXPECT_NEAR(hue_distance_deg(359, 2), 3, 1e-12);
  EXPECT_NEAR(hue_distance_deg(10, 190), 180, 1e-12);
  EXPECT_NEAR(lab_hue_deg(1, -1), 315, 1e-12);
  EXPECT_EQ(hue_distance_to_word_deg("pink", 350), 0);
  EXPECT_EQ(hue_distance_to_word_deg("pink", 10), 0);
  EXPECT_GT(hue_distance_to_word_deg("pink", 180), 90);
}

TEST(ColorNames, ANameSaysAColourByAWordInIt) {
  for (const std::string& word : color_words()) EXPECT_EQ(word_in_name(word), word);
  for (const char* name : {"light_green", "green_2", "green2", "lime", "ball_of_green"})
    EXPECT_EQ(word_in_name(name), "green") << name;
  EXPECT_EQ(word_in_name("violet_ball"), "purple");
  for (const char* name : {"", "ball", "2", "_", "colored", "redball", "evergreen", "red_or_green"})
    EXPECT_EQ(word_in_name(name), std::nullopt) << name;
}

TEST(ColorNames, ATennisBallAnswersToYellowAndGreen) {
  const Eigen::Vector3d lab = lab_from_bgr(60, 230, 200);
  const double hue = lab_hue_deg(lab.y(), lab.z());
  EXPECT_EQ(hue_distance_to_word_deg("yellow", hue), 0);
  EXPECT_EQ(hue_distance_to_word_deg("green", hue), 0);
  EXPECT_GT(hue_distance_to_word_deg("red", hue), 20);
}

}  // namespace
}  // namespace ballservo
