#include "app/sweep/grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "app/sweep/sweep_statistics.hpp"
#include "calibration/base/csv_table.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/strict_yaml.hpp"

namespace ballservo {
namespace {

constexpr std::size_t most_trials = 1000000;

struct Variation {
  std::string key;
  std::vector<std::string> values;
  std::vector<std::filesystem::path> files;  ///< of a suite's scenarios, whose names are the values
};

constexpr const char* scenario_axis = "scenario";

/// The parts between the commas of a YAML text's top level.
std::vector<std::string> values_in(const std::string& text) {
  std::vector<std::string> values(1);
  int depth = 0;
  char quote = 0;
  for (const char c : text) {
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if (c == ']' || c == '}') {
      --depth;
    } else if (c == ',' && depth == 0) {
      values.emplace_back();
      continue;
    }
    values.back() += c;
  }
  return values;
}

/// The scenarios of a suite, or nothing where the file is a scenario itself.
std::vector<Variation> read_suite(const std::filesystem::path& file) {
  StrictYaml yaml = StrictYaml::from_file(file);
  YamlNode root = yaml.root();
  const std::vector<std::string> keys = root.keys();
  if (std::find(keys.begin(), keys.end(), "scenarios") == keys.end()) return {};
  Variation suite{scenario_axis, {}, {}};
  for (YamlNode& item : root.list("scenarios", true)) {
    const std::filesystem::path scenario = file.parent_path() / item.as_text();
    const std::string name = scenario.stem().string();
    if (!std::filesystem::is_regular_file(scenario))
      yaml.faults().add(item.place(), scenario.string(), "a scenario's file, by its path from the suite");
    else if (std::count(suite.values.begin(), suite.values.end(), name) > 0)
      yaml.faults().add(item.place(), name + " twice", "scenarios of different names");
    suite.values.push_back(name);
    suite.files.push_back(scenario);
  }
  if (suite.values.empty() && yaml.faults().empty())
    root.fault("scenarios", "an empty list", "scenarios' files, by their paths from the suite");
  yaml.finish();
  return {suite};
}

/// A suite's scenarios first, then what --vary names.
std::vector<Variation> parse_variations(const std::filesystem::path& scenario,
                                        const std::vector<std::string>& vary,
                                        const std::vector<std::string>& sets) {
  FaultList faults;
  std::vector<Variation> variations = read_suite(scenario);
  std::set<std::string> known;
  for (const std::string& set : sets) known.insert(with_dots(set.substr(0, set.find('='))));
  for (const std::string& text : vary) {
    const std::size_t equals = text.find('=');
    Variation variation{text.substr(0, equals), {}, {}};
    if (equals != std::string::npos) variation.values = values_in(text.substr(equals + 1));
    const auto empty = [](const std::string& value) { return value.find_first_not_of(' ') == value.npos; };
    if (variation.key.empty() || variation.values.empty() ||
        std::any_of(variation.values.begin(), variation.values.end(), empty))
      faults.add("--vary", "'" + text + "'", "KEY=V1,V2,... as in law.gain_per_s=0.5,1,2");
    else if (!known.insert(with_dots(variation.key)).second)
      faults.add("--vary", variation.key + " twice", "each key once, in --set or in --vary");
    variations.push_back(std::move(variation));
  }
  faults.throw_if_any();
  return variations;
}

/// The values of each cell, the last key's changing fastest.
std::vector<std::vector<std::string>> cells_of(const std::vector<Variation>& variations) {
  std::vector<std::vector<std::string>> cells(1);
  for (const Variation& variation : variations) {
    std::vector<std::vector<std::string>> finer;
    for (const auto& cell : cells)
      for (const std::string& value : variation.values) {
        finer.push_back(cell);
        finer.back().push_back(value);
      }
    cells = std::move(finer);
  }
  return cells;
}

/// What is wrong with a value that --vary sets is said there.
Fault at_its_variation(Fault fault, const std::vector<Variation>& variations) {
  const std::string of_set = "--set";
  if (fault.place.compare(0, of_set.size(), of_set) != 0) return fault;
  for (const Variation& variation : variations) {
    const std::size_t at = with_dots(fault.place).find(with_dots(variation.key), of_set.size());
    if (at == of_set.size() + 1 || at == of_set.size() + 2) fault.place = "--vary " + fault.place.substr(at);
  }
  return fault;
}

std::vector<Variation> variations_of(const nlohmann::json& description) {
  std::vector<Variation> variations;
  for (const nlohmann::json& each : description.at("grid"))
    variations.push_back({each.at("key"), each.at("values").get<std::vector<std::string>>(), {}});
  return variations;
}

/// The summary of a cell, against the first one of its scenario, which it shares its worlds with.
nlohmann::ordered_json cell_summary(const std::vector<Variation>& variations, const std::vector<Sweep>& cells,
                                    std::size_t cell, const Shard& shard) {
  const Variation& slowest = variations.front();
  const std::size_t of_one =
      slowest.key == scenario_axis ? cells.size() / slowest.values.size() : cells.size();
  nlohmann::ordered_json against =
      compare_sweeps(cells[cell], cells[cell / of_one * of_one], "the first cell");
  nlohmann::ordered_json summary = sweep_summary_json(cells[cell], shard, false, nullptr);
  summary["pairs_with_first"] = against["success"]["pairs"];
  summary["success_less_first"] = against["success"]["difference"];
  summary["success_less_first_ci95"] = against["success"]["difference_ci95"];
  summary["settled_less_first_s"] = against["median_differences"]["settled_s"]["median"];
  summary["settled_less_first_s_ci95"] = against["median_differences"]["settled_s"]["ci95"];
  return summary;
}

constexpr const char* grid_figures[] = {"trials",
                                        "infeasible",
                                        "reached",
                                        "collisions",
                                        "collisions_inside_assumptions",
                                        "success_rate",
                                        "success_ci95",
                                        "collision_ci95",
                                        "settled_s",
                                        "range_rms_m",
                                        "bearing_rms_rad",
                                        "min_clearance_m",
                                        "out_of_view_s",
                                        "settled_over_time_optimal",
                                        "touched",
                                        "pairs_with_first",
                                        "success_less_first",
                                        "success_less_first_ci95",
                                        "settled_less_first_s",
                                        "settled_less_first_s_ci95"};

/// A summary's figures as columns: NAME; of an interval NAME_low and NAME_high; of quantiles NAME_p50 and so
/// on.
std::vector<std::pair<std::string, std::string>> columns_of(const nlohmann::ordered_json& summary) {
  std::vector<std::pair<std::string, std::string>> columns;
  const auto add = [&](const std::string& name, const nlohmann::ordered_json& value) {
    columns.emplace_back(name, value.is_null()             ? ""
                               : value.is_number_integer() ? csv_cell(value.get<long>())
                                                           : csv_cell(value.get<double>()));
  };
  for (const std::string name : grid_figures) {
    const nlohmann::ordered_json& value = summary.at(name);
    if (value.is_array()) {
      add(name + "_low", value[0]);
      add(name + "_high", value[1]);
    } else if (value.is_object()) {
      for (const auto& [quantile, number] : value.items()) add(name + "_" + quantile, number);
    } else {
      add(name, value);
    }
  }
  return columns;
}

}  // namespace

SweepPlan plan_sweeps(const SweepOptions& options, const std::vector<std::string>& vary) {
  const std::vector<Variation> variations = parse_variations(options.scenario, vary, options.sets);
  if (variations.empty()) {
    const nlohmann::json description = sweep_description(options);
    return {{{options, description, ""}}, description};
  }
  std::size_t trials = static_cast<std::size_t>(options.trials);
  for (const Variation& variation : variations) {
    trials *= variation.values.size();
    if (trials > most_trials)
      throw InputError(vary.empty() ? options.scenario.string() : "--vary",
                       fmt::format("more than {} trials in all", most_trials), "fewer cells or --trials");
  }
  std::vector<SweepWork> cells;
  std::set<std::string> known;                     // the scenarios' hashes
  nlohmann::json drawn = nlohmann::json::array();  // by any of them: trials.csv has a column for each
  std::vector<Fault> faults;
  for (const auto& values : cells_of(variations)) {
    SweepWork work{options, {}, std::to_string(cells.size() + 1) + "/"};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto& [key, all, files] = variations[i];
      if (files.empty())
        work.options.sets.push_back(key + "=" + values[i]);
      else
        work.options.scenario =
            files[static_cast<std::size_t>(std::find(all.begin(), all.end(), values[i]) - all.begin())];
    }
    try {
      work.description = sweep_description(work.options);
    } catch (const InputError& error) {
      for (const Fault& fault : error.faults()) {
        const Fault here = at_its_variation(fault, variations);
        const bool said = std::any_of(faults.begin(), faults.end(),
                                      [&](const Fault& other) { return to_text(other) == to_text(here); });
        if (!said) faults.push_back(here);
      }
      continue;
    }
    if (faults.empty() && !known.insert(work.description.at("scenario_hash")).second)
      faults.push_back({vary.empty() ? options.scenario.string() : "--vary",
                        fmt::format("{}, twice", fmt::join(values, " ")), "values that differ"});
    for (const nlohmann::json& key : work.description["drawn"])
      if (std::find(drawn.begin(), drawn.end(), key) == drawn.end()) drawn.push_back(key);
    cells.push_back(std::move(work));
  }
  if (!faults.empty()) throw InputError(faults);
  nlohmann::json description{
      {"command", "sweep"},
      {"grid", nlohmann::json::array()},
      {WorkJob::places_key, {{"scenario_file", options.scenario.lexically_normal().generic_string()}}}};
  for (const Variation& variation : variations)
    description["grid"].push_back({{"key", variation.key}, {"values", variation.values}});
  for (SweepWork& cell : cells) {
    cell.description["drawn"] = drawn;
    description["cells"].push_back(cell.description);
    description["cells"].back().erase(WorkJob::places_key);
  }
  return {cells, description};
}

