// How good the classes of a colour table are: what they share, what the background has of them, and what
// light they survive.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "calibration/color/color_table.hpp"
#include "calibration/teaching/learn_colors.hpp"

namespace ballservo {

/// How far the light may change before fewer than half of a class's samples are still of the class. Where no
/// change that was tried does that, the last one tried is given.
struct LightTolerance {
  double level_low = 1, level_high = 1;  ///< factors of the light's strength; tried: 1/16 to 16
  double coolest_k = 6500,
         warmest_k = 6500;  ///< of a light that was 6500 K when taught; tried: 1667 to 25000
  double cooler_mired = 0, warmer_mired = 0;  ///< the same as shifts, both 0 or more
};

struct ClassReport {
  double kept_fraction = 0;               ///< of the samples, that the table gives back to the class
  std::map<std::string, double> overlap;  ///< of the samples, that it gives to each other class
  /// The part of this class's colour distribution that lies where the other's does, whatever the table makes
  /// of it: 1 for the same colour (the common area of both, over coarse cells of Lab).
  std::map<std::string, double> shared;
  double background_fraction = 0;  ///< of the pixels off every ball, those of this class
  double chroma = 0;               ///< of the samples: the median of sqrt(a^2 + b^2), Lab
  /// The chroma to which the samples may fade towards grey (haze, glare, blur) before fewer than half are
  /// still of the class.
  double dissolves_at_chroma = 0;
  LightTolerance light;
};

/// One report a class, in order, from what the table stores (see `rebuild`).
std::vector<ClassReport> report_classes(const ColorTable& colors);

/// What is wrong with the classes, in words with figures and what to do.
struct ClassFindings {
  std::vector<std::string> refusals;  ///< no use can be made of the table
  std::vector<std::string> warnings;
};
ClassFindings judge_classes(const ColorTable& colors, const std::vector<ClassReport>& reports);
/// What may be wrong with colours that were learnt, their doubts first. Throws Refusal where no use can be
/// made of their table.
std::vector<std::string> warnings_of(const LearntColors& learnt, const std::vector<ClassReport>& reports);

}  // namespace ballservo
