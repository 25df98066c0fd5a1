// A comparison told in plain words: tables, plots, an example of every condition, the worst frames.
#pragma once

#include <string>

#include "app/comparison/comparison.hpp"
#include "app/comparison/paper_claims.hpp"
#include "app/comparison/pictures/comparison_photos.hpp"

namespace ballservo {

/// What a report says beside the figures.
struct ComparisonReportText {
  std::string subject;  ///< "basic.yaml", "pictures/"
  std::string setting;  ///< the plan or the options, as they were read
  bool rendered = true;
  bool claims_wanted = false;  ///< the paper's claims are to be looked at one by one
};

/// report.html of a comparison. `show` draws examples and the worst frames again; empty where the pictures
/// are not at hand, and the page says so. `claims`: the paper's, if they were looked at.
std::string comparison_report_html(const ComparisonResults& results, const ShowFrame& show,
                                   const ComparisonReportText& text, const std::vector<PaperClaim>& claims);

/// The error table and the table of pairs as LaTeX (booktabs).
std::string comparison_tables_tex(const ComparisonResults& results);

}  // namespace ballservo
