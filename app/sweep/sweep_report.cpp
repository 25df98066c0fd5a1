#include "app/sweep/sweep_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "app/report/page.hpp"
#include "app/report/svg_plot.hpp"
#include "app/sweep/sweep_drawings.hpp"

namespace ballservo {
namespace {

constexpr double degree = 0.017453292519943295;
constexpr std::size_t most_ways = 300, most_worst = 8, most_drawn_plots = 8;

std::string percent(double share) {
  return std::isfinite(share) ? fmt::format("{:.2f} %", share * 100) : "-";
}

std::string rate_text(long part, long whole) {
  if (whole == 0) return "-";
  const ConfidenceInterval ci = clopper_pearson_ci95(part, whole);
  return fmt::format("{} of {}: {} (95 % interval {} to {})", part, whole,
                     percent(static_cast<double>(part) / static_cast<double>(whole)), percent(ci.low),
                     percent(ci.high));
}

std::string quoted(const std::string& word) {
  const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("_-./=:,+").find(static_cast<char>(c)) != std::string::npos;
  });
  if (plain) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// The worst first: collisions, then other failures, then by settling time over the time-optimal one.
std::vector<const Trial*> worst_trials(const std::vector<Trial>& trials) {
  std::vector<const Trial*> worst;
  for (const Trial& trial : trials) {
    if (trial.feasible) worst.push_back(&trial);
  }
  const auto badness = [](const Trial* trial) {
    switch (trial->summary.outcome) {
      case Outcome::collision:
        return trial->summary.collision_cause == "none_broken" ? 1e6 : 5e5;
      case Outcome::hit_by:
      case Outcome::fault:
        return 2e5;
      case Outcome::lost:
        return 1e5;
      case Outcome::timeout:
      case Outcome::interrupted:
        return 5e4 + std::min(std::abs(trial->summary.range_error_m), 100.0);
      case Outcome::reached:
        break;
    }
    const double ratio = trial->summary.settled_s / trial->summary.time_optimal_s;
    return std::isfinite(ratio) ? ratio : 0;
  };
  std::stable_sort(worst.begin(), worst.end(),
                   [&](const Trial* a, const Trial* b) { return badness(a) > badness(b); });
  if (worst.size() > most_worst) worst.resize(most_worst);
  return worst;
}

std::map<std::uint64_t, TrialTrace> traces_of(const Sweep& sweep, const std::set<std::uint64_t>& seeds) {
  std::map<std::uint64_t, TrialTrace> traces;
  std::istringstream lines(sweep.traces_jsonl);
  for (std::string line; std::getline(lines, line);) {
    // {"seed":N,...: read whole only where it is wanted
    const std::size_t begin = line.find(':') + 1;
    const std::uint64_t seed = std::strtoull(line.c_str() + begin, nullptr, 10);
    if (seeds.count(seed) != 0) traces[seed] = parse_trace(line, "traces.jsonl");
  }
  return traces;
}

void add_ways(Page& page, const Sweep& sweep) {
  std::set<std::uint64_t> shown;
  for (const bool failed : {true, false}) {
    for (const Trial& trial : sweep.trials) {
      if (trial.feasible && trial.reached() != failed && shown.size() < most_ways) shown.insert(trial.seed);
    }
  }
  const auto traces = traces_of(sweep, shown);
  std::vector<DrawnTrial> drawn;
  for (const Trial& trial : sweep.trials) {
    const auto trace = traces.find(trial.seed);
    if (trace != traces.end()) drawn.push_back({trace->second, trial.reached()});
  }
  page.heading("All ways");
  page.figures(
      {drawing(ways_drawing(drawn),
               fmt::format("{} of the trials, failures first. Thin: reached. Thick, ending in a dot: "
                           "not reached. Small dots: where the balls were at the start. Obstacles are "
                           "shown where all trials share them.",
                           drawn.size()))});
}

PlotOptions histogram_options(const std::string& title, const std::string& label) {
  PlotOptions options;
  options.title = title;
  options.x.label = label;
  options.y.label = "trials";
  options.width_px = 480;
  options.height_px = 280;
  return options;
}

void add_distributions(Page& page, const Sweep& sweep) {
  std::vector<double> ratio, range_mm, bearing_deg, rms_mm;
  for (const Trial& trial : sweep.trials) {
    if (!trial.reached()) continue;
    ratio.push_back(trial.summary.settled_s / trial.summary.time_optimal_s);
    range_mm.push_back(trial.summary.range_error_m * 1e3);
    bearing_deg.push_back(trial.summary.bearing_error_rad / degree);
    rms_mm.push_back(trial.summary.range_rms_m * 1e3);
  }
  page.heading("Distributions");
  page.figures(
      {drawing(histogram_plot(values_of(sweep.trials, &RunSummary::settled_s, true), 30,
                              histogram_options("Settling time", "settled (s)")),
               "Of those that reached."),
       drawing(
           histogram_plot(ratio, 30, histogram_options("Over the time-optimal run", "ratio")),
           "Settling time over that of a turn on the spot and a straight way, both at the drive's limits."),
       drawing(
           histogram_plot(range_mm, 30, histogram_options("Distance error", "mean of the last second (mm)")),
           "Of those that reached."),
       drawing(histogram_plot(bearing_deg, 30,
                              histogram_options("Bearing error", "mean of the last second (deg)")),
               "Of those that reached."),
       drawing(histogram_plot(rms_mm, 30, histogram_options("Distance, rms", "rms from settling on (mm)")),
               "Of those that reached."),
       drawing(histogram_plot(values_of(sweep.trials, &RunSummary::min_clearance_m, false), 30,
                              histogram_options("Least clearance", "clearance (m)")),
               "From the footprint to the nearest wall or obstacle; all feasible trials."),
       drawing(histogram_plot(values_of(sweep.trials, &RunSummary::out_of_view_s, false), 30,
                              histogram_options("Ball out of view", "time (s)")),
               "All feasible trials.")});
}

/// Success in equal cells of the values that seeds drew.
PageFigure success_figure(const std::vector<std::pair<double, bool>>& values, const std::string& key) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double from = low->first, to = high->first;
  const int bins = std::clamp(static_cast<int>(values.size() / 25), 2, 12);
  std::vector<long> reached(static_cast<std::size_t>(bins)), all(static_cast<std::size_t>(bins));
  for (const auto& [value, good] : values) {
    const double place = to > from ? (value - from) / (to - from) * bins : 0;
    const auto bin = static_cast<std::size_t>(std::clamp(static_cast<int>(place), 0, bins - 1));
    ++all[bin];
    reached[bin] += good ? 1 : 0;
  }
  PlotSeries rate, bottom, top;
  rate.style = SeriesStyle::line_and_points;
  bottom.dashed = top.dashed = true;
  bottom.width_px = top.width_px = 1;
  bottom.color = top.color = PlotColor::series(0);
  for (int k = 0; k < bins; ++k) {
    const auto bin = static_cast<std::size_t>(k);
    if (all[bin] == 0) continue;
    const ConfidenceInterval ci = clopper_pearson_ci95(reached[bin], all[bin]);
    const double x = from + (k + 0.5) * (to - from) / bins;
    for (PlotSeries* series : {&rate, &bottom, &top}) series->x.push_back(x);
    rate.y.push_back(100.0 * static_cast<double>(reached[bin]) / static_cast<double>(all[bin]));
    bottom.y.push_back(100 * ci.low);
    top.y.push_back(100 * ci.high);
  }
  PlotOptions options = histogram_options("Success by " + key, key);
  options.y.label = "reached (%)";
  options.y.low = 0;
  options.y.high = 100;
  return drawing(line_plot({rate, bottom, top}, options), "Dashed: 95 % intervals.");
}

