// The laws that ballservo brings.
#pragma once

#include "servo/control/law_catalog.hpp"

namespace ballservo {

/// "cone" (the default), "visp", "sphere" and "pose", in this order.
LawCatalog builtin_laws();

}  // namespace ballservo
