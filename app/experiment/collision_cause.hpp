// Why a collision could happen: the first assumption of servo/SAFETY.md that the scenario breaks.
#pragma once

#include <string>

#include "app/experiment/scenario.hpp"

namespace ballservo {

/// The assumption's name as in servo/SAFETY.md ("A1_shield" to "A7_start"), the first that is broken for a
/// collision with `touched` ("wall" for walls) at that time; "none_broken" where all hold.
std::string collision_cause(const Scenario& scenario, const std::string& touched, double time_s);

}  // namespace ballservo
