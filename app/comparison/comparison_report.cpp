#include "app/comparison/comparison_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/comparison/certificate_section.hpp"
#include "app/comparison/comparison_answers.hpp"
#include "app/comparison/comparison_plots.hpp"
#include "app/comparison/step_verdict.hpp"
#include "app/report/page.hpp"

namespace ballservo {
namespace {

constexpr std::size_t most_examples = 16, most_tables = 40;

std::string found_words(const MethodStatistics& s) { return fmt::format("{} of {}", s.found, s.frames); }

std::string with_interval(double value, const ConfidenceInterval& interval) {
  if (!std::isfinite(interval.low)) return figure(value);
  return fmt::format("{} ({} to {})", figure(value), figure(interval.low), figure(interval.high));
}

PageTable answer_table(const ComparisonResults& results) {
  PageTable table;
  table.heading = {"condition", "what is shown"};
  table.number_columns = {false, false};
  for (const std::size_t k : one_step_pairs(results.methods)) {
    table.heading.push_back(results.methods[converged_pairs(results.methods)[k].a]->name + ": is it enough?");
    table.number_columns.push_back(false);
  }
  for (std::size_t c = 0; c < results.summaries.size(); ++c) {
    std::vector<std::string> row{results.conditions[c].name, results.conditions[c].words};
    for (const std::size_t k : one_step_pairs(results.methods))
      row.push_back(compare_steps(results.summaries[c], results.methods, k).words);
    table.rows.push_back(std::move(row));
  }
  return table;
}

PageTable error_table(const ComparisonResults& results, std::size_t c) {
  PageTable table;
  table.heading = {"method",
                   "found",
                   "median mm (95 % interval)",
                   "90 % mm",
                   "depth bias mm",
                   "depth spread mm",
                   "sideways spread mm",
                   "centre RMS px",
                   "radius bias px",
                   "RMS error / bound",
                   "failures charged, median mm"};
  const ConditionSummary& summary = results.summaries[c];
  for (std::size_t m = 0; m < results.methods.size(); ++m) {
    const MethodStatistics& s = summary.methods[m];
    const std::string charged = std::isinf(s.charged_median_mm) ? "most fail" : figure(s.charged_median_mm);
    table.rows.push_back({results.methods[m]->name, found_words(s),
                          with_interval(s.position_median_mm, s.position_median_ci95_mm),
                          figure(s.position_p90_mm), figure(s.depth_bias_mm), figure(s.depth_spread_mm),
                          figure(s.lateral_spread_mm), figure(s.center_rms_px), figure(s.radius_bias_px),
                          figure(s.rms_over_bound), charged});
  }
  return table;
}

PageTable pair_table(const ComparisonResults& results) {
  PageTable table;
  table.heading = {"condition",       "one fit",
                   "the other",       "frames",
                   "of them break",   "centre, median px (95 % interval)",
                   "centre, most px", "radius, median px",
                   "radius, most px", "3-D, median mm (95 % interval)",
                   "3-D, most mm"};
  table.number_columns = {false, false, false, true, true, true, true, true, true, true, true};
  const std::vector<MethodPair> pairs = converged_pairs(results.methods);
  for (std::size_t c = 0; c < results.summaries.size(); ++c) {
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const PairStatistics& s = results.summaries[c].pairs[k];
      if (s.frames == 0) continue;
      table.rows.push_back(
          {k == 0 ? results.conditions[c].name : "", results.methods[pairs[k].a]->name,
           results.methods[pairs[k].b]->name, std::to_string(s.frames), std::to_string(s.breaks),
           with_interval(s.center_median_px, s.center_median_ci95_px), figure(s.center_max_px),
           figure(s.radius_median_px), figure(s.radius_max_px),
           with_interval(s.position_median_mm, s.position_median_ci95_mm), figure(s.position_max_mm)});
    }
  }
  return table;
}

void add_examples(Page& page, const ComparisonResults& results, const ShowFrame& show_again,
                  const ComparisonReportText& text) {
  page.heading("What was shown");
  if (text.rendered)
    page.paragraph(
        "Each frame is rendered with exact truth: a shaded ball in front of a background, a light and "
        "clutter of its own. The ball's colour was learnt from three rendered pictures, as a user would. All "
        "methods see the same frames.");
  std::vector<PageFigure> examples;
  for (std::size_t c = 0; c < results.conditions.size() && examples.size() < most_examples; ++c) {
    const ConditionInfo& info = results.conditions[c];
    if (!info.swept_key.empty()) continue;
    examples.push_back(
        photo(example_photo(show_again(c, 0)), info.name + ": " + info.words, PictureFormat::png));
  }
  if (!examples.empty()) page.figures(examples, true);
}

void add_methods(Page& page, const ComparisonResults& results) {
  page.heading("The methods");
  PageTable table;
  table.heading = {"method", "what it does"};
  table.number_columns = {false, false};
  for (const FitMethod* method : results.methods) table.rows.push_back({method->name, method->minimises});
  page.table(table);
  std::vector<std::string> settings;
  for (std::size_t c = 0; c < results.conditions.size(); ++c) {
    if (!results.peer_words[c].empty())
      settings.push_back(results.conditions[c].name + ": " + results.peer_words[c]);
  }
  if (settings.empty()) return;
  page.begin_details("How the peers were set up");
  page.bullets(settings);
  page.end_details();
}

// Of any ball in space, as only a known camera and diameter do.
bool tells_places(const ComparisonResults& results) {
  return std::any_of(results.summaries.begin(), results.summaries.end(), [](const ConditionSummary& s) {
    return std::any_of(s.methods.begin(), s.methods.end(),
                       [](const MethodStatistics& m) { return std::isfinite(m.position_median_mm); });
  });
}

void add_errors(Page& page, const ComparisonResults& results, const ComparisonReportText& text) {
  page.heading("How far from the truth");
  if (!text.rendered)
    page.note(
        "Where a row tells the ball's circle, errors are against that circle, as well as whoever drew it "
        "could see it. Where it tells nothing, methods can only be held against each other: that they agree "
        "does not show that they are right, only that what they have in common decides.");
  if (!tells_places(results)) {
    page.paragraph("No place in space is known: the tables below hold centres and radii in the picture.");
    return;
  }
  page.paragraph(
      "Bars and dots are medians over the frames in which the method found the ball (its centre within half "
      "the ball's radius of the truth); thin vertical lines are their 95 % bootstrap intervals. The bound "
      "(Cramer and Rao's) is the RMS error that no unbiased estimator can fall below in the same frames, one "
      "that is told the camera and the ball's size, but not the blur nor, in each stretch of the outline, "
      "the background, the contrast and the shading. RMS error / bound in the tables below is a method's RMS "
      "error over it: 1 is all that the pixels give.");
  const bool has_bars = std::any_of(results.conditions.begin(), results.conditions.end(),
                                    [](const ConditionInfo& info) { return info.swept_key.empty(); });
  if (has_bars)
    page.figure(drawing(error_bars(results), "Shorter is better; one grid line to the next is a factor."));
  std::vector<PageFigure> figures;
  for (const Sweep& sweep : sweeps_of(results)) {
    const bool of_start = sweep.key.find("start.") == 0;
    figures.push_back(drawing(sweep_error_plot(results, sweep),
                              std::string("Solid: one step. Dashed: converged on the same points.") +
                                  (of_start ? " The fits start from the true circle, displaced: vote is that "
                                              "start."
                                            : "")));
  }
  if (!figures.empty()) page.figures(figures);
  if (!results.conditions.empty()) {
    page.figure(
        drawing(ellipse_plot(results, 0),
                "Bias (where an ellipse's middle lies) and two sigmas of the spread. Depth is the hard "
                "direction: it follows from the radius alone."));
  }
}

void add_steps(Page& page, const ComparisonResults& results) {
  const std::vector<MethodPair> pairs = converged_pairs(results.methods);
  const std::vector<std::size_t> ones = one_step_pairs(results.methods);
  if (ones.empty()) return;
  page.heading("How far one step is from the converged fit");
  std::vector<PageFigure> figures;
  for (const std::size_t k : ones) {
    figures.push_back(drawing(difference_plot(results, k),
                              "A curve that rises early means that the two agree in nearly every frame. "
                              "Differences below 0.0001 px are drawn there."));
    if (!tells_places(results)) continue;
    figures.push_back(drawing(scatter_plot(results, pairs[k]),
                              "On the dashed line both err alike; below it one step is the better."));
  }
  for (const Sweep& sweep : sweeps_of(results))
    figures.push_back(drawing(
        sweep_pair_plot(results, sweep),
        fmt::format("Solid: the median with its 95 % interval. Dashed: the worst frame. Beyond {:g} px a "
                    "frame counts as broken; a gap is where no frame was found.",
                    break_px)));
  page.figures(figures);
  page.paragraph(
      "A Gauss-Newton step is exact where the residual is linear. Moving the circle by d bends its distance "
      "to a point by about d squared over twice the radius: a start that is a pixel off leaves about 1/60 px "
      "for a ball of 60 px. A worse start, a smaller ball, or points on one side only leave more.");
}

void add_costs(Page& page, const ComparisonResults& results) {
  page.heading("What each costs");
  PageTable table;
  table.heading = {"method", "processor time a frame, ms", "3-D error, median mm", "found"};
  double own_ms = 0, peers_ms = 0;
  for (std::size_t m = 0; m < results.methods.size(); ++m) {
    std::vector<double> times_ms, errors_mm;
    int found = 0, frames = 0;
    for (const ConditionSummary& summary : results.summaries) {
      const MethodStatistics& s = summary.methods[m];
      if (std::isfinite(s.time_us_median)) times_ms.push_back(s.time_us_median / 1000);
      if (std::isfinite(s.position_median_mm)) errors_mm.push_back(s.position_median_mm);
      found += s.found;
      frames += s.frames;
    }
    const double median_ms = median(times_ms);
    table.rows.push_back({results.methods[m]->name, figure(median_ms), figure(median(errors_mm)),
                          fmt::format("{} of {}", found, frames)});
    if (std::isfinite(median_ms)) (results.methods[m]->is_peer ? peers_ms : own_ms) += median_ms;
  }
  page.paragraph(fmt::format(
      "A frame through all methods but the peers takes {} ms of one core: {:.0f} frames a second{}. "
      "Processor time of one thread, medians over the conditions. A fit's time begins at the "
      "starting circle and includes the choice of its points; a peer's begins at the picture. So does that "
      "of vote, which is a whole detection by a detector that was made for this one frame: colours, regions, "
      "votes, the fit, and getting its memory. A detector that runs takes a fraction of that, and the votes "
      "of one region a fraction of a millisecond: the claims about times above, where they were looked at, "
      "are of those.",
      figure(own_ms), own_ms > 0 ? 1000 / own_ms : 0,
      peers_ms > 0 ? "; the peers take " + figure(peers_ms) + " ms" : ""));
  if (tells_places(results))
    page.figure(drawing(cost_plot(results), "Down and to the left is better. Small and pale: converged."));
  page.begin_details("Method by method: cost, error of the median condition, balls found in all conditions");
  page.table(table);
  page.end_details();
}

void add_worst(Page& page, const ComparisonResults& results, const ShowFrame& show_again) {
  const auto show = [&](const std::vector<NotableFrame>& frames, const std::string& title,
                        const std::string& unit) {
    if (frames.empty()) return;
    page.heading(title);
    page.paragraph(
        "White: the truth. Grey: the votes. Orange: the paper's fits. Blue: the exact ones. Green: "
        "algebraic. Magenta: peers.");
    std::vector<PageFigure> photos;
    for (const NotableFrame& frame : frames) {
      const ConditionInfo& info = results.conditions[frame.condition];
      const std::string value = frame.value >= 1e9 ? "not found" : figure(frame.value) + unit;
      photos.push_back(
          photo(outlines_photo(show_again(frame.condition, frame.index), frame.record, results.methods),
                fmt::format("{}, frame {} ({}): {}", info.name, frame.record.truth.frame,
                            frame.record.truth.source, value)));
    }
    page.figures(photos);
  };
  const bool in_space = !results.worst.empty() && results.worst.front().record.truth.p_CB.has_value();
  show(results.worst, "The worst frames of what runs on line", in_space ? " mm off" : " px off");
  show(results.most_apart, "Where one step is furthest from the converged fit",
       " px apart (centres or radii)");
}

void add_tables(Page& page, const ComparisonResults& results) {
  page.heading("Every figure");
  page.paragraph(
      "Failures are never dropped: the last column is the median over all frames, one in which a method does "
      "not find the ball counted as an error without bound. Depth bias: a radius that is read too large puts "
      "the ball too near (negative). RMS error / bound: of the frames found that have a bound (Cramer and "
      "Rao's, see \"How far from the truth\"); 1 is all that the pixels give. Paired tests of all methods "
      "against sphere_one_step and paper_one_step are in tests.csv.");
  for (std::size_t c = 0; c < results.summaries.size() && c < most_tables; ++c) {
    page.begin_details(results.conditions[c].name + ": " + results.conditions[c].words);
    page.table(error_table(results, c));
    page.end_details();
  }
  if (results.summaries.size() > most_tables) page.paragraph("The other conditions are in compare.csv.");
  page.begin_details("Is one step enough? Condition by condition");
  page.table(answer_table(results));
  page.end_details();
  page.begin_details(
      "One step, more steps and robust fits against the converged fit, condition by condition");
  page.table(pair_table(results));
  page.end_details();
}

}  // namespace