/// Each trial at the two values that its seed drew.
PageFigure scatter_figure(const std::vector<Trial>& trials, std::size_t a, std::size_t b) {
  PlotSeries good, bad;
  good.name = "reached";
  bad.name = "not reached";
  good.style = bad.style = SeriesStyle::points;
  good.opacity = 0.5;
  good.marker_px = 2;
  bad.color = PlotColor::series(1);
  PlotOptions options;
  options.width_px = 480;
  options.height_px = 360;
  for (const Trial& trial : trials) {
    if (!trial.feasible || trial.drawn.size() <= std::max(a, b)) continue;
    options.x.label = trial.drawn[a].first;
    options.y.label = trial.drawn[b].first;
    PlotSeries& series = trial.reached() ? good : bad;
    series.x.push_back(trial.drawn[a].second);
    series.y.push_back(trial.drawn[b].second);
  }
  options.title = "Where it succeeds";
  return drawing(line_plot({good, bad}, options), "One dot a trial.");
}

void add_drawn(Page& page, const std::vector<Trial>& trials) {
  std::map<std::string, std::vector<std::pair<double, bool>>> by_key;
  std::size_t keys = 0;
  for (const Trial& trial : trials) {
    if (!trial.feasible) continue;
    keys = std::max(keys, trial.drawn.size());
    for (const auto& [key, value] : trial.drawn) {
      if (std::isfinite(value)) by_key[key].emplace_back(value, trial.reached());
    }
  }
  std::vector<PageFigure> figures;
  for (const auto& [key, values] : by_key) {
    if (values.size() >= 50 && figures.size() < most_drawn_plots)
      figures.push_back(success_figure(values, key));
  }
  for (std::size_t a = 0; a < std::min<std::size_t>(keys, 3); ++a) {
    for (std::size_t b = a + 1; b < std::min<std::size_t>(keys, 3); ++b) {
      figures.push_back(scatter_figure(trials, a, b));
    }
  }
  if (figures.empty()) return;
  page.heading("By what a seed draws");
  page.figures(figures);
}

