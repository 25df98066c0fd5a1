#include "app/comparison/pictures/plan_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

struct Varied {
  const ConditionFactor* factor = nullptr;
  std::vector<double> values;  // grid and one at a time
  double low = 0, high = 0;    // random
  bool log = false;
};

std::string known_keys() {
  std::string keys = "one of";
  for (const ConditionFactor& factor : condition_factors()) keys += " " + factor.key;
  return keys;
}

std::optional<Varied> read_range(YamlNode node, const ConditionFactor& factor) {
  Varied varied{&factor, {}, 0, 0, node.has("log_uniform")};
  const std::vector<double> ends = node.numbers(varied.log ? "log_uniform" : "uniform", factor.range, 2);
  if (ends.size() != 2) return std::nullopt;
  varied.low = ends[0];
  varied.high = ends[1];
  if (!(varied.low < varied.high) || (varied.log && !(varied.low > 0))) {
    node.fault(
        varied.log ? "log_uniform" : "uniform", fmt::format("[{:g}, {:g}]", ends[0], ends[1]),
        varied.log ? "two numbers above 0, the smaller one first" : "two numbers, the smaller one first");
    return std::nullopt;
  }
  return varied;
}

std::vector<Varied> read_varied(YamlNode design, bool random) {
  std::vector<Varied> all;
  YamlNode vary = design.map("vary");
  if (!vary.is_map()) return all;
  for (const std::string& key : vary.keys()) {
    const ConditionFactor* factor = find_condition_factor(key);
    if (!factor) {
      vary.leave_aside(key);
      vary.fault(key, key, known_keys());
      continue;
    }
    if (random) {
      if (const auto varied = read_range(vary.map(key), *factor)) all.push_back(*varied);
      continue;
    }
    Varied varied{factor, vary.numbers(key, factor->range, 0), 0, 0, false};
    if (varied.values.empty()) {
      vary.fault(key, "no numbers", "a list of one number or more");
    } else {
      all.push_back(std::move(varied));
    }
  }
  if (all.empty()) design.fault("vary", "nothing", "at least one number to vary, with its values");
  return all;
}

// "depth_m_0_5": what a condition's name may consist of.
std::string value_name(const std::string& key, double value) {
  std::string name = fmt::format("{}_{:g}", key, value);
  std::replace(name.begin(), name.end(), '.', '_');
  std::replace(name.begin(), name.end(), '-', 'm');
  name.erase(std::remove(name.begin(), name.end(), '+'), name.end());
  return name;
}

std::vector<ComparisonCondition> one_at_a_time(const std::vector<Varied>& all,
                                               const ComparisonCondition& base) {
  std::vector<ComparisonCondition> conditions;
  for (const Varied& varied : all) {
    for (const double value : varied.values) {
      conditions.push_back(base);
      conditions.back().name = value_name(varied.factor->key, value);
      conditions.back().swept = varied.factor->key;
      varied.factor->set(conditions.back(), value);
    }
  }
  return conditions;
}

std::vector<ComparisonCondition> grid(const std::vector<Varied>& all, const ComparisonCondition& base) {
  std::vector<ComparisonCondition> conditions{base};
  for (const Varied& varied : all) {
    std::vector<ComparisonCondition> finer;
    for (const ComparisonCondition& coarse : conditions) {
      for (const double value : varied.values) {
        finer.push_back(coarse);
        varied.factor->set(finer.back(), value);
      }
    }
    conditions = std::move(finer);
  }
  for (std::size_t k = 0; k < conditions.size(); ++k) conditions[k].name = fmt::format("grid_{:04d}", k + 1);
  return conditions;
}

std::vector<ComparisonCondition> at_random(const std::vector<Varied>& all, const ComparisonCondition& base,
                                           long long count, std::uint64_t seed) {
  std::vector<ComparisonCondition> conditions;
  for (long long k = 0; k < count; ++k) {
    RandomEngine engine = random_stream(seed, "comparison design", static_cast<std::uint64_t>(k));
    conditions.push_back(base);
    conditions.back().name = fmt::format("random_{:04d}", k + 1);
    for (const Varied& varied : all) {
      const double part = uniform01(engine);
      varied.factor->set(conditions.back(), varied.log ? varied.low * std::pow(varied.high / varied.low, part)
                                                       : varied.low + (varied.high - varied.low) * part);
    }
  }
  return conditions;
}

}  // namespace

std::vector<ComparisonCondition> designed_conditions(YamlNode design, const ComparisonCondition& base,
                                                     std::uint64_t seed) {
  const std::string type = design.choice("type", {"one_at_a_time", "grid", "random"});
  const bool random = type == "random";
  const std::vector<Varied> all = read_varied(design, random);
  const long long count =
      random ? design.integer("conditions", 1, static_cast<long long>(most_conditions)) : 0;
  if (random) return at_random(all, base, count, seed);
  double combinations = type == "grid" ? 1 : 0;
  for (const Varied& varied : all) {
    const auto values = static_cast<double>(varied.values.size());
    combinations = type == "grid" ? combinations * values : combinations + values;
  }
  if (combinations > most_conditions) {
    design.fault("vary", fmt::format("{:g} conditions", combinations),
                 fmt::format("at most {:g}", most_conditions));
    return {};
  }
  return type == "grid" ? grid(all, base) : one_at_a_time(all, base);
}

}  // namespace ballservo