bool is_grid(const nlohmann::json& description) { return description.contains("grid"); }

std::vector<nlohmann::json> cell_descriptions(const nlohmann::json& description) {
  if (!is_grid(description)) return {description};
  std::vector<nlohmann::json> cells = description.at("cells").get<std::vector<nlohmann::json>>();
  for (nlohmann::json& cell : cells) cell[WorkJob::places_key] = description.at(WorkJob::places_key);
  return cells;
}

std::string grid_csv(const nlohmann::json& description, const std::vector<Sweep>& cells) {
  const std::vector<Variation> variations = variations_of(description);
  const auto values = cells_of(variations);
  std::string csv;
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    std::vector<std::string> names, row;
    for (std::size_t i = 0; i < variations.size(); ++i) {
      names.push_back(csv_cell("vary." + variations[i].key));
      row.push_back(csv_cell(values[cell][i]));
    }
    names.push_back("scenario_hash");
    row.push_back(csv_cell(cells[cell].description.at("scenario_hash").get<std::string>()));
    for (const auto& [name, figure] : columns_of(cell_summary(variations, cells, cell, {}))) {
      names.push_back(name);
      row.push_back(figure);
    }
    if (cell == 0) csv = fmt::format("{}\n", fmt::join(names, ","));
    csv += fmt::format("{}\n", fmt::join(row, ","));
  }
  return csv;
}

