// Where an axis has its ticks, and what stands beside them.
#pragma once

#include <string>
#include <vector>

namespace ballservo {

struct Tick {
  double value = 0;
  std::string label;  ///< empty for a minor tick
};

/// About `count` ticks at round numbers (1, 2 or 5 times a power of ten) within [low, high].
std::vector<Tick> linear_ticks(double low, double high, int count);

/// Ticks at powers of ten, and at 2 and 5 between them where there are few; [low, high] above 0.
std::vector<Tick> log_ticks(double low, double high, int count);

/// The range that shows all of the finite values (for `log`: the positive ones), with a little room around
/// them; a sensible range for no value, one value and equal values.
struct AxisRange {
  double low = 0, high = 1;
};
AxisRange range_of(const std::vector<double>& values, bool log);

/// Whether an axis can show the value at all: finite, at most 1e100 in size, and above 1e-100 for `log`.
bool showable(double value, bool log);

}  // namespace ballservo
