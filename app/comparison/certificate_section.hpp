// What a comparison's report says of the certificate.
#pragma once

#include "app/comparison/comparison.hpp"
#include "app/report/page.hpp"

namespace ballservo {

/// How well each rule tells breaks, and what one more step where it asks for it does. Nothing where no
/// condition was left to test on.
void add_certificates(Page& page, const ComparisonResults& results);

}  // namespace ballservo