std::string comparison_report_html(const ComparisonResults& results, const ShowFrame& show,
                                   const ComparisonReportText& text, const std::vector<PaperClaim>& claims) {
  Page page("Is one step enough?", "Every estimator of the ball on the same pixels: " + text.subject);
  page.paragraph(
      std::string("On line, the ball's outline is refined by one Gauss-Newton step on the edges measured "
                  "around it, as in ") +
      the_paper +
      ". Here the same residuals on the same points with the same weights are also handed to Ceres, a "
      "general solver that goes on until nothing improves: the converged fit. Where the two agree, what "
      "error is left comes from the pixels and the model, not from stopping early. Two models are fitted: "
      "the paper's, a circle on a ring of pixels, each weighted by its gradient; and the exact one, which is "
      "what runs here: the cone of all rays that touch the ball, on edges measured to a fraction of a "
      "pixel.");
  add_answers(page, results);
  add_claims(page, claims);
  add_steps(page, results);
  add_errors(page, results, text);
  add_certificates(page, results);
  add_costs(page, results);
  if (show) {
    add_worst(page, results, show);
    add_examples(page, results, show, text);
  } else {
    page.note("The pictures are not at hand here: the worst frames are shown by each part's own page.");
  }
  add_methods(page, results);
  add_tables(page, results);
  page.begin_details("The setting, as it was read");
  page.code(text.setting);
  page.end_details();
  page.paragraph(
      "Every fit of every frame is in fits.csv beside this page, every frame's truth in frames.csv, times in "
      "timing.csv, the tables in LaTeX in tables.tex.");
  return page.html();
}

}  // namespace ballservo
