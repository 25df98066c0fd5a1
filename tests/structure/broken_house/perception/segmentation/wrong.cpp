// For the tests of structure: every include here is one too many.
#include <ceres/ceres.h>
#include <spdlog/spdlog.h>

#include "app/main.hpp"
#include "calibration/base/allowed.hpp"
#include "relative.hpp"
#include "servo/control/law.hpp"

void print() { std::cout << "libraries do not print\n"; }
