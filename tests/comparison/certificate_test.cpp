#include "app/comparison/certificate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "app/comparison/estimators/converged_fits.hpp"
#include "calibration/base/random.hpp"
#include "perception/outline/ball_fitter.hpp"

namespace ballservo {
namespace {

const MethodList tested_methods{find_fit_method("paper_one_step"), find_fit_method("paper_steps_2"),
                                find_fit_method("paper_converged")};

MethodFit fit_of(const UndistortedCircle& circle) {
  MethodFit fit;
  fit.outline = {circle.center_px, circle.radius_px};
  return fit;
}

// One step, two and the converged fit of noisy points on a circle, from a start that is so far off.
ComparisonRecord record(double start_px, std::uint64_t index) {
  RandomEngine engine = random_stream(1, "certificate_test", index);
  const UndistortedCircle truth{{uniform(engine, -99, 99), uniform(engine, -99, 99)},
                                uniform(engine, 20, 60)};
  std::vector<RingPixel> ring;
  for (int k = 0; k < 90; ++k) {
    const double angle = 1.4 * M_PI * k / 90, radius = truth.radius_px + 0.3 * standard_normal(engine);
    ring.push_back({truth.center_px + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)), 1, 0, 0});
  }
  const double way = uniform(engine, 0, 2 * M_PI);
  const UndistortedCircle start{truth.center_px + start_px * Eigen::Vector2d(std::cos(way), std::sin(way)),
                                truth.radius_px};
  const auto one = one_gauss_newton_step(start, ring);
  const auto two = one_gauss_newton_step(one->circle, ring);
  ComparisonRecord record;
  record.truth.outline = OutlineEllipse{truth.center_px, truth.radius_px};
  record.fits = {fit_of(one->circle), fit_of(two->circle), fit_of(converge(start, ring)->shape)};
  record.fits[0]->step_px = one->step_px;
  record.fits[0]->next_step_px = two->step_px;
  record.fits[0]->residual_px = one->residual_px;
  record.fits[0]->arc = 0.7;
  record.fits[0]->condition = 3;
  return record;
}

// Condition 0 is what rules are made on, condition 1 what they are tested on.
Certificate trained_and_tested(double largest_start_px, double tested_start_px, std::uint64_t frames = 300) {
  CertificateStudy study(tested_methods);
  for (std::uint64_t k = 0; k < frames; ++k) {
    RandomEngine engine = random_stream(2, "certificate_test/start", k);
    study.add(0, record(uniform(engine, 0, largest_start_px), k));
    study.add(1, record(uniform(engine, 0, tested_start_px), 1000 + k));
  }
  return study.certificates().at(0);
}

TEST(Condition, OfFewerPointsThanUnknownsIsInfinite) {
  for (int k = 0; k < 20; ++k) {
    Eigen::Matrix<double, 2, 3> jacobian;
    jacobian << 1, std::cos(k), std::sin(k), 0.1 * k, 1, std::sqrt(k);
    EXPECT_TRUE(std::isinf(condition_of(jacobian.transpose() * jacobian))) << k;
  }
}

TEST(Certificate, CatchesBreaksOnConditionsItWasNotMadeOn) {
  const Certificate certificate = trained_and_tested(8, 6);
  const CertificateRule& rule = certificate.rules.front();
  ASSERT_GT(rule.tested.breaks, 30);
  ASSERT_GT(rule.tested.frames - rule.tested.breaks, 30);
  EXPECT_GE(rule.tested.caught_rate(), 0.95);
  EXPECT_LE(rule.tested.false_alarm_rate(), 0.05);
  EXPECT_GT(rule.tested.area, 0.99);
  // As on line: by the same length, at a threshold that no condition chose.
  const CertificateRule& on_line = certificate.rules[1];
  EXPECT_DOUBLE_EQ(std::pow(10, on_line.threshold), enough_next_step_px);
  EXPECT_EQ(on_line.tested.breaks, rule.tested.breaks);
  EXPECT_EQ(on_line.tested.caught > rule.tested.caught, on_line.threshold < rule.threshold);
  // What is to be had for nothing is worse, but no chance.
  EXPECT_GT(certificate.rules[2].tested.area, 0.9);
  EXPECT_LT(certificate.rules[2].tested.area, rule.tested.area);
  // One more step where it says so is worth it.
  EXPECT_LT(certificate.breaks_after, 0.2 * certificate.breaks_before);
}

