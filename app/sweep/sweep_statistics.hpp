// What a sweep's trials say together, and what two sweeps over the same seeds say of each other, and
// what the page is drawn from.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "app/sweep/sweep.hpp"

namespace ballservo {

/// What summary.json says of two sweeps, paired by their seeds: how often only one of them reached the ball,
/// paired differences of figures (this sweep's less the other's), `unmatched` seeds of one alone or
/// infeasible in either, and pairs whose seed drew something else in the other. `other_name`: its folder, as
/// the user named it.
nlohmann::ordered_json compare_sweeps(const Sweep& sweep, const Sweep& other, const std::string& other_name);

/// summary.json: the contract's keys first. What is not known is null; so is `against` where there is nothing
/// that the sweep was compared with.
nlohmann::ordered_json sweep_summary_json(const Sweep& sweep, const Shard& shard, bool interrupted,
                                          const nlohmann::ordered_json& against);

/// The contents of report.json: what depends on what a seed draws, and the worst trials with the commands
/// that show them again.
nlohmann::ordered_json sweep_report(const Sweep& sweep, const std::optional<Sweep>& other);

/// The command that runs one seed of a sweep again, with a film: for pasting into a shell.
std::string trial_command(const nlohmann::json& description, std::uint64_t seed);

}  // namespace ballservo
