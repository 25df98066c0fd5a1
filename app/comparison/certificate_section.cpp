#include "app/comparison/certificate_section.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/comparison/comparison_plots.hpp"
#include "app/comparison/step_verdict.hpp"
#include "perception/outline/ball_fitter.hpp"

namespace ballservo {
namespace {

std::string percent(double rate) {
  return std::isfinite(rate) ? fmt::format("{:.1f} %", 100 * rate) : std::string("-");
}

// Rules that never ask for a step are all the same: the first stands for them.
bool asks(const CertificateRule& rule) { return std::isfinite(rule.threshold); }

PageTable rule_table(const std::vector<Certificate>& certificates) {
  PageTable table;
  table.heading = {"fit", "rule", "frames tested", "breaks", "caught", "false alarms", "area under the ROC"};
  table.number_columns = {false, false, true, true, true, true, true};
  for (const Certificate& certificate : certificates) {
    for (const CertificateRule& rule : certificate.rules) {
      const bool first = &rule == &certificate.rules.front();
      if (!asks(rule) && !first) continue;
      const CertificateScore& s = rule.tested;
      table.rows.push_back({certificate.one_step, rule.words, std::to_string(s.frames),
                            std::to_string(s.breaks), percent(s.caught_rate()), percent(s.false_alarm_rate()),
                            figure(s.area)});
    }
  }
  return table;
}

std::string worth_of(const Certificate& c) {
  const CertificateScore& s = c.rules.front().tested;
  if (!asks(c.rules.front()))
    return fmt::format(
        "{}: no rule could be made, for nothing broke where it would have been learnt; {} of the {} frames "
        "tested break, the largest distance (of centres or radii) is {} px.",
        c.one_step, s.breaks, s.frames, figure(c.largest_before_px));
  return fmt::format(
      "{}: one more step where the first rule asks for it is taken in {} of the frames tested and leaves {} "
      "breaks of {}; the largest distance (of centres or radii) falls from {} px to {} px.",
      c.one_step, percent(c.second_step_rate), c.breaks_after, c.breaks_before, figure(c.largest_before_px),
      figure(c.largest_after_px));
}

}  // namespace

void add_certificates(Page& page, const ComparisonResults& results) {
  const std::vector<Certificate>& certificates = results.certificates;
  const auto tested = [](const Certificate& c) { return c.rules.front().tested.frames > 0; };
  if (std::none_of(certificates.begin(), certificates.end(), tested)) return;  // one condition alone
  page.heading("Can one step tell that it broke?");
  page.paragraph(fmt::format(
      "One step breaks in a frame where centre or radius lies more than {:g} px from the converged fit's. "
      "The rules see only what the step itself knows, nothing of the converged fit; they are made on every "
      "other condition and tested on the rest, whose frames alone are counted here. Frames in which only one "
      "of the two fits is at the ball count, too. Caught: of the breaks, "
      "those at which the rule asks for one more step. False alarms: of the other frames, those at which it "
      "does so too. The area under the ROC is 1 for a score that tells perfectly and 0.5 for one that "
      "guesses.",
      break_px));
  page.table(rule_table(certificates));
  const bool drawn = std::any_of(certificates.begin(), certificates.end(), [](const Certificate& c) {
    return c.rules.front().tested.breaks >= fewest_breaks_drawn;
  });
  if (drawn)
    page.figure(drawing(roc_plot(certificates),
                        fmt::format("Up and to the left is better. next_step: by the length of the step that "
                                    "would follow; bend: by this step's squared; logistic: by four things "
                                    "together. Fits with fewer than {} breaks are left out.",
                                    fewest_breaks_drawn)));
  std::vector<std::string> worth;
  for (const Certificate& c : certificates) {
    if (tested(c)) worth.push_back(worth_of(c));
  }
  page.bullets(worth);
  page.paragraph(fmt::format(
      "On line the first rule's quantity decides: a detection says that one step was enough "
      "where the step that would follow is at most {:g} px long, and the exact fit looks at the "
      "picture again where it is longer. What is tested above is what that has left. None of this tells "
      "how far the fit is from the truth, only whether going on would move it.",
      enough_next_step_px));
}

}  // namespace ballservo