TEST(Certificate, CatchesTheOneBreakThatWasMadeOnPurpose) {
  CertificateStudy study(tested_methods);
  for (std::uint64_t k = 0; k < 200; ++k) {
    RandomEngine engine = random_stream(3, "certificate_test/start", k);
    study.add(0, record(uniform(engine, 0, 8), k));
    study.add(1, record(uniform(engine, 0, 0.5), 1000 + k));
  }
  study.add(1, record(7, 5000));
  const CertificateScore tested = study.certificates().at(0).rules.front().tested;
  EXPECT_EQ(tested.frames, 201);
  EXPECT_EQ(tested.breaks, 1);
  EXPECT_EQ(tested.caught, 1);
  EXPECT_LT(tested.false_alarm_rate(), 0.05);
}

TEST(Certificate, IsAThresholdThatCanBeReadAndApplied) {
  const CertificateRule rule = trained_and_tested(8, 6).rules.front();
  EXPECT_EQ(rule.name, "next_step");
  EXPECT_NE(rule.words.find("longer than "), std::string::npos) << rule.words;
  // Applied by hand to the tested frames it says what the study says.
  int alarms = 0;
  for (std::uint64_t k = 0; k < 300; ++k) {
    RandomEngine engine = random_stream(2, "certificate_test/start", k);
    uniform(engine, 0, 8);
    const MethodFit one = *record(uniform(engine, 0, 6), 1000 + k).fits[0];
    alarms += std::log10(*one.next_step_px) > rule.threshold ? 1 : 0;
  }
  EXPECT_EQ(alarms, rule.tested.caught + rule.tested.false_alarms);
}

TEST(Certificate, NeverAlarmsWhereItSawNoBreak) {
  const CertificateRule rule = trained_and_tested(0.2, 0.2).rules.front();
  EXPECT_EQ(rule.trained.breaks, 0);
  EXPECT_TRUE(std::isinf(rule.threshold));
  EXPECT_EQ(rule.tested.false_alarms, 0);
  EXPECT_TRUE(std::isnan(rule.tested.caught_rate()));
  EXPECT_EQ(rule.words.rfind("never", 0), 0u) << rule.words;
}

TEST(Certificate, SeesNothingOfTheConditionsItIsTestedOn) {
  const Certificate certificate = trained_and_tested(0.2, 6);
  const CertificateRule& rule = certificate.rules.front();
  EXPECT_GT(rule.tested.breaks, 30);
  EXPECT_EQ(certificate.rules.back().tested.area, 0.5);  // a regression on no break has no weights
  EXPECT_EQ(rule.tested.caught, 0);
  EXPECT_TRUE(std::isinf(rule.threshold));
}

// Step lengths that say nothing: whoever has a good area there is looking at the answer.
TEST(Certificate, IsChanceWhereTheFitKnowsNothing) {
  CertificateStudy study(tested_methods);
  for (std::uint64_t k = 0; k < 600; ++k) {
    RandomEngine engine = random_stream(4, "certificate_test/chance", k);
    ComparisonRecord frame = record(uniform(engine, 0, 8), k);
    frame.fits[0]->step_px = uniform(engine, 0, 8);
    frame.fits[0]->next_step_px = uniform(engine, 0, 0.2);
    study.add(k % 2, frame);
  }
  // The regression still knows the scatter against the radius, which does say something.
  const Certificate certificate = study.certificates().at(0);
  for (const std::size_t rule : {0u, 2u}) EXPECT_NEAR(certificate.rules[rule].tested.area, 0.5, 0.1) << rule;
}

// Both fits on something else than the ball: what they say of each other says nothing of balls.
TEST(Certificate, LeavesOutFramesInWhichNeitherFitIsAtTheBall) {
  CertificateStudy study(tested_methods);
  for (std::uint64_t k = 0; k < 40; ++k) {
    ComparisonRecord frame = record(3, k);
    if (k >= 30) frame.truth.outline->center_px.x() += 500;
    study.add(k % 2, frame);
  }
  const CertificateRule rule = study.certificates().at(0).rules.front();
  EXPECT_EQ(rule.trained.frames, 15);
  EXPECT_EQ(rule.tested.frames, 15);
}

// As many frames as there are: what is kept of them is bounded, evenly spread, and says the same.
TEST(Certificate, KeepsABoundedNumberOfFrames) {
  CertificateStudy study(tested_methods);
  std::vector<ComparisonRecord> some;
  for (std::uint64_t k = 0; k < 64; ++k) some.push_back(record(static_cast<double>(k) / 8, k));
  for (std::size_t k = 0; k < 450000; ++k) study.add(k < 225000 ? 1 : 0, some[(k * 7 + k / 64) % 64]);
  const CertificateRule rule = study.certificates().at(0).rules.front();
  EXPECT_LT(rule.tested.frames, 100001);
  EXPECT_GT(rule.tested.frames, 40000);
  EXPECT_NEAR(rule.tested.frames, rule.trained.frames, 2);  // early ones and late ones alike
  EXPECT_GT(rule.tested.area, 0.99);
}

}  // namespace
}  // namespace ballservo