std::string grid_trials_csv(const std::vector<Sweep>& cells) {
  std::string csv = cells.front().trials_csv;
  for (std::size_t cell = 1; cell < cells.size(); ++cell)
    csv += cells[cell].trials_csv.substr(cells[cell].trials_csv.find('\n') + 1);
  return csv;
}

nlohmann::ordered_json grid_summary_json(const nlohmann::json& description, const std::vector<Sweep>& cells,
                                         const Shard& shard, bool interrupted) {
  Sweep all{description, {}, "", ""};
  long planned = 0;
  for (const Sweep& cell : cells) {
    all.trials.insert(all.trials.end(), cell.trials.begin(), cell.trials.end());
    planned += cell.description.at("trials").get<long>();
  }
  nlohmann::ordered_json summary = sweep_summary_json(all, shard, interrupted, nullptr);
  for (const char* of_a_cell : {"scenario_hash", "law"}) summary.erase(of_a_cell);
  summary["trials_planned"] = planned;
  for (const char* common : {"first_seed", "perception"}) summary[common] = cells.front().description[common];
  summary["cells"] = nlohmann::ordered_json::array();
  const std::vector<Variation> variations = variations_of(description);
  const auto values = cells_of(variations);
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    nlohmann::ordered_json own{{"values", nlohmann::ordered_json::object()}};
    for (std::size_t i = 0; i < variations.size(); ++i) own["values"][variations[i].key] = values[cell][i];
    own.update(cell_summary(variations, cells, cell, shard));
    for (const char* of_all : {"shard", "first_seed", "perception", "interrupted"}) own.erase(of_all);
    summary["cells"].push_back(std::move(own));
  }
  return summary;
}

