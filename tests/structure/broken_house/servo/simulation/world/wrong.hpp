// For the tests of structure: a simulation that leans on what it tests, in ViSP's types.
#pragma once

#include <visp3/core/vpColVector.h>

#include "perception/detector.hpp"
#include "servo/motion/allowed.hpp"
