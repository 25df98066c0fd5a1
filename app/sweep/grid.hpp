// Sweeps of one scenario with different values of its keys, over the same seeds: a grid, a sweep a cell.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/sweep/sweep.hpp"

namespace ballservo {

/// The cells that `--vary KEY=V1,V2,...` make of a sweep, the last key's values changing fastest. Commas
/// within brackets, braces and quotes belong to a value. Throws InputError with every fault of every cell,
/// each named at its `--vary`.
std::vector<SweepWork> plan_grid(const SweepOptions& options, const std::vector<std::string>& vary);

/// The job that such cells are together.
nlohmann::json grid_description(const std::vector<SweepWork>& cells, const std::vector<std::string>& vary);
bool is_grid(const nlohmann::json& description);
/// The jobs of its cells; of a sweep alone, itself.
std::vector<nlohmann::json> cell_descriptions(const nlohmann::json& description);

/// grid.csv: a cell a row.
std::string grid_csv(const nlohmann::json& description, const std::vector<Sweep>& cells);
/// trials.csv of all cells.
std::string grid_trials_csv(const std::vector<Sweep>& cells);
/// summary.json: a sweep's keys over all cells, then each cell's own with its values.
nlohmann::ordered_json grid_summary_json(const nlohmann::json& description, const std::vector<Sweep>& cells,
                                         const Shard& shard, bool interrupted);
/// What the page says beside the summary.
nlohmann::ordered_json grid_report(const nlohmann::json& description);

}  // namespace ballservo