void add_failures(Page& page, const Sweep& sweep) {
  const std::vector<FailureGroup> groups = failure_groups(sweep.trials);
  page.heading("What went wrong");
  if (groups.empty()) {
    page.paragraph("Nothing: every trial reached the ball.");
    return;
  }
  const long feasible = count_trials(sweep.trials).feasible();
  PageTable table;
  table.heading = {"outcome", "cause, or the controller's last word", "trials", "share", "seeds"};
  table.number_columns = {false, false, true, true, false};
  for (const FailureGroup& group : groups) {
    std::string seeds;
    for (const std::uint64_t seed : group.seeds) seeds += (seeds.empty() ? "" : ", ") + std::to_string(seed);
    if (group.count > static_cast<long>(group.seeds.size())) seeds += ", ...";
    const bool counted = group.outcome != "infeasible";
    table.rows.push_back(
        {group.outcome, group.cause, std::to_string(group.count),
         counted ? percent(static_cast<double>(group.count) / static_cast<double>(feasible)) : "not counted",
         seeds});
  }
  page.table(table);
}

void add_worst(Page& page, const Sweep& sweep) {
  const std::vector<const Trial*> worst = worst_trials(sweep.trials);
  if (worst.empty()) return;
  std::set<std::uint64_t> seeds;
  for (const Trial* trial : worst) seeds.insert(trial->seed);
  auto traces = traces_of(sweep, seeds);
  const double distance_m = sweep.description.value("distance_m", 0.0);
  page.heading("The worst trials");
  std::vector<PageFigure> figures;
  std::string commands;
  for (const Trial* trial : worst) {
    const auto trace = traces.find(trial->seed);
    const std::string caption =
        fmt::format("Seed {}: {}. {}.", trial->seed, trial->outcome_text(), trial->why);
    if (trace != traces.end()) {
      figures.push_back(drawing(way_drawing({trace->second, trial->reached()}, distance_m, 300), caption));
    }
    commands += trial_command(sweep.description, trial->seed) + "\n";
  }
  page.figures(figures, true);
  page.paragraph("Each of them as a film, with its own report:");
  page.code(commands);
}

void add_comparison(Page& page, const Sweep& sweep, const SweepComparison& c) {
  page.heading("Against " + c.other);
  page.paragraph(fmt::format(
      "Paired by seed: this sweep (law {}, perception {}) less the other (law {}, perception {}); {} pairs, "
      "{} trials without a partner.",
      sweep.description.value("law", ""), sweep.description.value("perception", ""), c.other_law,
      c.other_perception, c.reached.pairs(), c.unmatched));
  if (c.other_worlds > 0) {
    page.note(
        fmt::format("In {} pairs the seed drew other values in the other sweep: they are different worlds.",
                    c.other_worlds));
  }
  PageTable table;
  table.heading = {"", "both", "only this", "only the other", "neither", "difference", "95 % interval"};
  for (const auto& [name, counts] : {std::pair<std::string, const MatchedCounts&>{"reached", c.reached},
                                     {"no collision", c.no_collision}}) {
    const ConfidenceInterval ci = matched_difference_ci95(counts);
    table.rows.push_back({name, std::to_string(counts.both), std::to_string(counts.only_first),
                          std::to_string(counts.only_second), std::to_string(counts.neither),
                          percent(counts.difference()), percent(ci.low) + " to " + percent(ci.high)});
  }
  page.table(table);
  PageTable medians;
  medians.heading = {"paired difference", "pairs", "median", "95 % interval of the median"};
  for (const SweepComparison::Difference& d : c.differences) {
    if (d.pairs == 0) continue;
    medians.rows.push_back(
        {d.name, std::to_string(d.pairs), fmt::format("{:.4g} {}", d.median * d.scale, d.unit),
         std::isfinite(d.median_ci95.low) ? fmt::format("{:.4g} to {:.4g} {}", d.median_ci95.low * d.scale,
                                                        d.median_ci95.high * d.scale, d.unit)
                                          : "-"});
  }
  if (!medians.rows.empty()) page.table(medians);
}

