#include "app/sweep/sweep_statistics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "app/experiment/run_log.hpp"
#include "calibration/base/statistics.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {
namespace {

constexpr std::size_t seeds_shown = 8;

nlohmann::ordered_json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json interval_json(const ConfidenceInterval& interval) {
  return nlohmann::ordered_json::array({finite_or_null(interval.low), finite_or_null(interval.high)});
}

double share(long part, long whole) {
  return whole == 0 ? not_known : static_cast<double>(part) / static_cast<double>(whole);
}

/// {"p50": .., "p95": ..}
nlohmann::ordered_json quantiles(const std::vector<double>& values, std::array<int, 2> percents) {
  nlohmann::ordered_json result;
  for (const int percent : percents) {
    result["p" + std::to_string(percent)] = finite_or_null(quantile(values, percent / 100.0));
  }
  return result;
}

nlohmann::ordered_json counts_json(const MatchedCounts& counts) {
  return {{"pairs", counts.pairs()},
          {"both", counts.both},
          {"only_this", counts.only_first},
          {"only_other", counts.only_second},
          {"neither", counts.neither},
          {"difference", finite_or_null(counts.difference())},
          {"difference_ci95", interval_json(matched_difference_ci95(counts))}};
}

/// A figure of a run, and two of its quantiles. `reached_only`: it means something where the ball was
/// reached.
struct Figure {
  const char* name;
  double RunSummary::*value;
  bool reached_only;
  std::array<int, 2> percents;
};
constexpr Figure sweep_figures[] = {{"settled_s", &RunSummary::settled_s, true, {50, 95}},
                                    {"range_rms_m", &RunSummary::range_rms_m, true, {50, 95}},
                                    {"bearing_rms_rad", &RunSummary::bearing_rms_rad, true, {50, 95}},
                                    {"min_clearance_m", &RunSummary::min_clearance_m, false, {5, 50}},
                                    {"out_of_view_s", &RunSummary::out_of_view_s, false, {50, 95}}};

/// Failures alike, of the same outcome for the same cause: the most frequent first; infeasible trials last.
std::vector<nlohmann::ordered_json> failure_groups(const std::vector<Trial>& trials) {
  std::map<std::pair<std::string, std::string>, std::vector<std::uint64_t>> alike;
  for (const Trial& trial : trials) {
    if (trial.reached()) continue;
    const std::string cause = trial.feasible ? trial.cause() : "its world cannot be";
    alike[{trial.outcome_text(), cause}].push_back(trial.seed);
  }
  std::vector<nlohmann::ordered_json> groups;
  for (auto& [failure, seeds] : alike) {
    const std::size_t count = seeds.size();
    seeds.resize(std::min(count, seeds_shown));
    groups.push_back(
        {{"outcome", failure.first}, {"cause", failure.second}, {"count", count}, {"seeds", seeds}});
  }
  std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
    const bool a_last = a["outcome"] == "infeasible", b_last = b["outcome"] == "infeasible";
    return a_last != b_last ? b_last : a["count"] > b["count"];
  });
  return groups;
}

/// Over the feasible trials where it is known.
std::vector<double> values_of(const std::vector<Trial>& trials, const Figure& figure) {
  std::vector<double> values;
  for (const Trial& trial : trials) {
    if (!trial.feasible || (figure.reached_only && !trial.reached())) continue;
    if (std::isfinite(trial.summary.*figure.value)) values.push_back(trial.summary.*figure.value);
  }
  return values;
}

}  // namespace

nlohmann::ordered_json compare_sweeps(const Sweep& sweep, const Sweep& other, const std::string& other_name) {
  std::map<std::uint64_t, const Trial*> others;
  for (const Trial& trial : other.trials) others[trial.seed] = &trial;
  MatchedCounts reached, no_collision;
  long other_worlds = 0;
  std::array<std::vector<double>, std::size(sweep_figures)> differences;
  for (const Trial& a : sweep.trials) {
    const auto found = others.find(a.seed);
    if (found == others.end() || !a.feasible || !found->second->feasible) continue;
    const Trial& b = *found->second;
    other_worlds += a.drawn == b.drawn ? 0 : 1;
    reached.add(a.reached(), b.reached());
    no_collision.add(!a.collided(), !b.collided());
    for (std::size_t k = 0; k < differences.size(); ++k) {
      if (sweep_figures[k].reached_only && !(a.reached() && b.reached())) continue;
      const double difference = a.summary.*sweep_figures[k].value - b.summary.*sweep_figures[k].value;
      if (std::isfinite(difference)) differences[k].push_back(difference);
    }
  }
  const auto all = static_cast<long>(sweep.trials.size() + other.trials.size());
  nlohmann::ordered_json result{{"other", other_name},
                                {"success", counts_json(reached)},
                                {"no_collision", counts_json(no_collision)},
                                {"unmatched", all - 2 * reached.pairs()},
                                {"pairs_with_other_worlds", other_worlds}};
  for (std::size_t k = 0; k < differences.size(); ++k)
    result["median_differences"][sweep_figures[k].name] = {
        {"pairs", differences[k].size()},
        {"median", finite_or_null(median(differences[k]))},
        {"ci95", interval_json(median_ci95(differences[k]))}};
  return result;
}

