#include "calibration/teaching/class_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "calibration/base/fault.hpp"
#include "calibration/color/color_space.hpp"
#include "calibration/teaching/class_table.hpp"
#include "calibration/teaching/color_samples.hpp"
#include "calibration/teaching/light_change.hpp"

namespace ballservo {
namespace {

constexpr double same_color_share = 0.6, warned_share = 0.2;
constexpr double hardly_kept = 0.3, badly_kept = 0.7;
constexpr double mostly_background = 0.3, much_background = 0.05;

/// A cell of samples: linear sRGB, Lab, and how many.
struct Sample {
  Eigen::Vector3d linear_rgb, lab;
  double count;
};

std::vector<Sample> samples_of(const OccupiedCells& cells) {
  std::vector<Sample> result;
  for (const CellCount& cell : cells) {
    const auto byte = [&](int c) { return static_cast<std::uint8_t>(4 * (cell.cell >> (6 * c) & 63) + 2); };
    const auto linear = [&](int c) { return linear_from_srgb(byte(c) / 255.0); };
    result.push_back({{linear(2), linear(1), linear(0)},
                      lab_from_bgr(byte(0), byte(1), byte(2)),
                      static_cast<double>(cell.count)});
  }
  return result;
}

ClassIndex class_of(const ColorTable& colors, const Eigen::Vector3d& linear_rgb) {
  const auto byte = [](double linear) {
    return static_cast<std::uint8_t>(std::lround(255 * srgb_from_linear(std::clamp(linear, 0.0, 1.0))));
  };
  return colors.classify(byte(linear_rgb.z()), byte(linear_rgb.y()), byte(linear_rgb.x()));
}

/// Of the changes 1 to `most` (`change(i)`: linear sRGB to linear sRGB), one after the other, how many leave
/// at least half of the samples in the class.
template <class Change>
int survived(const ColorTable& colors, ClassIndex index, const std::vector<Sample>& samples, int most,
             const Change& change) {
  for (int i = 1; i <= most; ++i) {
    const Eigen::Matrix3d changed = change(i);
    double all = 0, kept = 0;
    for (const Sample& sample : samples) {
      all += sample.count;
      if (class_of(colors, changed * sample.linear_rgb) == index) kept += sample.count;
    }
    if (kept < 0.5 * all) return i - 1;
  }
  return most;
}

LightTolerance light_tolerance(const ColorTable& colors, ClassIndex index,
                               const std::vector<Sample>& samples) {
  const auto level = [&](double octaves) {
    const auto change = [&](int i) {
      return Eigen::Matrix3d(Eigen::Matrix3d::Identity() * std::exp2(octaves * i));
    };
    return std::exp2(octaves * survived(colors, index, samples, 32, change));
  };
  const double taught_mired = 1e6 / taught_temperature_k;
  const auto shift = [&](double mired, double last_k) {
    const auto change = [&](int i) { return light_change(1e6 / (taught_mired + mired * i)); };
    return survived(colors, index, samples, static_cast<int>((1e6 / last_k - taught_mired) / mired), change);
  };
  constexpr double step_mired = 5;
  const double warmer = step_mired * shift(step_mired, 1667), cooler = step_mired * shift(-step_mired, 25000);
  const double low = level(-1.0 / 8), high = level(1.0 / 8);
  return {low, high, 1e6 / (taught_mired - cooler), 1e6 / (taught_mired + warmer), cooler, warmer};
}

double median_chroma(const std::vector<Sample>& samples) {
  std::vector<std::pair<double, double>> chroma_and_count;
  double all = 0, sum = 0;
  for (const Sample& sample : samples) {
    chroma_and_count.emplace_back(sample.lab.tail<2>().norm(), sample.count);
    all += sample.count;
  }
  std::sort(chroma_and_count.begin(), chroma_and_count.end());
  for (const auto& [chroma, count] : chroma_and_count) {
    sum += count;
    if (sum >= 0.5 * all) return chroma;
  }
  return 0;
}

/// How little of its chroma a class may keep: mixed with grey of its own luminance, as haze and blur do.
double fading_factor(const ColorTable& colors, ClassIndex index, const std::vector<Sample>& samples) {
  constexpr int steps = 50;
  const auto saturation = [](int i) { return 1 - static_cast<double>(i) / steps; };
  const Eigen::Matrix3d luminance = Eigen::Vector3d::Ones() * xyz_from_linear_rgb().row(1);
  return saturation(survived(colors, index, samples, steps, [&](int i) -> Eigen::Matrix3d {
    return saturation(i) * Eigen::Matrix3d::Identity() + (1 - saturation(i)) * luminance;
  }));
}

double share_of(const std::vector<double>& counts, std::size_t index) {
  const double all = std::accumulate(counts.begin(), counts.end(), 0.0);
  return all > 0 ? counts[index] / all : 0;
}

std::string way_out(const std::string& name) {
  return fmt::format(
      "If that was not the ball, point at it: --at {}=CX,CY,R; if it was, take a picture where it stands out",
      name);
}

}  // namespace

std::vector<ClassReport> report_classes(const ColorTable& colors) {
  std::vector<ClassReport> reports(colors.classes.size());
  std::vector<std::vector<float>> densities;
  for (const ColorClass& color : colors.classes) densities.push_back(lab_density(color.cells));
  const std::vector<double> off_ball = pixels_of_classes(colors.background, colors);
  for (std::size_t k = 0; k < reports.size(); ++k) {
    ClassReport& report = reports[k];
    const auto index = static_cast<ClassIndex>(k + 1);
    const std::vector<Sample> samples = samples_of(colors.classes[k].cells);
    const std::vector<double> given = pixels_of_classes(colors.classes[k].cells, colors);
    report.kept_fraction = share_of(given, index);
    for (std::size_t other = 0; other < reports.size(); ++other) {
      if (other == k) continue;
      const std::string& name = colors.classes[other].name;
      report.overlap[name] = share_of(given, other + 1);
      report.shared[name] = common_area(densities[k], densities[other]);
    }
    report.background_fraction = share_of(off_ball, index);
    report.chroma = median_chroma(samples);
    report.dissolves_at_chroma = report.chroma * fading_factor(colors, index, samples);
    report.light = light_tolerance(colors, index, samples);
  }
  return reports;
}

ClassFindings judge_classes(const ColorTable& colors, const std::vector<ClassReport>& reports) {
  ClassFindings findings;
  for (std::size_t k = 0; k < reports.size(); ++k) {
    const ClassReport& report = reports[k];
    const std::string& name = colors.classes[k].name;
    double taken = 0;  // by other classes
    for (std::size_t other = 0; other < reports.size(); ++other) {
      if (other == k) continue;
      const std::string& other_name = colors.classes[other].name;
      const double shared = report.shared.at(other_name), given = report.overlap.at(other_name);
      taken += given;
      if (other > k && shared >= same_color_share) {
        findings.refusals.push_back(
            fmt::format("{} and {} were taught the same colour: {:.0f} % of the one lies where the other "
                        "does. Teach them as one "
                        "class, or from pictures in which they differ",
                        name, other_name, 100 * shared));
      } else if (other > k && shared >= warned_share) {
        findings.warnings.push_back(fmt::format(
            "{} and {} are hard to tell apart: they share {:.0f} % of their colours; pixels go to the "
            "one that has more of them",
            name, other_name, 100 * shared));
      } else if (given >= 0.1 && shared < warned_share) {
        findings.warnings.push_back(fmt::format("{:.0f} % of {} goes to {}", 100 * given, name, other_name));
      }
    }
    if (report.kept_fraction + taken < hardly_kept) {
      findings.refusals.push_back(fmt::format(
          "{} was taught on background, or on things of two colours: the table gives only {:.0f} % of its "
          "pixels back, the rest looks as much like what is off the balls. {}",
          name, 100 * report.kept_fraction, way_out(name)));
    } else if (report.background_fraction > mostly_background) {
      findings.refusals.push_back(
          fmt::format("{} was taught on background: {:.0f} % of the pixels off the balls have its colour. {}",
                      name, 100 * report.background_fraction, way_out(name)));
    } else if (report.background_fraction > much_background) {
      findings.warnings.push_back(
          fmt::format("{:.1f} % of the pixels off the balls have the colour of {}: expect "
                      "regions of it that are no ball",
                      100 * report.background_fraction, name));
    } else if (report.kept_fraction + taken < badly_kept) {
      findings.warnings.push_back(fmt::format(
          "the background takes {:.0f} % of {} away: pictures in other light or before another background "
          "would help (--class {}=IMAGE --add FILE)",
          100 * (1 - report.kept_fraction - taken), name, name));
    }
  }
  return findings;
}

std::vector<std::string> warnings_of(const LearntColors& learnt, const std::vector<ClassReport>& reports) {
  const ClassFindings findings = judge_classes(learnt.table, reports);
  if (!findings.refusals.empty()) throw Refusal(fmt::format("{}", fmt::join(findings.refusals, "\n")));
  std::vector<std::string> warnings = learnt.doubts;
  warnings.insert(warnings.end(), findings.warnings.begin(), findings.warnings.end());
  return warnings;
}

}  // namespace ballservo
