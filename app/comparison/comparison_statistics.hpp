// The figures of a comparison, condition by condition: a frame's record is looked at once and let go.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/comparison/estimators/methods.hpp"
#include "app/comparison/frame_record.hpp"

namespace ballservo {

/// The figures of a row by the names of their columns, in order; not known: NaN. FILES.md has their units and
/// meanings.
using Figures = nlohmann::ordered_json;

/// Two methods that are held against each other frame by frame, over the frames in which both found the ball.
struct MethodPair {
  std::size_t a, b;  ///< places in the list of methods
};
/// The pairs among the methods: one step, more steps and robust fits, each with the converged fit of the same
/// points.
std::vector<MethodPair> converged_pairs(const MethodList& methods);

/// The pairs of which tests.csv tells which one is nearer to the truth on the same frames: what runs on line,
/// and the paper's one step, against each of the others.
std::vector<MethodPair> tested_pairs(const MethodList& methods);

/// All that is kept of a condition.
struct ConditionSummary {
  /// Of compare.csv, by method. Errors are over the frames in which the method found the ball. What it does
  /// not find is in `failed` and in `charged_median_mm`, never dropped.
  std::vector<Figures> methods;
  std::vector<double> times_us;  ///< medians, by method
  std::vector<Figures> pairs;    ///< of pairs.csv, in the order of converged_pairs
  /// Of the same, the distances between the centres (px).
  std::vector<std::vector<double>> centers_apart_px;
  std::vector<Figures> tests;  ///< of tests.csv, in the order of tested_pairs
};

/// Adds up the frames of one condition, of which it keeps a few numbers each.
class ConditionStatistics {
 public:
  /// `seed` draws the bootstrap's samples.
  ConditionStatistics(std::string name, const MethodList& methods, std::uint64_t seed);
  ~ConditionStatistics();

  void add(const ComparisonRecord& frame);
  ConditionSummary summary() const;

 private:
  class Errors;
  class Differences;
  class Duel;
  std::string purpose_of(const MethodPair& pair) const;

  std::string name_;
  MethodList methods_;
  std::uint64_t seed_;
  std::vector<MethodPair> pairs_;
  std::vector<Errors> errors_;
  std::vector<Differences> differences_;
  std::vector<Duel> duels_;
};

}  // namespace ballservo
