// What a comparison's report says in words, of results whose truth is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "app/comparison/paper_claims.hpp"
#include "app/comparison/pictures/sweeps.hpp"
#include "app/comparison/step_verdict.hpp"

namespace ballservo {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

constexpr double infinity = std::numeric_limits<double>::infinity();

// One step errs by 1 mm in each of 20 frames, the converged fit, ten steps and the place likewise.
struct Setting {
  std::string name{}, swept_key{};
  double swept_value = 0;
  int breaks = 0, lost = 0;
  double error_mm = 1;
  int further = 0;         // -1: the converged fit is the better by a test, 1: it is the worse
  int ten_reselected = 0;  // ten steps against one, likewise
};

ComparisonResults results_of(const std::vector<Setting>& settings) {
  ComparisonResults results;
  for (const char* name : {"paper_one_step", "paper_converged", "paper_steps_10_reselect"})
    results.methods.push_back(find_fit_method(name));
  for (const Setting& s : settings) {
    const std::string words = s.swept_key.empty() ? s.name : s.swept_key + std::to_string(s.swept_value);
    results.conditions.push_back(
        {s.name, words, 20, s.swept_key, s.swept_key + " (m)", s.swept_value, false});
    ConditionSummary summary;
    MethodStatistics method{};
    method.frames = 20;
    method.failed = s.lost;
    method.found = 20 - s.lost;
    method.position_median_mm = s.error_mm;
    method.charged_median_mm = s.lost > 10 ? infinity : s.error_mm;
    summary.methods.assign(results.methods.size(), method);
    PairStatistics apart{};
    apart.frames = 20;
    apart.breaks = s.breaks;
    apart.center_median_px = 0.01;
    apart.center_max_px = 0.02;
    apart.radius_max_px = 0.08;
    apart.position_median_mm = 0.5 * s.error_mm;
    summary.pairs.assign(converged_pairs(results.methods).size(), apart);
    for (const MethodPair& pair : tested_pairs(results.methods)) {
      const int sign = pair.a == 1 ? s.further : s.ten_reselected;
      PairedTest test{};
      test.pair = pair;
      test.frames = 20;
      test.difference_median_mm = 0.1 * sign;
      test.wilcoxon_p = sign == 0 ? 0.5 : 0.001;
      summary.tests.push_back(test);
    }
    results.summaries.push_back(std::move(summary));
  }
  return results;
}

PaperClaim claim(const ComparisonResults& results, const std::string& says) {
  for (const PaperClaim& it : paper_claims(results, {})) {
    if (it.says.find(says) != std::string::npos) return it;
  }
  ADD_FAILURE() << says;
  return {};
}

TEST(ConditionsInWords, GoByValuesWithinASweep) {
  const ComparisonResults results = results_of({{"base"}, {"z_1", "z", 1}, {"z_2", "z", 2}, {"y_3", "y", 3}});
  EXPECT_EQ(in_words(results, {0, 1, 2, 3}), "base; z (m): 1, 2; y (m): 3");
  EXPECT_EQ(in_words(results, {2}), "z (m): 2");
  EXPECT_EQ(in_words(results, {}), "");
}

TEST(RepeatedSetting, IsTheLargestGroupThatShowsTheSame) {
  ComparisonResults results = results_of({{"a"}, {"b"}, {"c"}, {"d"}});
  EXPECT_THAT(repeated_setting(results), IsEmpty());
  results.conditions[3].words = results.conditions[1].words;
  EXPECT_THAT(repeated_setting(results), ElementsAre(1, 3));
}

TEST(StepTotals, CountFramesAndNameWhereManyBreak) {
  const ComparisonResults results = results_of(
      {{"base", "", 0, 1}, {"z_1", "z", 1, 5}, {"z_2", "z", 2, 4, 0, 1, -1}, {"z_3", "z", 3, 0, 0, 1, 1}});
  const StepTotals totals = step_totals(results, 0);
  EXPECT_EQ(totals.frames, 80);
  EXPECT_EQ(totals.breaks, 10);
  EXPECT_EQ(totals.told, 4);
  EXPECT_THAT(totals.often_broken, ElementsAre(1));  // a quarter of 20
  EXPECT_THAT(totals.further_is_better, ElementsAre(2));
  EXPECT_EQ(totals.further_is_worse, 1);
  EXPECT_EQ(totals.undecided, 2);  // base and z_1
  EXPECT_DOUBLE_EQ(totals.center_max_px, 0.02);
  EXPECT_DOUBLE_EQ(totals.radius_max_px, 0.08);
}

TEST(PaperClaims, OneIterationNamesBothCriteria) {
  const PaperClaim clean = claim(results_of({{"base"}, {"other"}}), "one iteration");
  EXPECT_EQ(clean.verdict, "holds for accuracy, as far as these frames tell");
  const PaperClaim broken = claim(results_of({{"base", "", 0, 2}, {"other"}}), "one iteration");
  EXPECT_THAT(broken.verdict,
              StartsWith("holds for accuracy, as far as these frames tell; 5.0 % of the frames break"));
  const std::vector<Setting> one_of_five{{"a"}, {"b"}, {"c"}, {"d"}, {"z_2", "z", 2, 0, 0, 1, -1}};
  EXPECT_EQ(claim(results_of(one_of_five), "one iteration").verdict, "holds but at z (m): 2");
  EXPECT_EQ(claim(results_of({{"a", "", 0, 0, 0, 1, -1}}), "one iteration").verdict, "does not hold");
}

TEST(PaperClaims, HarmOfMoreIterationsSaysWhere) {
  const std::vector<Setting> settings{{"base", "", 0, 0, 0, 1, 0, 1}, {"b"}, {"c", "", 0, 0, 0, 1, 0, -1}};
  const PaperClaim some = claim(results_of(settings), "more iterations do harm");
  EXPECT_THAT(some.verdict, StartsWith("told in 1 of 3 conditions only, at base; in 1 they help"));
  EXPECT_THAT(some.measured, HasSubstr("nearer to the truth in 1 (c), further from it in 1 (base)"));
  EXPECT_THAT(claim(results_of({{"a"}}), "more iterations do harm").verdict, StartsWith("does not hold"));
  EXPECT_EQ(claim(results_of({{"a", "", 0, 0, 0, 1, 0, 1}}), "more iterations do harm").verdict, "holds");
}

// Where most balls are lost the others' errors say little.
TEST(PaperClaims, LostBallsCountAgainstOcclusion) {
  const auto hidden = [](double part, int lost) {
    return Setting{"occlusion_" + std::to_string(part), "occlusion", part, 0, lost};
  };
  EXPECT_EQ(claim(results_of({hidden(0, 0), hidden(0.5, 0), hidden(0.6, 0)}), "50 %").verdict,
            "does not hold");
  const PaperClaim lost = claim(results_of({hidden(0, 0), hidden(0.5, 0), hidden(0.6, 15)}), "50 %");
  EXPECT_EQ(lost.verdict, "holds");
  EXPECT_THAT(lost.measured, HasSubstr("15 of 20 frames are lost"));
}

}  // namespace
}  // namespace ballservo
