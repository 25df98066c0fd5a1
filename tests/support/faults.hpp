// What is wrong with an input, as tests look at it.
#pragma once

#include <string>
#include <vector>

#include "calibration/base/fault.hpp"

namespace ballservo::test {

/// The faults of the InputError that `call` throws; none where it throws nothing.
template <class Call>
std::vector<Fault> faults_of(const Call& call) {
  FaultList faults;
  faults.collect(call);
  return faults.faults();
}

/// The same as a user sees them, a line each.
template <class Call>
std::string fault_lines(const Call& call) {
  std::string lines;
  for (const Fault& fault : faults_of(call)) lines += to_text(fault) + "\n";
  return lines;
}

}  // namespace ballservo::test
