// The top of a comparison's report: is one step enough, and what of the paper's claims?
#pragma once

#include <vector>

#include "app/comparison/comparison.hpp"
#include "app/comparison/paper_claims.hpp"
#include "app/report/page.hpp"

namespace ballservo {

/// The paper that is compared with, as it is cited.
inline constexpr const char* the_paper =
    "H. Ghazouani, \"Suivi d'objets basé forme et couleur pour la navigation robotique en temps réel\"";

/// Places of the pairs of one step and converged fit in the list of pairs, the exact fit's first.
std::vector<std::size_t> one_step_pairs(const MethodList& methods);

/// In sentences: over all conditions, for each condition that has a name of its own, and along each sweep.
void add_answers(Page& page, const ComparisonResults& results);

/// Claim and verdict; what was measured is folded away.
void add_claims(Page& page, const std::vector<PaperClaim>& claims);

}  // namespace ballservo