std::string grid_table(const nlohmann::ordered_json& summary) {
  const auto figure = [](const nlohmann::ordered_json& value, const char* format, double scale = 1) {
    return value.is_null() ? "-" : fmt::format(fmt::runtime(format), scale * value.get<double>());
  };
  std::vector<std::vector<std::string>> rows(1);
  for (const auto& [key, value] : summary.at("cells").at(0).at("values").items()) rows[0].push_back(key);
  for (const char* column :
       {"trials", "feasible", "reached", "95 % interval", "collisions", "in assumptions",
        "out of view p50, p95 s", "settled p50, p95 s", "over optimal", "nearest p5 m", "failures"})
    rows[0].push_back(column);
  for (const nlohmann::ordered_json& cell : summary.at("cells")) {
    std::vector<std::string>& row = rows.emplace_back();
    for (const auto& entry : cell.at("values").items()) row.push_back(entry.value().get<std::string>());
    const auto pair = [&](const char* key) {
      return figure(cell.at(key).at("p50"), "{:.1f}") + ", " + figure(cell.at(key).at("p95"), "{:.1f}");
    };
    const long trials = cell.at("trials");
    const auto& interval = cell.at("success_ci95");
    row.insert(row.end(), {std::to_string(trials), std::to_string(trials - cell.at("infeasible").get<long>()),
                           cell.at("reached").dump(),
                           interval[0].is_null() ? "-"
                                                 : figure(interval[0], "{:.1f} to ", 100) +
                                                       figure(interval[1], "{:.1f} %", 100),
                           cell.at("collisions").dump(), cell.at("collisions_inside_assumptions").dump(),
                           pair("out_of_view_s"), pair("settled_s"),
                           figure(cell.at("settled_over_time_optimal").at("p50"), "{:.2f}"),
                           figure(cell.at("min_clearance_m").at("p5"), "{:.2f}"), ""});
    for (const auto& group : cell.at("failures"))
      if (group.at("outcome") != "infeasible")
        row.back() +=
            fmt::format("{}{} {}: {}", row.back().empty() ? "" : "; ", group.at("count").get<long>(),
                        group.at("outcome").get<std::string>(), group.at("cause").get<std::string>());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t column = 0; column < row.size(); ++column) {
      std::size_t width = 0;
      for (const auto& each : rows) width = std::max(width, each[column].size());
      line += fmt::format("{:<{}}  ", row[column], width);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

nlohmann::ordered_json grid_report(const nlohmann::json& description) {
  const std::string scenario = description.at(WorkJob::places_key).at("scenario_file");
  return {{"page", "grid"},
          {"title", std::filesystem::path(scenario).stem().string()},
          {"grid", description.at("grid")},
          {"scenario", description.at("cells").at(0).at("scenario")}};
}

}  // namespace ballservo