std::string spread(std::vector<double> values, double scale, const char* unit) {
  if (values.empty()) return "-";
  std::sort(values.begin(), values.end());
  const auto at = [&](double fraction) {
    return values[static_cast<std::size_t>(std::lround(fraction * static_cast<double>(values.size() - 1)))] *
           scale;
  };
  return fmt::format("{:.3g} {} (5 % {:.3g}, 95 % {:.3g})", at(0.5), unit, at(0.05), at(0.95));
}

void add_figures(Page& page, const Sweep& sweep) {
  const SweepCounts n = count_trials(sweep.trials);
  const std::vector<Trial>& t = sweep.trials;
  page.key_values(
      {{"reached", rate_text(n.reached, n.feasible())},
       {"collisions", rate_text(n.collisions, n.feasible())},
       {"collisions inside the assumptions", std::to_string(n.collisions_inside_assumptions)},
       {"infeasible worlds, not counted", std::to_string(n.infeasible)},
       {"settled after, median", spread(values_of(t, &RunSummary::settled_s, true), 1, "s")},
       {"rms distance error", spread(values_of(t, &RunSummary::range_rms_m, true), 1e3, "mm")},
       {"rms bearing error", spread(values_of(t, &RunSummary::bearing_rms_rad, true), 1 / degree, "deg")},
       {"least clearance", spread(values_of(t, &RunSummary::min_clearance_m, false), 1, "m")},
       {"ball out of view", spread(values_of(t, &RunSummary::out_of_view_s, false), 1, "s")}});
}

}  // namespace

std::string trial_command(const nlohmann::json& description, std::uint64_t seed) {
  std::string command = "ballservo servo " +
                        quoted(description.at(WorkJob::places_key).at("scenario_file").get<std::string>()) +
                        fmt::format(" -o seed_{} --seed {} --perception ", seed, seed) +
                        description.at("perception").get<std::string>();
  for (const nlohmann::json& set : description.at("sets"))
    command += " --set " + quoted(set.get<std::string>());
  return command + " --video";
}

std::string sweep_report_html(const Sweep& sweep, const Shard& shard, bool interrupted,
                              const SweepComparison* against) {
  const SweepCounts n = count_trials(sweep.trials);
  const std::string name =
      std::filesystem::path(sweep.description.at(WorkJob::places_key).at("scenario_file").get<std::string>())
          .stem();
  Page page(name, fmt::format("{} runs: law {}, perception {}", n.trials, sweep.description.value("law", ""),
                              sweep.description.value("perception", "")));
  page.note("Reached the ball: " + rate_text(n.reached, n.feasible()) + ".");
  if (interrupted) {
    page.note(fmt::format("Interrupted: {} of {} trials are done. --resume goes on.", n.trials,
                          sweep.description.value("trials", 0L)));
  }
  const std::string gain = sweep.description.value("gain_warning", "");
  if (!gain.empty()) page.note("Mind: " + gain + ".");
  if (!shard.is_whole()) page.note("Part " + shard.to_text() + " of the sweep; sweep merge joins the parts.");
  add_figures(page, sweep);
  if (against != nullptr) add_comparison(page, sweep, *against);
  add_ways(page, sweep);
  add_failures(page, sweep);
  add_worst(page, sweep);
  add_drawn(page, sweep.trials);
  add_distributions(page, sweep);
  page.begin_details("The scenario");
  page.code(sweep.description.at("scenario").dump(2));
  page.end_details();
  return page.html();
}

}  // namespace ballservo
