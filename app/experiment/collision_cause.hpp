// Why a collision could happen: the first assumption of servo/SAFETY.md that was broken where and when it
// happened.
#pragma once

#include <string>
#include <vector>

#include "app/experiment/run_record.hpp"
#include "app/scenario/scenario.hpp"
#include "servo/simulation/robot/sonar_ring.hpp"

namespace ballservo {

/// What is known of a collision, all of it true.
struct CollisionEvidence {
  std::string touched;               ///< "wall", or the name of an obstacle or a ball
  std::vector<StepRecord> steps;     ///< up to the one in which it was seen
  std::vector<SonarFiring> firings;  ///< up to then
};

/// The assumption's name as in servo/SAFETY.md ("A1_shield" to "A8_creep"), the first in their order that was
/// broken for this collision; "none_broken" where all held:
///   A1  the commands passed no shield
///   A2  what was touched moves
///   A3  it does not cross the sonars' plane, or two firings in a row, within the memory of the grid,
///   looked at the
///       point of contact, heard nothing so near, and no transducer was faulty
///   A4  the same, of a faulty transducer
///   A5  at some time within that memory odometry erred, as to the point of contact, by more than its bound
///   A6  from some time in the last five seconds on the drive did not go as its model foretells
///   A7  the point of contact was nearer to the start than start_clear_m
///   A8  in the last second a command passed by the rule of creeping away
std::string collision_cause(const Scenario& scenario, const CollisionEvidence& evidence);

}  // namespace ballservo
