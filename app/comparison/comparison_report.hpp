// What the page of a comparison is drawn from, beside its tables.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

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

/// Takes a file of the results.
using WriteFile = std::function<void(const std::string& name, std::string_view contents)>;

/// The contents of report.json, what the page is drawn from beside the tables: answers in sentences,
/// certificates, curves. `show` draws examples and the worst frames again, whose pictures go to `write`;
/// empty where the pictures are not at hand, and the page says so. `claims`: the paper's, if they were looked
/// at.
nlohmann::ordered_json comparison_report(const ComparisonResults& results, const ShowFrame& show,
                                         const WriteFile& write, const ComparisonReportText& text,
                                         const std::vector<PaperClaim>& claims);

/// The error table and the table of pairs as LaTeX (booktabs).
std::string comparison_tables_tex(const ComparisonResults& results);

}  // namespace ballservo
