#include "app/comparison/paper_claims.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/comparison/pictures/sweeps.hpp"
#include "app/comparison/step_verdict.hpp"
#include "calibration/base/csv_table.hpp"

namespace ballservo {
namespace {

constexpr const char* of_times = "the machine's times";
constexpr const char* not_measured = "not measured";

const MethodStatistics* statistics_of(const ComparisonResults& results, std::string_view condition,
                                      std::string_view method) {
  const auto m = place_of(results.methods, method);
  for (std::size_t c = 0; m && c < results.conditions.size(); ++c) {
    if (results.conditions[c].name == condition) return &results.summaries[c].methods[*m];
  }
  return nullptr;
}

PaperClaim one_millimetre(const ComparisonResults& results) {
  PaperClaim claim{"the position deviates typically by at most 1 mm: a whole ball of 7 cm at 1 m, 640x480",
                   "", not_measured, "Where the errors lie: base"};
  const MethodStatistics *paper = statistics_of(results, "base", "paper_one_step"),
                         *sphere = statistics_of(results, "base", "sphere_one_step");
  if (!paper) return claim;
  claim.measured = fmt::format("paper_one_step: depth RMS {} mm, sideways spread {} mm, 3-D median {} mm",
                               figure(paper->depth_rms_mm), figure(paper->lateral_spread_mm),
                               figure(paper->position_median_mm));
  if (sphere)
    claim.measured += fmt::format("; sphere_one_step: {}, {}, {} mm", figure(sphere->depth_rms_mm),
                                  figure(sphere->lateral_spread_mm), figure(sphere->position_median_mm));
  const bool sideways = paper->lateral_spread_mm <= 1, depth = paper->depth_rms_mm <= 1;
  claim.verdict = sideways && depth ? "holds"
                  : sideways ? "holds if the deviation is sideways; not in depth, with the paper's own fit"
                             : "does not hold";
  if (!depth && sphere && sphere->depth_rms_mm <= 1) claim.verdict += "; the exact fit does it in depth too";
  return claim;
}

PaperClaim votes(const ComparisonResults& results, const PaperMeasurements& m) {
  std::vector<double> medians;
  for (const ConditionSummary& summary : results.summaries) {
    if (std::isfinite(summary.votes_median)) medians.push_back(summary.votes_median);
  }
  PaperClaim claim{"about 300 votes are typical", "", not_measured, "frames.csv: votes"};
  if (!std::isfinite(m.votes)) return claim;
  claim.measured = fmt::format("whole balls, drawn as the paper draws: median {:.0f}, most {:.0f}", m.votes,
                               m.votes_largest);
  if (!medians.empty())
    claim.measured += fmt::format(
        "; the detector (which draws half of them from neighbours): medians by condition {:.0f} to {:.0f}",
        *std::min_element(medians.begin(), medians.end()), *std::max_element(medians.begin(), medians.end()));
  const double most =
      std::max(m.votes, medians.empty() ? 0 : *std::max_element(medians.begin(), medians.end()));
  claim.verdict = m.votes >= 150 && m.votes <= 600 ? "holds"
                  : most >= 150 ? "holds if part of the ball is hidden or disturbed; a whole one needs fewer"
                                : "does not hold: fewer are needed";
  return claim;
}

PaperClaim quality(const std::string& says, double ball, double other, double wanted) {
  PaperClaim claim{says, "", not_measured, "this row"};
  const double ratio = ball / other;
  if (!std::isfinite(ratio)) return claim;
  claim.measured = fmt::format("median Q_c {} against {}: {:.1f} times", figure(ball), figure(other), ratio);
  claim.verdict = ratio >= wanted         ? "holds"
                  : ratio >= 0.5 * wanted ? fmt::format("holds if {:.1f} times will do", ratio)
                                          : "does not hold";
  return claim;
}

PaperClaim one_step(const ComparisonResults& results) {
  PaperClaim claim{"exactly one iteration suffices", "", not_measured,
                   "paper_one_step against paper_converged"};
  const std::vector<MethodPair> pairs = converged_pairs(results.methods);
  if (pairs.empty() || results.methods[pairs[0].a]->name != "paper_one_step") return claim;
  const StepTotals totals = step_totals(results, 0);
  if (totals.frames == 0) return claim;
  const int better = static_cast<int>(totals.further_is_better.size());
  claim.measured = fmt::format(
      "accuracy: converging brings the ball nearer to the truth in {} of {} conditions{}, and in {} more no "
      "test decides. Agreement: the "
      "centres lie {} px apart in the median condition, {} px in the worst frame; {} of {} frames break{}",
      better, totals.told, better > 0 ? " (" + in_words(results, totals.further_is_better) + ")" : "",
      totals.undecided, figure(totals.center_median_px), figure(totals.center_max_px), totals.breaks,
      totals.frames,
      totals.often_broken.empty() ? "" : ", a quarter or more at " + in_words(results, totals.often_broken));
  const std::string breaks = fmt::format(
      "; {:.1f} % of the frames break (over {:g} px from the converged fit), which costs no accuracy that a "
      "test tells",
      100.0 * totals.breaks / totals.frames, break_px);
  claim.verdict = better == 0 ? (totals.undecided > 0 ? "holds for accuracy, as far as these frames tell"
                                                      : "holds for accuracy") +
                                    (totals.breaks > 0 ? breaks : std::string())
                  : 4 * better <= totals.told ? "holds but at " + in_words(results, totals.further_is_better)
                                              : "does not hold";
  return claim;
}

PaperClaim drift(const ComparisonResults& results) {
  PaperClaim claim{"with outliers or clutter more iterations do harm", "", not_measured,
                   "tests.csv: paper_steps_10_reselect against paper_one_step"};
  const auto many = place_of(results.methods, "paper_steps_10_reselect"),
             one = place_of(results.methods, "paper_one_step");
  if (!many || !one) return claim;
  std::vector<std::size_t> better, worse;
  std::size_t told = 0;
  for (std::size_t c = 0; c < results.summaries.size(); ++c) {
    for (const PairedTest& test : results.summaries[c].tests) {
      if (test.pair.a != *many || test.pair.b != *one || test.frames == 0) continue;
      ++told;
      if (test.wilcoxon_p < 0.01) (test.difference_median_mm > 0 ? worse : better).push_back(c);
    }
  }
  if (told == 0) return claim;
  const auto where = [&](const std::vector<std::size_t>& conditions) {
    return conditions.empty() ? std::string("nowhere")
                              : fmt::format("in {} ({})", conditions.size(), in_words(results, conditions));
  };
  claim.measured = fmt::format(
      "ten steps, the ring chosen anew at each, against one, in {} conditions (Wilcoxon, p below 0.01: by "
      "chance alone in {:.1f} of them): nearer to the truth {}, further from it {}, no difference that a "
      "test tells in the others",
      told, 0.01 * static_cast<double>(told), where(better), where(worse));
  const std::size_t named = std::min<std::size_t>(worse.size(), 6);
  const std::string more = worse.size() > named ? fmt::format(" and {} more", worse.size() - named) : "";
  claim.verdict = worse.empty() ? "does not hold: no test tells that they do"
                  : 2 * worse.size() > told
                      ? "holds"
                      : fmt::format(
                            "told in {} of {} conditions only, at {}{}; in {} they help, and in the others "
                            "no test decides",
                            worse.size(), told, in_words(results, {worse.begin(), worse.begin() + named}),
                            more, better.size());
  return claim;
}

PaperClaim half_hidden(const ComparisonResults& results) {
  PaperClaim claim{"worse beyond 50 % occlusion", "", not_measured,
                   "3-D error against hidden part of the disc"};
  const auto m = place_of(results.methods, "paper_one_step");
  for (const Sweep& sweep : sweeps_of(results)) {
    if (sweep.key != "occlusion" || !m) continue;
    // A ball that is not found errs without bound: the medians are of all frames.
    double whole = NAN, below = 0, beyond = 0;
    int seen = 0, lost = 0;
    for (const std::size_t c : sweep.conditions) {
      const MethodStatistics& s = results.summaries[c].methods[*m];
      const double hidden = results.conditions[c].swept_value;
      const double error_mm =
          std::isnan(s.charged_median_mm) ? std::numeric_limits<double>::infinity() : s.charged_median_mm;
      if (hidden == 0) whole = error_mm;
      (hidden > 0.5 ? beyond : below) = std::max(hidden > 0.5 ? beyond : below, error_mm);
      if (hidden <= 0.5) continue;
      seen += s.frames;
      lost += s.failed;
    }
    if (seen == 0 || below == 0) continue;
    const auto mm = [](double error_mm) {
      return std::isinf(error_mm) ? std::string("without bound (most frames are lost)")
                                  : figure(error_mm) + " mm";
    };
    claim.measured = fmt::format(
        "paper_one_step, medians of all frames: {} whole, up to {} until half is hidden, up to {} beyond, "
        "where {} of {} frames are lost",
        mm(whole), mm(below), mm(beyond), lost, seen);
    claim.verdict = beyond <= 1.2 * below ? "does not hold"
                    : below > 2 * whole   ? "holds, but it gets worse long before that"
                                          : "holds";
  }
  return claim;
}

PaperClaim four_classes(const PaperMeasurements& m) {
  PaperClaim claim{"four colour classes are the practical limit", "", not_measured, "this row"};
  if (m.class_counts.size() < 2) return claim;
  for (std::size_t k = 0; k < m.class_counts.size(); ++k)
    claim.measured +=
        fmt::format("{}{} classes: {:.1f} % of the balls' pixels told right, {:.1f} % wrong",
                    k == 0 ? "" : "; ", m.class_counts[k], 100 * m.class_right[k], 100 * m.class_wrong[k]);
  const double wrong = m.class_wrong.back();
  claim.verdict = wrong > 0.05 ? "holds"
                  : wrong > 0.01
                      ? "holds if a pixel in a hundred must not be told wrong"
                      : fmt::format("does not hold: {} are told apart in this light", m.class_counts.back());
  return claim;
}

PaperClaim time_ratio(const std::string& says, const std::string& what, double us, double paper_us,
                      double read_us) {
  PaperClaim claim{says, "", not_measured, of_times};
  if (!(us > 0) || !(read_us > 0)) return claim;
  claim.measured = fmt::format("{} {:.2f} ms: {:.1f} times reading the frame once ({:.2f} ms)", what,
                               us / 1000, us / read_us, read_us / 1000);
  claim.verdict = us <= paper_us       ? "holds"
                  : us <= 2 * paper_us ? "holds if the machine is not shared"
                                       : "does not hold here";
  return claim;
}

PaperClaim boundary(const PaperMeasurements& m) {
  PaperClaim claim{"regions have far fewer boundary pixels than the picture has luminance edges", "",
                   not_measured, "this row"};
  if (!(m.edge_px > 0)) return claim;
  claim.measured = fmt::format(
      "{:.0f} boundary pixels of the ball's colour (four other things of it in view) against {:.0f} edge "
      "pixels (Canny): {:.1f} times fewer",
      m.boundary_px, m.edge_px, m.edge_px / m.boundary_px);
  claim.verdict = m.edge_px > 2 * m.boundary_px ? "holds"
                  : m.edge_px > m.boundary_px   ? "holds if fewer will do"
                                                : "does not hold";
  return claim;
}

}  // namespace

std::vector<PaperClaim> paper_claims(const ComparisonResults& results, const PaperMeasurements& m) {
  return {one_millimetre(results),
          votes(results, m),
          quality("Q_c of a round region is typically 4 times that of another", m.quality_ball,
                  m.quality_other, 4),
          quality("Q_c is 2 times larger even where a ball touches a region of its own colour",
                  m.quality_touching, m.quality_other, 2),
          one_step(results),
          drift(results),
          half_hidden(results),
          four_classes(m),
          time_ratio("2 ms for a 0.7 Mpix frame with one ball", "detection", m.detect_us, 2000, m.read_us),
          time_ratio("0.5 ms for the circle's estimation", "votes of one region", m.vote_us, 500, m.read_us),
          time_ratio("6 ms a frame for classification and connected components", "both", m.segment_us, 6000,
                     m.read_us),
          boundary(m)};
}

std::string claims_csv(const std::vector<PaperClaim>& claims) {
  std::string csv = "claim,measured,verdict,shown_by\n";
  for (const PaperClaim& claim : claims) {
    if (claim.shown_by != of_times)
      csv += csv_cell(claim.says) + ',' + csv_cell(claim.measured) + ',' + csv_cell(claim.verdict) + ',' +
             csv_cell(claim.shown_by) + '\n';
  }
  return csv;
}

}  // namespace ballservo
