// What reports say of how sure a figure is.
#pragma once

namespace ballservo {

/// A 95 % confidence interval: it holds the true value in 95 of 100 such experiments. NaN where nothing is
/// known.
struct Interval {
  double low, high;
};

}  // namespace ballservo
