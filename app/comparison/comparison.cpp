#include "app/comparison/comparison.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "app/comparison/comparison_tables.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

constexpr int frames_a_unit = 8;
constexpr std::size_t notable_frames = 8;
constexpr int notable_of_condition = 2;

std::string run_unit(const PictureSource& source, const MethodList& methods, const ComparisonUnit& unit) {
  nlohmann::json records = nlohmann::json::array();
  for (int k = 0; k < unit.frames; ++k)
    records.push_back(json_of(measure(source.picture(unit.condition, unit.first_frame + k), methods)));
  return records.dump();
}

// Keeps the largest values, the largest first, of each condition two at most; of equal ones the earlier.
void keep_notable(std::vector<NotableFrame>& kept, const NotableFrame& frame) {
  if (!std::isfinite(frame.value)) return;
  const auto place =
      std::find_if(kept.begin(), kept.end(), [&](const NotableFrame& k) { return k.value < frame.value; });
  kept.insert(place, frame);
  int of_condition = 0;
  kept.erase(std::remove_if(kept.begin(), kept.end(),
                            [&](const NotableFrame& k) {
                              return k.condition == frame.condition && ++of_condition > notable_of_condition;
                            }),
             kept.end());
  if (kept.size() > notable_frames) kept.pop_back();
}

// What a report shows the worst frames of.
class NotableFrames {
 public:
  explicit NotableFrames(const MethodList& methods) {
    for (const char* name : {"sphere_one_step", "detect_sphere", "paper_one_step"}) {
      if (!subject_) subject_ = place_of(methods, name);
    }
    for (const MethodPair& pair : converged_pairs(methods)) {
      if (methods[pair.a]->name.find("one_step") != std::string::npos) pairs_.push_back(pair);
    }
  }
  void add(NotableFrame frame, ComparisonResults& results) const {
    const FrameTruth& truth = frame.record.truth;
    if (subject_ && truth.outline) {
      const auto& fit = frame.record.fits[*subject_];
      // What is not found errs without bound: it stands first.
      frame.value = NotableFrame::not_found;
      if (fit && at_the_ball(*fit, truth))
        frame.value = truth.p_CB ? 1000 * (fit->p_C - *truth.p_CB).norm()
                                 : (fit->outline.center_px - truth.outline->center_px).norm();
      keep_notable(results.worst, frame);
    }
    frame.value = 0;
    for (const MethodPair& pair : pairs_) {
      const auto &a = frame.record.fits[pair.a], &b = frame.record.fits[pair.b];
      if (a && b && at_the_ball(*a, truth) && at_the_ball(*b, truth))
        frame.value = std::max(frame.value, apart_px(*a, *b));
    }
    if (frame.value > 0) keep_notable(results.most_apart, frame);
  }

 private:
  std::optional<std::size_t> subject_;
  std::vector<MethodPair> pairs_;
};

}  // namespace

std::vector<ComparisonRecord> records_of(const ComparisonUnit& unit, const std::string& text,
                                         const MethodList& methods) {
  std::vector<ComparisonRecord> records;
  try {
    for (const nlohmann::json& json : nlohmann::json::parse(text)) {
      records.push_back(record_from_json(json));
      if (records.back().fits.size() != methods.size()) throw std::out_of_range("methods");
    }
    if (records.size() != static_cast<std::size_t>(unit.frames)) throw std::out_of_range("frames");
  } catch (const std::exception&) {
    throw InputError("the notes of " + unit.key, "damaged records", "the folder as the run left it");
  }
  return records;
}

std::string settings_key(const ConditionInfo& info) { return "settings:" + info.name; }

std::vector<ComparisonUnit> comparison_units(const std::vector<ConditionInfo>& conditions,
                                             const Shard& shard) {
  std::vector<ComparisonUnit> units;
  std::size_t item = 0;
  for (std::size_t c = 0; c < conditions.size(); ++c) {
    for (int first = 0; first < conditions[c].frames; first += frames_a_unit, ++item) {
      if (!shard.holds(item)) continue;
      units.push_back({c, first, std::min(frames_a_unit, conditions[c].frames - first),
                       conditions[c].name + "/" + std::to_string(first)});
    }
  }
  return units;
}

void run_units(PictureSource& source, const MethodList& methods, const std::vector<ComparisonUnit>& units,
               Journal& journal, int threads, const std::function<void(long done)>& progress) {
  std::vector<const ComparisonUnit*> open;
  std::vector<char> needed(source.conditions().size(), 0);
  long done = 0;
  for (const ComparisonUnit& unit : units) {
    if (journal.has(unit.key)) {
      done += unit.frames;
    } else {
      open.push_back(&unit);
      needed[unit.condition] = 1;
    }
  }
  progress(done);
  std::mutex progress_mutex;
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    source.prepare(needed);
    for (std::size_t c = 0; c < needed.size(); ++c) {
      const std::string key = settings_key(source.conditions()[c]);
      if (needed[c]) journal.add(key, source.peer_words(c));
    }
    tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t k) {
      const std::string records = run_unit(source, methods, *open[k]);
      // Where another thread has thrown, the loops that draw pictures end early too.
      if (tbb::is_current_task_group_canceling()) return;
      journal.add(open[k]->key, records);
      const std::lock_guard<std::mutex> lock(progress_mutex);
      progress(done += open[k]->frames);
    });
  });
}

ComparisonResults collect_results(const std::vector<ConditionInfo>& conditions, const MethodList& methods,
                                  const std::vector<ComparisonUnit>& units, const Journal& journal,
                                  std::uint64_t seed, const RowSink& rows) {
  ComparisonResults results;
  results.methods = methods;
  results.conditions = conditions;
  const auto write = [&](const RowsByFile& pieces) {
    for (const auto& [name, piece] : pieces) rows(name, piece);
  };
  write(comparison_headings());
  const NotableFrames notable(methods);
  CertificateStudy study(methods);
  std::size_t next = 0;
  for (std::size_t c = 0; c < results.conditions.size(); ++c) {
    const ConditionInfo& info = results.conditions[c];
    ConditionStatistics statistics(info.name, methods, seed);
    for (; next < units.size() && units[next].condition == c; ++next) {
      const ComparisonUnit& unit = units[next];
      const std::optional<std::string> text = journal.find(unit.key);
      if (!text) continue;
      int index = unit.first_frame;
      for (ComparisonRecord& record : records_of(unit, *text, methods)) {
        write(frame_rows(info, record, methods));
        study.add(c, record);
        statistics.add(record);
        notable.add({c, index++, 0, std::move(record)}, results);
      }
    }
    results.peer_words.push_back(journal.find(settings_key(info)).value_or(""));
    ConditionSummary summary = statistics.summary();
    write(condition_rows(info, summary, methods));
    results.summaries.push_back(std::move(summary));
  }
  results.certificates = study.certificates();
  rows("certificate.csv", certificate_csv(results.certificates));
  return results;
}

}  // namespace ballservo
