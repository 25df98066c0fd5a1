// ballservo compare: every estimator on the same pixels, against exact truth and against each other.
#include <spdlog/spdlog.h>

#include <opencv2/core/utility.hpp>
#include <thread>

#include "app/commands/command.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "app/io/work_folder.hpp"
#include "app/offline/comparison.hpp"
#include "app/offline/comparison_report.hpp"
#include "app/offline/plan_pictures.hpp"
#include "calibration/files/checksum.hpp"
#include "calibration/files/fault.hpp"

namespace ballservo {
namespace {

// A journal is held in memory, and so are the tables made of it.
constexpr double most_bytes_a_run = 8e8;
constexpr double most_core_hours = 24, most_disk_bytes = 10e9;

// A shard's records, for `compare merge`; times in them differ between runs.
constexpr const char* records_name = "records.jsonl";

struct CompareOptions {
  CommonOptions common;
  std::filesystem::path plan, output;
  std::string shard = "1/1";
  bool resume = false;
};

int threads_of(const CommonOptions& common) {
  return common.threads > 0 ? common.threads
                            : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

void check_size(const ComparisonPlan& plan, const Shard& shard, const CompareOptions& options) {
  const PlanEstimate whole = estimate(plan);
  const std::string words = in_words(whole, threads_of(options.common));
  spdlog::info("compare: {}", words);
  FaultList faults;
  if ((whole.core_hours > most_core_hours || whole.disk_bytes > most_disk_bytes) && !options.common.force) {
    faults.add(
        options.plan.string(), words,
        "fewer frames or conditions, or --force where so much is meant (then better in parts: --shard)");
  }
  if (whole.disk_bytes / shard.count > most_bytes_a_run) {
    faults.add("--shard", shard.to_text() + " of " + words,
               "parts of at most 800 MB each: --shard 1/" +
                   std::to_string(static_cast<long>(whole.disk_bytes / most_bytes_a_run) + 1) + " and so on");
  }
  faults.throw_if_any();
}

// All that the results depend on.
nlohmann::json job_description(const ComparisonPlan& plan) {
  nlohmann::json cameras = nlohmann::json::array();
  for (const ComparisonCondition& condition : plan.conditions) {
    const CameraParameters& p = condition.camera.parameters();
    const Eigen::VectorXd vector = parameter_vector(p);
    nlohmann::json camera = {{"model", lens_model_name(p.model)},
                             {"size", {p.size.width_px, p.size.height_px}},
                             {"parameters", std::vector<double>(vector.begin(), vector.end())}};
    if (condition.covariance) {
      const Eigen::MatrixXd& covariance = condition.covariance->covariance;
      camera["covariance"] = std::vector<double>(covariance.data(), covariance.data() + covariance.size());
    }
    if (cameras.empty() || cameras.back() != camera) cameras.push_back(camera);
  }
  return {{"command", "compare"},
          {"version", BALLSERVO_VERSION},
          {"seed", plan.seed},
          {"plan", nlohmann::json::parse(plan.resolved_json)},
          {"cameras_sha256", sha256_hex(cameras.dump())}};
}

nlohmann::json pair_results(const PairStatistics& s) {
  return {{"frames", s.frames},
          {"center_median_px", s.center_median_px},
          {"center_max_px", s.center_max_px},
          {"radius_median_px", s.radius_median_px},
          {"radius_max_px", s.radius_max_px},
          {"position_median_mm", s.position_median_mm},
          {"position_max_mm", s.position_max_mm}};
}

// Each method's figures and each pair's by condition, and the certificates.
nlohmann::json results_json(const ComparisonResults& results) {
  nlohmann::json conditions = nlohmann::json::object(), pairs = nlohmann::json::array(),
                 certificates = nlohmann::json::array();
  const std::vector<MethodPair> all_pairs = converged_pairs(results.methods);
  for (std::size_t c = 0; c < results.summaries.size(); ++c) {
    const ConditionSummary& summary = results.summaries[c];
    const std::string& name = results.conditions[c].name;
    for (std::size_t m = 0; m < results.methods.size(); ++m) {
      const MethodStatistics& s = summary.methods[m];
      conditions[name][results.methods[m]->name] = {
          {"frames", s.frames},
          {"found", s.found},
          {"found_ci95", {s.found_ci95.low, s.found_ci95.high}},
          {"center_rms_px", s.center_rms_px},
          {"radius_bias_px", s.radius_bias_px},
          {"position_median_mm", s.position_median_mm},
          {"position_median_ci95_mm", {s.position_median_ci95_mm.low, s.position_median_ci95_mm.high}},
          {"position_p90_mm", s.position_p90_mm},
          {"rms_over_bound", s.rms_over_bound}};
    }
    for (std::size_t k = 0; k < all_pairs.size(); ++k) {
      nlohmann::json entry = pair_results(summary.pairs[k]);
      entry["condition"] = name;
      entry["method_a"] = results.methods[all_pairs[k].a]->name;
      entry["method_b"] = results.methods[all_pairs[k].b]->name;
      pairs.push_back(entry);
    }
  }
  for (const Certificate& c : results.certificates) {
    for (const CertificateRule& rule : c.rules) {
      certificates.push_back({{"one_step", c.one_step},
                              {"rule", rule.name},
                              {"words", rule.words},
                              {"tested_frames", rule.tested.frames},
                              {"breaks", rule.tested.breaks},
                              {"caught_rate", rule.tested.caught_rate()},
                              {"false_alarm_rate", rule.tested.false_alarm_rate()},
                              {"roc_area", rule.tested.area}});
    }
  }
  return {{"conditions", conditions}, {"pairs", pairs}, {"certificates", certificates}};
}

int run_compare(const CompareOptions& options) {
  FaultList faults;
  ComparisonPlan plan;
  Shard shard;
  faults.collect([&] { plan = read_comparison_plan(options.plan); });
  faults.collect([&] { shard = parse_shard(options.shard); });
  faults.throw_if_any();
  plan.seed += options.common.seed;
  check_size(plan, shard, options);
  WorkFolder folder(options.output, {job_description(plan), shard}, options.resume,
                    options.common.overwrite());
  if (folder.already_finished()) {
    spdlog::info("compare: {} is finished already", options.output.string());
    return exit_done;
  }
  cv::setNumThreads(1);  // the work is shared out by frames

  PlanPictures source(plan);
  const std::vector<ComparisonUnit> units = comparison_units(source.conditions(), shard);
  long frames = 0;
  for (const ComparisonUnit& unit : units) frames += unit.frames;
  WorkJournal& journal = folder.journal();
  const UnitNotes notes{[&](const std::string& key) { return journal.find(key); },
                        [&](const std::string& key, const std::string& value) { journal.add(key, value); }};
  {
    Progress progress("compare", frames, options.common.quiet);
    run_units(source, plan.methods, units, notes, options.common.threads, [&](long done) {
      throw_if_interrupted();
      progress.step(done);
    });
  }
  const ComparisonResults results =
      collect_results(source.conditions(), plan.methods, units, notes, plan.seed);
  std::map<std::string, std::string> untracked = results.timing_files;
  untracked["report.html"] =
      comparison_report_html(results, source, {options.plan.filename().string(), plan.resolved_json, true});
  std::map<std::string, std::string> files = results.files;
  files["tables.tex"] = comparison_tables_tex(results);
  folder.write_results(files, true, untracked);
  write_json_results(options.common, results_json(results));
  return exit_done;
}

}  // namespace

void add_compare_command(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand("compare", "Run every estimator on the same rendered pictures");
  command->footer(
      "Example: ballservo compare data/comparisons/basic.yaml -o comparison\n"
      "writes compare.csv, fits.csv, frames.csv, pairs.csv, tests.csv, certificate.csv, timing.csv, "
      "tables.tex and "
      "report.html into the folder.\n"
      "--seed is added to the plan's own seed.");
  auto options = std::make_shared<CompareOptions>();
  add_common_options(*command, options->common);
  command->add_option("plan", options->plan, "what to render and run (YAML)")->required();
  command->add_option("-o,--output", options->output, "folder for the results")->required();
  command->add_option("--shard", options->shard, "do part I of N only (default 1/1); see compare merge")
      ->type_name("I/N");
  command->add_flag("--resume", options->resume, "go on where a run of the same plan was ended");
  command->callback([&action, options] { action = [options] { return run_compare(*options); }; });
}

}  // namespace ballservo
