// ballservo compare: every estimator on the same pixels, against exact truth and against each other.
#include "app/commands/command.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "app/offline/comparison.hpp"
#include "app/offline/comparison_report.hpp"
#include "app/offline/comparison_statistics.hpp"

namespace ballservo {
namespace {

struct CompareOptions {
  CommonOptions common;
  std::filesystem::path plan, output;
};

nlohmann::json pair_results(const PairStatistics& s) {
  return {{"frames", s.frames},
          {"center_median_px", s.center_median_px},
          {"center_max_px", s.center_max_px},
          {"radius_median_px", s.radius_median_px},
          {"radius_max_px", s.radius_max_px},
          {"position_median_mm", s.position_median_mm},
          {"position_max_mm", s.position_max_mm}};
}

// The verdict over all conditions together, and each method's figures by condition.
nlohmann::json results_of(const Comparison& comparison) {
  nlohmann::json pairs = nlohmann::json::array(), conditions = nlohmann::json::object();
  for (const MethodPair& pair : one_step_pairs(comparison.methods)) {
    PairDifferences all;
    for (const ConditionResult& condition : comparison.conditions)
      all.add(pair_differences(comparison, condition, pair));
    nlohmann::json entry = pair_results(all.statistics());
    entry["method_a"] = fit_method_name(pair.a);
    entry["method_b"] = fit_method_name(pair.b);
    pairs.push_back(entry);
  }
  for (const ConditionResult& condition : comparison.conditions) {
    for (std::size_t m = 0; m < comparison.methods.size(); ++m) {
      const MethodStatistics s = method_statistics(condition, m);
      conditions[condition.name][std::string(fit_method_name(comparison.methods[m]))] = {
          {"frames", s.frames},
          {"found", s.found},
          {"center_rms_px", s.center_rms_px},
          {"radius_bias_px", s.radius_bias_px},
          {"position_median_mm", s.position_median_mm},
          {"position_p90_mm", s.position_p90_mm}};
    }
  }
  return {{"pairs", pairs}, {"conditions", conditions}};
}

int run_compare(const CompareOptions& options) {
  ComparisonPlan plan = read_comparison_plan(options.plan);
  plan.seed += options.common.seed;
  OutputFolder folder(options.output, options.common.overwrite());

  long frames = 0;
  for (const ComparisonCondition& condition : plan.conditions) frames += condition.frames;
  Progress progress("compare", frames, options.common.quiet);
  const Comparison comparison = run_comparison(plan, options.common.threads, [&](long done) {
    throw_if_interrupted();
    progress.step(done);
  });

  folder.write("compare.csv", compare_csv(comparison));
  folder.write("fits.csv", fits_csv(comparison));
  folder.write("pairs.csv", pairs_csv(comparison));
  folder.write("timing.csv", timing_csv(comparison));
  folder.write("report.html", comparison_report_html(comparison, plan, options.plan.filename().string()));
  folder.commit();
  write_json_results(options.common, results_of(comparison));
  return exit_done;
}

}  // namespace

void add_compare_command(CLI::App& program, Action& action) {
  CLI::App* command = program.add_subcommand("compare", "Run every estimator on the same rendered pictures");
  command->footer(
      "Example: ballservo compare data/comparisons/basic.yaml -o comparison\n"
      "writes compare.csv, fits.csv, pairs.csv, timing.csv and report.html into the folder.\n"
      "--seed is added to the plan's own seed.");
  auto options = std::make_shared<CompareOptions>();
  add_common_options(*command, options->common);
  command->add_option("plan", options->plan, "what to render and run (YAML)")->required();
  command->add_option("-o,--output", options->output, "folder for the results")->required();
  command->callback([&action, options] { action = [options] { return run_compare(*options); }; });
}

}  // namespace ballservo
