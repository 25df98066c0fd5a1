// A comparison's drawings.
#pragma once

#include <vector>

#include "app/comparison/comparison.hpp"
#include "app/comparison/pictures/sweeps.hpp"
#include "app/report/svg.hpp"

namespace ballservo {

/// Median 3-D error of the headline methods against what is varied, with 95 % intervals, and the bound.
Svg sweep_error_plot(const ComparisonResults& results, const Sweep& sweep);
/// How far one step lies from the converged fit along a sweep: median and largest.
Svg sweep_pair_plot(const ComparisonResults& results, const Sweep& sweep);
/// The 3-D error of every condition that is in no sweep, as bars.
Svg error_bars(const ComparisonResults& results);
/// For a pair of methods: the part of the frames in which they lie at most so far apart, by condition.
Svg difference_plot(const ComparisonResults& results, std::size_t pair);
/// Error of the one against error of the other, a point a condition, with the line where they are equal.
Svg scatter_plot(const ComparisonResults& results, const MethodPair& pair);
/// Depth against sideways error of one condition: bias and two-sigma ellipse of each headline method.
Svg ellipse_plot(const ComparisonResults& results, std::size_t condition);
/// What each method costs against how well it does, over all conditions.
Svg cost_plot(const ComparisonResults& results);
/// The rules of the fits that broke in this many frames or more of those tested.
inline constexpr int fewest_breaks_drawn = 5;
Svg roc_plot(const std::vector<Certificate>& certificates);

}  // namespace ballservo
