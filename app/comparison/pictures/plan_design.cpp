#include "app/comparison/pictures/plan_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

using Varied = PlanDesign::Varied;

std::string known_keys(const ComparisonCondition& base) {
  OptionLister lister;
  ComparisonCondition condition = base;
  declare(lister, condition);
  std::string keys = "one of";
  for (const OptionRow& row : lister.rows()) keys += find_number(base, row.path) ? " " + row.path : "";
  return keys;
}

// `uniform` or `log_uniform` of a random design.
void declare_ends(OptionVisitor& v, const std::string& kind, const NumberRange& range, Varied& varied) {
  const bool log = kind == "log_uniform";
  v.only_if(varied.log == log, kind, [&] {
    std::vector<double>& ends = varied.values;
    v.numbers(kind, ends, range, 2, "drawn between these two", required);
    const bool rising = ends.size() != 2 || (ends[0] < ends[1] && (!log || ends[0] > 0));
    v.require(rising, kind, ends.size() == 2 ? fmt::format("[{:g}, {:g}]", ends[0], ends[1]) : "",
              log ? "two numbers above 0, the smaller one first" : "two numbers, the smaller one first");
  });
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
      conditions.back().name = value_name(varied.key, value);
      conditions.back().swept = varied.key;
      set_number(conditions.back(), varied.key, value);
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
        set_number(finer.back(), varied.key, value);
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
      const double low = varied.values[0], high = varied.values[1];
      set_number(conditions.back(), varied.key,
                 varied.log ? low * std::pow(high / low, part) : low + (high - low) * part);
    }
  }
  return conditions;
}

}  // namespace

void declare(OptionVisitor& v, PlanDesign& design, const ComparisonCondition& base) {
  v.choice("type", design.type, {"one_at_a_time", "grid", "random"}, "how conditions are made", required);
  const bool random = design.type == "random";
  const auto most = static_cast<long long>(most_conditions);
  v.only_if(random, "type: random",
            [&] { v.integer("conditions", design.conditions, 1, most, "how many", required); });
  v.entries("vary", "KEY", [&](const std::string& key) {
    Varied varied{key, {}, false};
    const auto number = find_number(base, key);
    const bool known = v.without_fault([&] { v.require(number.has_value(), key, key, known_keys(base)); });
    if (!known) return;
    const NumberRange range = number ? number->range : NumberRange::any("");
    const bool right = v.without_fault([&] {
      v.only_if(random, "type: random", [&] {
        v.map(key, required, [&] {
          varied.log = v.present("log_uniform", false);
          declare_ends(v, "log_uniform", range, varied);
          declare_ends(v, "uniform", range, varied);
        });
      });
      v.only_if(!random, "type: one_at_a_time, grid", [&] {
        v.numbers(key, varied.values, range, 0, "values of the condition's number KEY", required);
        v.require(!varied.values.empty(), key, "no numbers", "a list of one number or more");
      });
    });
    if (right) design.vary.push_back(std::move(varied));
  });
  v.require(!design.vary.empty(), "vary", "nothing", "at least one number to vary, with its values");
}

std::vector<ComparisonCondition> designed_conditions(const PlanDesign& design, YamlNode node,
                                                     const ComparisonCondition& base, std::uint64_t seed) {
  if (design.type == "random") return at_random(design.vary, base, design.conditions, seed);
  const bool all = design.type == "grid";
  double combinations = all ? 1 : 0;
  for (const Varied& varied : design.vary) {
    const auto values = static_cast<double>(varied.values.size());
    combinations = all ? combinations * values : combinations + values;
  }
  if (combinations > most_conditions) {
    node.fault("vary", fmt::format("{:g} conditions", combinations),
               fmt::format("at most {:g}", most_conditions));
    return {};
  }
  return all ? grid(design.vary, base) : one_at_a_time(design.vary, base);
}

}  // namespace ballservo
