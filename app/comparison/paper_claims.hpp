// The paper's claims, one by one, held against what was measured.
#pragma once

#include <string>
#include <vector>

#include "app/comparison/comparison.hpp"
#include "app/comparison/paper_measurements.hpp"

namespace ballservo {

struct PaperClaim {
  std::string says;      ///< the claim
  std::string measured;  ///< here
  std::string verdict;   ///< "holds", "holds if ...", "does not hold", "not measured"
  std::string shown_by;  ///< the plot or table
};

/// The setting of the paper's own figures is the condition `base` (a whole ball of 7 cm, 60 px across at 1
/// m); what is hidden is the sweep of `occlusion`. A claim whose condition the plan lacks is not measured.
std::vector<PaperClaim> paper_claims(const ComparisonResults& results, const PaperMeasurements& measurements);

/// claims.csv: one row a claim; without those of times, which are in the report.
std::string claims_csv(const std::vector<PaperClaim>& claims);

}  // namespace ballservo
