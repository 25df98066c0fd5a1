#include "perception/outline/edge_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/base/random.hpp"
#include "perception/outline/camera_response.hpp"

namespace ballservo {
namespace {

// E f(x + z) over z normal, by brute force.
template <typename F>
double blurred(double x, const F& f) {
  double sum = 0;
  constexpr int steps = 200000;
  for (int i = 0; i < steps; ++i) {
    const double z = -9 + 18 * (i + 0.5) / steps;
    sum += f(x + z) * std::exp(-0.5 * z * z) * 0.3989422804014327 * 18 / steps;
  }
  return sum;
}

TEST(BlurredBasis, AgreesWithQuadrature) {
  for (double x = -5; x <= 14; x += 0.37) {
    const BlurredBasis basis = blurred_basis(x);
    EXPECT_NEAR(basis.step, blurred(x, [](double y) { return y > 0 ? 1.0 : 0.0; }), 5e-5);
    EXPECT_NEAR(basis.root, blurred(x, [](double y) { return y > 0 ? std::sqrt(y) : 0.0; }), 5e-5);
    EXPECT_NEAR(basis.ramp, blurred(x, [](double y) { return y > 0 ? y : 0.0; }), 2e-4);
  }
}

TEST(BlurredBasis, SlopesAreDerivatives) {
  for (double x = -4; x <= 10; x += 0.413) {
    const double h = 1.0 / 64;
    const BlurredBasis low = blurred_basis(x - h), high = blurred_basis(x + h), at = blurred_basis(x);
    EXPECT_NEAR(at.step_slope, (high.step - low.step) / (2 * h), 2e-3);
    EXPECT_NEAR(at.root_slope, (high.root - low.root) / (2 * h), 5e-3);
    EXPECT_NEAR(at.ramp_slope, (high.ramp - low.ramp) / (2 * h), 2e-3);
  }
}

EdgeSamples profile(double offset_px, double blur_px, double root, double noise, std::uint64_t seed = 0,
                    double background_slope = 0) {
  auto engine = random_stream(seed, "edge_model_test");
  EdgeSamples samples;
  for (int i = 0; i < 60; ++i) {
    const double t = -5 + 10.0 * i / 59;
    const double x = (offset_px - t) / blur_px;
    const BlurredBasis basis = blurred_basis(x);
    const double intensity = 60 + 90 * basis.step + root * std::sqrt(blur_px) * basis.root +
                             background_slope * blur_px * (basis.ramp - x) + noise * standard_normal(engine);
    samples.add(static_cast<float>(t), static_cast<float>(intensity));
  }
  return samples;
}

TEST(EdgeProfile, FindsAnEdgeOfUnknownBlurAndShading) {
  for (const double offset_px : {-1.3, 0.0, 0.8}) {
    for (const double blur_px : {0.5, 1.0, 1.8}) {
      const auto fit = fit_edge_profile(profile(offset_px, blur_px, 12, 0), std::round(offset_px), {});
      ASSERT_TRUE(fit);
      EXPECT_NEAR(fit->offset_px, offset_px, 0.02) << "blur " << blur_px;
      EXPECT_NEAR(fit->blur_px, blur_px, 0.1);
    }
  }
}

TEST(EdgeProfile, ABackgroundThatSlopesDoesNotMoveTheEdge) {
  for (const double slope : {-3.0, 3.0}) {  // grey levels per px
    const auto fit = fit_edge_profile(profile(0.3, 0.8, 12, 0, 0, slope), 0, {});
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->offset_px, 0.3, 0.02) << slope;
  }
}

TEST(EdgeProfile, SigmaIsTheSpread) {
  double squares = 0, predicted = 0;
  constexpr int trials = 300;
  for (int i = 0; i < trials; ++i) {
    const auto fit = fit_edge_profile(profile(0.2, 0.8, 0, 3, static_cast<std::uint64_t>(i)), 0, {});
    ASSERT_TRUE(fit);
    squares += std::pow(fit->offset_px - 0.2, 2) / trials;
    predicted += fit->sigma_px * fit->sigma_px / trials;
  }
  EXPECT_NEAR(std::sqrt(predicted / squares), 1, 0.3);
}

TEST(EdgeProfile, IsTheSameToTheLastBitWhateverTheProcessorHas) {
  EdgeProfileOptions portable;
  portable.instructions = Instructions::portable;
  for (int i = 0; i < 50; ++i) {
    EdgeSamples samples = profile(0.02 * i, 0.5 + 0.03 * i, 8, 4, static_cast<std::uint64_t>(i));
    samples.count -= i % 9;  // no whole number of vectors
    const auto fastest = fit_edge_profile(samples, 0.4, {}), other = fit_edge_profile(samples, 0.4, portable);
    ASSERT_TRUE(fastest && other);
    EXPECT_EQ(fastest->offset_px, other->offset_px);
    EXPECT_EQ(fastest->sigma_px, other->sigma_px);
    EXPECT_EQ(fastest->blur_px, other->blur_px);
  }
}

TEST(EdgeProfile, NoEdgeHasNoFit) {
  EdgeSamples flat = profile(0, 0.8, 0, 0);
  flat.intensity.fill(80);
  EXPECT_FALSE(fit_edge_profile(flat, 0, {}));
  EXPECT_FALSE(fit_edge_profile({}, 0, {}));
  flat.intensity.fill(std::nanf(""));
  EXPECT_FALSE(fit_edge_profile(flat, 0, {}));
}

// A coded channel is a mix of grey levels, the lens's blur one of light: a dark red ball, darker at its limb,
// before grey.
class CodedProfile : public testing::Test {
 protected:
  float level(double t, double offset_px, const Eigen::Vector3f& of_grey) const {
    constexpr double blur_px = 0.8, limb = 0.6, root = 0.2;
    const BlurredBasis basis = blurred_basis((offset_px - t) / blur_px);
    const double ball = limb * basis.step + root * std::sqrt(blur_px) * basis.root;
    const Eigen::Array3f light =
        static_cast<float>(ball) * colors_.inside + static_cast<float>(1 - basis.step) * colors_.outside;
    double coded = 0;
    for (int c = 0; c < 3; ++c)
      coded += static_cast<double>(of_grey[c]) * srgb_.shown(static_cast<double>(light[c])).level;
    return static_cast<float>(coded);
  }
  /// The offset by the coded channel's own profile; the one by that of light differs more.
  void expect_edge(const CodedChannel& channel, double tolerance_px) const {
    for (const double offset_px : {-0.7, 0.0, 0.4}) {
      EdgeSamples samples;
      for (int i = 0; i < 60; ++i) {
        const double t = -5 + 10.0 * i / 59;
        double sum = 0, weights = 0;
        for (double z = channel.blur_px > 0 ? -4 : 0; z <= 4; z += channel.blur_px > 0 ? 0.1 : 9) {
          sum += std::exp(-0.5 * z * z) *
                 static_cast<double>(level(t + z * channel.blur_px, offset_px, channel.of_grey));
          weights += std::exp(-0.5 * z * z);
        }
        samples.add(static_cast<float>(t), static_cast<float>(sum / weights));
      }
      EdgeProfileFit start;
      start.offset_px = offset_px + 0.15;
      const auto fit = fit_coded_profile(samples, colors_, srgb_, channel, start, {});
      ASSERT_TRUE(fit);
      EXPECT_NEAR(fit->offset_px, offset_px, tolerance_px);
      EdgeProfileOptions portable;
      portable.instructions = Instructions::portable;
      EXPECT_EQ(fit->offset_px,
                fit_coded_profile(samples, colors_, srgb_, channel, start, portable)->offset_px);
      const auto by_grey_levels = fit_edge_profile(samples, offset_px, {});
      EXPECT_TRUE(!by_grey_levels || std::abs(by_grey_levels->offset_px - offset_px) > 2 * tolerance_px);
    }
  }

 private:
  const CameraResponse& srgb_ = CameraResponse::srgb();
  const EdgeColors colors_{{8, 10, 90}, {70, 80, 75}};
};

TEST_F(CodedProfile, FindsTheEdgeThatWasBlurredAsLight) { expect_edge({luma_of}, 0.01); }

TEST_F(CodedProfile, FindsTheEdgeThatHalvedResolutionBlurredOnceMore) {
  const Eigen::Vector3f red = Eigen::Vector3f::UnitZ();
  expect_edge({red - luma_of, 0.75}, 0.04);
}

}  // namespace
}  // namespace ballservo