nlohmann::ordered_json sweep_summary_json(const Sweep& sweep, const Shard& shard, bool interrupted,
                                          const nlohmann::ordered_json& against) {
  const std::vector<Trial>& trials = sweep.trials;
  long infeasible = 0, reached = 0, collisions = 0, inside_assumptions = 0, touched = 0;
  std::vector<double> ratios, range_errors, bearing_errors;
  for (const Trial& trial : trials) {
    infeasible += trial.feasible ? 0 : 1;
    collisions += trial.collided() ? 1 : 0;
    inside_assumptions += trial.collided() && trial.summary.collision_cause == "none_broken" ? 1 : 0;
    touched += trial.feasible && trial.summary.ball_contacts > 0 ? 1 : 0;
    if (!trial.reached()) continue;
    ++reached;
    ratios.push_back(trial.summary.settled_s / trial.summary.time_optimal_s);
    range_errors.push_back(std::abs(trial.summary.range_error_m));
    bearing_errors.push_back(std::abs(trial.summary.bearing_error_rad));
  }
  const long feasible = static_cast<long>(trials.size()) - infeasible;
  nlohmann::ordered_json json;
  json["trials"] = trials.size();
  json["infeasible"] = infeasible;
  json["reached"] = reached;
  json["collisions"] = collisions;
  json["collisions_inside_assumptions"] = inside_assumptions;
  json["success_rate"] = finite_or_null(share(reached, feasible));
  json["success_ci95"] = interval_json(clopper_pearson_ci95(reached, feasible));
  json["collision_ci95"] = interval_json(clopper_pearson_ci95(collisions, feasible));
  for (const Figure& figure : sweep_figures)
    json[figure.name] = quantiles(values_of(trials, figure), figure.percents);
  json["touched"] = touched;
  json["settled_over_time_optimal"] = quantiles(ratios, {50, 95});
  json["range_error_abs_m"] = quantiles(range_errors, {50, 95});
  json["bearing_error_abs_rad"] = quantiles(bearing_errors, {50, 95});
  json["failures"] = failure_groups(trials);
  json["trials_planned"] = sweep.description.value("trials", 0L);
  json["shard"] = shard.to_text();
  json["first_seed"] = sweep.description.value("first_seed", std::uint64_t{0});
  json["scenario_hash"] = sweep.description.value("scenario_hash", "");
  json["perception"] = sweep.description.value("perception", "");
  json["law"] = sweep.description.value("law", "");
  json["interrupted"] = interrupted;
  if (!against.is_null()) json["against"] = against;
  return json;
}

namespace {

using nlohmann::ordered_json;

constexpr std::size_t most_worst = 8, most_keys = 8, fewest_trials = 50;

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

/// Success in equal cells of the values that seeds drew: which values succeed?
ordered_json success_cells(const std::vector<std::pair<double, bool>>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double from = low->first, to = high->first;
  const int cells = std::clamp(static_cast<int>(values.size() / 25), 2, 12);
  std::vector<long> reached(static_cast<std::size_t>(cells)), all(static_cast<std::size_t>(cells));
  for (const auto& [value, good] : values) {
    const double place = to > from ? (value - from) / (to - from) * cells : 0;
    const auto cell = static_cast<std::size_t>(std::clamp(static_cast<int>(place), 0, cells - 1));
    ++all[cell];
    reached[cell] += good ? 1 : 0;
  }
  ordered_json list = ordered_json::array();
  for (std::size_t cell = 0; cell < all.size(); ++cell) {
    if (all[cell] == 0) continue;
    const ConfidenceInterval ci = clopper_pearson_ci95(reached[cell], all[cell]);
    list.push_back({{"value", from + (static_cast<double>(cell) + 0.5) * (to - from) / cells},
                    {"trials", all[cell]},
                    {"reached", reached[cell]},
                    {"low", ci.low},
                    {"high", ci.high}});
  }
  return list;
}

ordered_json success_by_key(const std::vector<Trial>& trials) {
  std::map<std::string, std::vector<std::pair<double, bool>>> by_key;
  for (const Trial& trial : trials) {
    if (!trial.feasible) continue;
    for (const auto& [key, value] : trial.drawn) {
      if (std::isfinite(value)) by_key[key].emplace_back(value, trial.reached());
    }
  }
  ordered_json list = ordered_json::array();
  for (const auto& [key, values] : by_key) {
    if (values.size() >= fewest_trials && list.size() < most_keys)
      list.push_back({{"key", key}, {"cells", success_cells(values)}});
  }
  return list;
}

}  // namespace

std::string trial_command(const nlohmann::json& description, std::uint64_t seed) {
  return servo_command(description.at(WorkJob::places_key).at("scenario_file").get<std::string>(),
                       fmt::format("seed_{}", seed), seed, description.at("perception").get<std::string>(),
                       description.at("sets").get<std::vector<std::string>>()) +
         " --video";
}

nlohmann::ordered_json sweep_report(const Sweep& sweep, const std::optional<Sweep>& other) {
  const nlohmann::json& job = sweep.description;
  const Footprint& body = pioneer_3dx_footprint;
  ordered_json report{
      {"page", "sweep"},
      {"title", std::filesystem::path(job.at(WorkJob::places_key).at("scenario_file").get<std::string>())
                    .stem()
                    .string()},
      {"gain_warning", job.value("gain_warning", "")},
      {"distance_m", job.value("distance_m", 0.0)},
      {"footprint_m",
       {{"front_m", body.front_m}, {"rear_m", body.rear_m}, {"half_width_m", body.half_width_m}}},
      {"success_by", success_by_key(sweep.trials)},
      {"worst", ordered_json::array()}};
  for (const Trial* trial : worst_trials(sweep.trials))
    report["worst"].push_back({{"seed", trial->seed}, {"command", trial_command(job, trial->seed)}});
  if (other)
    report["against"] = {{"law", other->description.value("law", "")},
                         {"perception", other->description.value("perception", "")}};
  report["scenario"] = job.at("scenario");
  return report;
}

}  // namespace ballservo
