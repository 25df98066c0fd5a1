#include "app/sweep/sweep_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "calibration/base/statistics.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t most_worst = 8, most_keys = 8, fewest_trials = 50;

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
  std::string command = "ballservo servo " +
                        quoted(description.at(WorkJob::places_key).at("scenario_file").get<std::string>()) +
                        fmt::format(" -o seed_{} --seed {} --perception ", seed, seed) +
                        description.at("perception").get<std::string>();
  for (const nlohmann::json& set : description.at("sets"))
    command += " --set " + quoted(set.get<std::string>());
  return command + " --video";
}

nlohmann::ordered_json sweep_report(const Sweep& sweep, const SweepComparison* against) {
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
  if (against != nullptr)
    report["against"] = {{"law", against->other_law}, {"perception", against->other_perception}};
  report["scenario"] = job.at("scenario");
  return report;
}

}  // namespace ballservo
