// For the tests of structure: a fit that asks where its candidates come from and what is made of it.
#pragma once

#include "perception/candidates/region_outline.hpp"
#include "perception/detector.hpp"
#include "perception/judgement/ball_judge.hpp"
