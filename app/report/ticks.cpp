#include "app/report/ticks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

std::string tick_label(double value, double step, double largest) {
  if (std::abs(value) < 1e-6 * step) return "0";
  if (largest >= 1e6 || step < 1e-5) {
    const int digits = std::clamp(static_cast<int>(std::floor(std::log10(largest / step))) + 2, 1, 15);
    return fmt::format("{:.{}g}", value, digits);
  }
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  return fmt::format("{:.{}f}", value, decimals);
}

}  // namespace

bool showable(double value, bool log) { return std::abs(value) <= 1e100 && (!log || value >= 1e-100); }

std::vector<Tick> linear_ticks(double low, double high, int count) {
  std::vector<Tick> ticks;
  if (!(high > low) || !showable(low, false) || !showable(high, false)) return ticks;
  const double rough = (high - low) / std::max(count, 1);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough * 0.999) {
      step = factor * power;
      break;
    }
  }
  const double largest = std::max(std::abs(low), std::abs(high));
  const double first = std::ceil(low / step - 1e-9);
  for (int k = 0; k <= 4 * count + 4; ++k) {
    const double value = (first + k) * step;
    if (value > high + 1e-9 * step) break;
    ticks.push_back({value, tick_label(value, step, largest)});
  }
  return ticks;
}

std::vector<Tick> log_ticks(double low, double high, int count) {
  std::vector<Tick> ticks;
  if (!(high > low) || !showable(low, true) || !showable(high, true)) return ticks;
  const int first = static_cast<int>(std::floor(std::log10(low))),
            last = static_cast<int>(std::ceil(std::log10(high)));
  const int stride = std::max(1, (last - first) / std::max(count, 1));
  const bool between = high < 100 * low;
  for (int decade = first; decade <= last; ++decade) {
    for (int digit = 1; digit <= 9; ++digit) {
      const double value = digit * std::pow(10.0, decade);
      if (value < low * (1 - 1e-9) || value > high * (1 + 1e-9)) continue;
      const bool labelled =
          digit == 1 ? (decade - first) % stride == 0 : between && (digit == 2 || digit == 5);
      if (labelled) {
        ticks.push_back({value, fmt::format("{:g}", value)});
      } else if (last - first <= 6) {
        ticks.push_back({value, ""});
      }
    }
  }
  return ticks;
}

AxisRange range_of(const std::vector<double>& values, bool log) {
  bool any = false;
  double low = 0, high = 0;
  for (const double value : values) {
    if (!showable(value, log)) continue;
    low = any ? std::min(low, value) : value;
    high = any ? std::max(high, value) : value;
    any = true;
  }
  if (!any) return log ? AxisRange{0.1, 10} : AxisRange{0, 1};
  if (log) {
    const double room = high > low * (1 + 1e-9) ? std::pow(high / low, 0.05) : 2;
    return {low / room, high * room};
  }
  const double size = std::max(std::abs(low), std::abs(high));
  if (high - low <= 1e-12 * size || high == low) {
    const double room = size > 0 ? 0.1 * size : 1;
    return {low - room, high + room};
  }
  const double room = 0.05 * (high - low);
  return {low - room, high + room};
}

}  // namespace ballservo
