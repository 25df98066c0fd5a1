// report.html of a sweep.
#pragma once

#include <string>

#include "app/sweep/sweep_statistics.hpp"

namespace ballservo {

/// One page, loading nothing from the network: how many reached and why the others did not, all ways from
/// above, distributions, what depends on what a seed draws, the worst trials with the commands that show
/// them, and where given the comparison with another sweep.
std::string sweep_report_html(const Sweep& sweep, const Shard& shard, bool interrupted,
                              const SweepComparison* against);

/// The command that runs one seed of a sweep again, with a film: for pasting into a shell.
std::string trial_command(const nlohmann::json& description, std::uint64_t seed);

}  // namespace ballservo
