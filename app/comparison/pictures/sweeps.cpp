#include "app/comparison/pictures/sweeps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace ballservo {

std::vector<Sweep> sweeps_of(const ComparisonResults& results) {
  std::vector<Sweep> sweeps;
  for (std::size_t c = 0; c < results.conditions.size(); ++c) {
    const ConditionInfo& info = results.conditions[c];
    if (info.swept_key.empty()) continue;
    auto sweep =
        std::find_if(sweeps.begin(), sweeps.end(), [&](const Sweep& s) { return s.key == info.swept_key; });
    if (sweep == sweeps.end())
      sweep = sweeps.insert(sweeps.end(), {info.swept_key, info.swept_label, info.swept_log, {}});
    sweep->conditions.push_back(c);
  }
  sweeps.erase(
      std::remove_if(sweeps.begin(), sweeps.end(), [](const Sweep& s) { return s.conditions.size() < 2; }),
      sweeps.end());
  for (Sweep& sweep : sweeps) {
    std::sort(sweep.conditions.begin(), sweep.conditions.end(), [&](std::size_t a, std::size_t b) {
      return results.conditions[a].swept_value < results.conditions[b].swept_value;
    });
    const double first = results.conditions[sweep.conditions.front()].swept_value;
    sweep.log = sweep.log && first > 0;
  }
  return sweeps;
}

std::string in_words(const ComparisonResults& results, const std::vector<std::size_t>& conditions) {
  std::string words, last_key;
  for (const std::size_t c : conditions) {
    const ConditionInfo& info = results.conditions[c];
    const bool same_sweep = !info.swept_key.empty() && info.swept_key == last_key;
    if (!words.empty()) words += same_sweep ? ", " : "; ";
    if (info.swept_key.empty()) {
      words += info.name;
    } else {
      words += (same_sweep ? "" : info.swept_label + ": ") + fmt::format("{:g}", info.swept_value);
    }
    last_key = info.swept_key;
  }
  return words;
}

std::vector<std::size_t> repeated_setting(const ComparisonResults& results) {
  std::map<std::string, std::vector<std::size_t>> by_setting;
  for (std::size_t c = 0; c < results.conditions.size(); ++c)
    by_setting[results.conditions[c].words].push_back(c);
  std::vector<std::size_t> most;
  for (const auto& [words, conditions] : by_setting) {
    if (conditions.size() > std::max<std::size_t>(1, most.size())) most = conditions;
  }
  return most;
}

}  // namespace ballservo
