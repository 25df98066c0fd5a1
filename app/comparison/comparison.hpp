// Every estimator on the same pixels: runs methods on a source's pictures and adds up what they said.
//
// The work is cut into units of a few frames of one condition. A unit's records are noted in a journal when
// it is done, so that a run can be killed, resumed, and split over machines; the figures are computed from
// the journal, condition by condition, and are the same whoever wrote it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "app/comparison/certificate.hpp"
#include "app/comparison/comparison_statistics.hpp"
#include "app/comparison/pictures/picture_source.hpp"
#include "app/io/journal.hpp"
#include "app/io/work_folder.hpp"

namespace ballservo {

/// A few frames of one condition.
struct ComparisonUnit {
  std::size_t condition = 0;
  int first_frame = 0, frames = 0;
  std::string key;  ///< "base/16"
};

/// All units of the conditions, in order; of a shard its own.
std::vector<ComparisonUnit> comparison_units(const std::vector<ConditionInfo>& conditions,
                                             const Shard& shard = {});

/// What is noted of a unit; InputError for what no run with these methods notes.
std::vector<ComparisonRecord> records_of(const ComparisonUnit& unit, const std::string& text,
                                         const MethodList& methods);

/// Runs what is not noted yet on `threads` threads (0: as many as the machine has); what is noted is the same
/// at any number, times apart. `progress` is told how many frames are done (those noted before included),
/// from one thread at a time, and ends the work by throwing. Throws as PictureSource::prepare does.
void run_units(PictureSource& source, const MethodList& methods, const std::vector<ComparisonUnit>& units,
               Journal& journal, int threads, const std::function<void(long done)>& progress);

/// A frame worth looking at.
struct NotableFrame {
  static constexpr double not_found = 1e9;  ///< the value where the ball was not found
  std::size_t condition = 0;
  int index = 0;  ///< of the frame within its condition
  double value = 0;
  ComparisonRecord record;
};

/// All that a comparison found.
struct ComparisonResults {
  MethodList methods;
  std::vector<ConditionInfo> conditions;
  std::vector<std::string> peer_words;  ///< by condition
  std::vector<ConditionSummary> summaries;
  std::vector<Certificate> certificates;
  std::vector<NotableFrame> worst;  ///< where what runs on line errs most, or else the first method that fits
  std::vector<NotableFrame> most_apart;  ///< where one step is furthest from the converged fit
};

/// Takes the next rows of a CSV file.
using RowSink = std::function<void(const std::string& name, std::string_view rows)>;

/// Adds up what is noted of the units, one at a time. Units that are missing are left out (a shard); damaged
/// ones throw InputError.
ComparisonResults collect_results(const std::vector<ConditionInfo>& conditions, const MethodList& methods,
                                  const std::vector<ComparisonUnit>& units, const Journal& journal,
                                  std::uint64_t seed, const RowSink& rows);

/// The key under which the peers' settings of a condition are noted; no unit's key has a colon.
std::string settings_key(const ConditionInfo& info);

}  // namespace ballservo
