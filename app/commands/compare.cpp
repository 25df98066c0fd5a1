// ballservo compare: every estimator on the same pixels, against exact truth and against each other.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <map>
#include <opencv2/core/utility.hpp>
#include <set>

#include "app/commands/command.hpp"
#include "app/commands/work_options.hpp"
#include "app/comparison/comparison_archive.hpp"
#include "app/comparison/comparison_report.hpp"
#include "app/comparison/comparison_tables.hpp"
#include "app/comparison/paper_measurements.hpp"
#include "app/comparison/pictures/picture_files.hpp"
#include "app/comparison/pictures/plan_pictures.hpp"
#include "app/io/interrupt.hpp"
#include "app/io/progress.hpp"
#include "app/io/work_folder.hpp"
#include "app/report/draw_pages.hpp"
#include "calibration/base/checksum.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/options.hpp"
#include "calibration/base/system_file.hpp"

namespace ballservo {
namespace {

constexpr double most_core_hours = 24, most_disk_bytes = 10e9;
// A condition's errors are held in memory, about 3 kB a frame with all methods.
constexpr int most_frames_a_condition = 100000;

// What `compare merge` needs of a part: the setting, and the journal, whose times differ between runs.
constexpr const char *setting_name = "comparison.json", *notes_name = "notes.jsonl";
constexpr const char* summary_name = "summary.json";  // what --json writes
constexpr std::size_t max_file_bytes = std::size_t{1} << 28;
constexpr const char* claims_key = "claims:paper";

struct CompareOptions {
  CommonOptions common;
  WorkOptions work;
  std::filesystem::path plan;
  PictureFilesOptions pictures;
  std::string start = "vote";
};

void check_size(const ComparisonPlan& plan, const CompareOptions& options) {
  const PlanEstimate whole = estimate(plan);
  const std::string words = in_words(whole, threads_of(options.common));
  spdlog::info("compare: {}", words);
  FaultList faults;
  if ((whole.core_hours > most_core_hours || whole.disk_bytes > most_disk_bytes) && !options.common.force) {
    faults.add(
        options.plan.string(), words,
        "fewer frames or conditions, or --force where so much is meant (then better in parts: --shard)");
  }
  for (const ComparisonCondition& condition : plan.conditions) {
    if (condition.frames > most_frames_a_condition)
      faults.add(options.plan.string() + ": " + condition.name, std::to_string(condition.frames) + " frames",
                 "at most " + std::to_string(most_frames_a_condition) + " in one condition");
  }
  faults.throw_if_any();
}

// All that the results depend on.
nlohmann::json job_description(const ComparisonPlan& plan) {
  nlohmann::json cameras = nlohmann::json::array();
  for (const ComparisonCondition& condition : plan.conditions) {
    nlohmann::json camera = camera_identity(condition.camera);
    if (condition.covariance) {
      const Eigen::MatrixXd& covariance = *condition.covariance;
      camera["covariance"] = std::vector<double>(covariance.data(), covariance.data() + covariance.size());
    }
    if (cameras.empty() || cameras.back() != camera) cameras.push_back(camera);
  }
  // What a design makes of its keys depends on their order, which the manifest does not keep.
  std::string conditions;
  for (const ComparisonCondition& condition : plan.conditions)
    conditions += condition.name + ": " + in_words(condition) + '\n';
  return {{"command", "compare"},
          {"version", BALLSERVO_VERSION},
          {"seed", plan.seed},
          {"plan", nlohmann::json::parse(plan.resolved_json)},
          {"conditions_sha256", sha256_hex(conditions)},
          {"cameras_sha256", sha256_hex(cameras.dump())}};
}

// Whether a note is of one of the units, of a condition's settings or of the claims.
NoteCheck notes_of(const ComparisonSetting& setting, const Shard& shard) {
  std::map<std::string, ComparisonUnit> units;
  for (ComparisonUnit& unit : comparison_units(setting.conditions, shard)) units.emplace(unit.key, unit);
  std::set<std::string> settings;
  for (const ConditionInfo& info : setting.conditions) settings.insert(settings_key(info));
  return [units, settings, setting](const std::string& key, const std::string& value) {
    if (settings.count(key) > 0) return true;
    if (key == claims_key) return setting.text.claims_wanted && nlohmann::json::accept(value);
    const auto unit = units.find(key);
    try {
      return unit != units.end() && !records_of(unit->second, value, setting.methods).empty();
    } catch (const InputError&) {
      return false;
    }
  };
}

// The answer in words, and where the page lies; what drew the page has written both.
void say_answer(const std::filesystem::path& output, bool quiet) {
  std::error_code error;
  if (!quiet && std::filesystem::exists(output / "answer.txt", error))
    print_result("{}{}\n", read_file_bytes(output / "answer.txt", max_file_bytes),
                 std::filesystem::absolute(output / "report.html").lexically_normal().string());
}

ShowFrame pictures_of(const PictureSource& source) {
  return [&](std::size_t condition, int frame) { return source.picture(condition, frame); };
}

// Adds up what the folder's journal holds and writes the results; a part keeps its journal.
void write_results(const ComparisonSetting& setting, const ShowFrame& show, const Shard& shard,
                   const CommonOptions& common, const std::filesystem::path& output, WorkFolder& folder) {
  const RowSink rows = [&](const std::string& name, std::string_view piece) {
    name == "timing.csv" ? folder.write_varying(name, piece) : folder.write(name, piece);
  };
  const ComparisonResults results =
      collect_results(setting.conditions, setting.methods, comparison_units(setting.conditions, shard),
                      folder.journal(), setting.seed, rows);
  folder.write(setting_name, comparison_setting_text(setting));
  folder.write(summary_name, comparison_json(results).dump(2) + "\n");
  const WriteFile write = [&](const std::string& name, std::string_view bytes) {
    folder.write_varying(name, bytes);
  };
  nlohmann::ordered_json report = comparison_report(results, show, write);
  // Null where the paper's claims were not looked at. That the note is JSON, opening the journal has checked.
  report["paper_measurements"] = nlohmann::json::parse(folder.journal().find(claims_key).value_or("null"));
  write(report_json_name, report_text(report));
  draw_page_or_warn(folder.staging(), output.string(), common.quiet);
  common.files->commit();
  folder.commit_finished(shard.is_whole() ? "" : notes_name);
  say_answer(output, common.quiet);
  write_json_results(common, comparison_json(results));
}

// A run, whatever its pictures are; `plan` where there is one.
int run_job(PictureSource& source, const nlohmann::json& description, ComparisonSetting setting,
            const ComparisonPlan* plan, const CompareOptions& options) {
  const Shard shard = parse_shard(options.work.shard);
  setting.conditions = source.conditions();
  WorkFolder folder(options.work.output, {description, shard}, options.work.resume,
                    options.common.overwrite(options.work.output), notes_of(setting, shard));
  if (folder.already_finished()) {
    spdlog::info("compare: {} is finished already", options.work.output.string());
    say_answer(options.work.output, options.common.quiet);
    if (!options.common.json.empty())
      write_json_results(options.common, nlohmann::json::parse(read_file_bytes(
                                             options.work.output / summary_name, max_file_bytes)));
    return exit_done;
  }
  cv::setNumThreads(1);  // the work is shared out by frames
  const std::vector<ComparisonUnit> units = comparison_units(setting.conditions, shard);
  long frames = 0;
  for (const ComparisonUnit& unit : units) frames += unit.frames;
  Journal& journal = folder.journal();
  try {
    if (setting.text.claims_wanted && shard.index == 1 && !journal.has(claims_key)) {
      spdlog::info("compare: looking at what the paper says of votes, classes and times");
      journal.add(claims_key, measure_paper_claims(*plan).dump());
    }
    Progress progress("frames", frames, options.common.quiet);
    run_units(source, setting.methods, units, journal, options.common.threads, [&](long done) {
      throw_if_interrupted();
      progress.step(done);
    });
  } catch (const Interrupted&) {
    spdlog::warn("compare: interrupted; what was finished is kept in {}: go on with --resume",
                 options.work.output.string());
    throw;
  }
  write_results(setting, pictures_of(source), shard, options.common, options.work.output, folder);
  return exit_done;
}

int compare_plan(const CompareOptions& options) {
  FaultList faults;
  ComparisonPlan plan;
  faults.collect([&] { plan = read_comparison_plan(options.plan); });
  faults.collect([&] { parse_shard(options.work.shard); });
  faults.throw_if_any();
  for (const std::filesystem::path& file : plan.files) options.common.files->reads("a camera", file);
  for (const ComparisonCondition& condition : plan.conditions)
    admit_camera(options.plan, condition.camera.size(), options.common, threads_of(options.common));
  plan.seed += options.common.seed;
  check_size(plan, options);
  PlanPictures source(plan);
  const ComparisonReportText text{options.plan.filename().string(), plan.text, true, plan.paper_claims};
  return run_job(source, job_description(plan), {{}, plan.methods, plan.seed, text}, &plan, options);
}

int compare_pictures(CompareOptions options) {
  FaultList faults;
  if (!options.plan.empty()) faults.add("PLAN", options.plan.string(), "a plan or --images, not both");
  if (options.pictures.truth.empty())
    faults.add("--truth", "nothing",
               "a table of the pictures' balls: source,cx_px,cy_px,r_px,... (cells may be empty)");
  if (options.start != "vote" && options.start != "truth")
    faults.add("--start", options.start, "vote or truth");
  faults.collect([&] { parse_shard(options.work.shard); });
  faults.throw_if_any();
  options.pictures.start_at_truth = options.start == "truth";
  options.pictures.seed = options.common.seed;
  options.pictures.max_pixels = options.common.max_pixels;
  PictureFiles source(options.pictures);
  const bool colored = !options.pictures.colors.empty();
  if (!colored)
    spdlog::warn(
        "without --colors vote, sphere_* and detect_* do not know what is ball and what is not: they are "
        "worse than they would be");
  MethodList methods;
  for (const FitMethod& method : fit_methods()) methods.push_back(&method);
  const nlohmann::json description = {
      {"command", "compare --images"}, {"version", BALLSERVO_VERSION}, {"pictures_sha256", source.sha256()}};
  const std::string setting = "--images " + options.pictures.folder.filename().string() + " --start " +
                              options.start + (colored ? "" : ", no colours") +
                              (options.pictures.camera.empty() ? ", no camera" : ", with a camera") +
                              (options.pictures.diameter_m > 0 ? ", diameter known" : ", diameter not known");
  const ComparisonReportText text{options.pictures.folder.filename().string() + "/", setting, false, false};
  return run_job(source, description, {{}, methods, options.common.seed, text}, nullptr, options);
}

int run_compare(const CompareOptions& options) {
  FaultList faults;
  if (options.work.output.empty()) faults.add("--output", "nothing", "a folder for the results");
  if (options.plan.empty() && options.pictures.folder.empty())
    faults.add("PLAN", "nothing", "a plan (YAML), or --images and --truth");
  faults.throw_if_any();
  return options.pictures.folder.empty() ? compare_plan(options) : compare_pictures(options);
}

// What the parts rendered, so that the worst frames of all can be drawn again; nothing where that was a
// user's own pictures, or a camera's file that lies elsewhere.
std::optional<ComparisonPlan> plan_of(const ComparisonSetting& setting) {
  if (!setting.text.rendered) return std::nullopt;
  try {
    ComparisonPlan plan = parse_comparison_plan(setting.text.setting, setting.text.subject, ".");
    plan.seed = setting.seed;
    const bool same =
        std::equal(plan.conditions.begin(), plan.conditions.end(), setting.conditions.begin(),
                   setting.conditions.end(), [](const ComparisonCondition& a, const ConditionInfo& b) {
                     return a.name == b.name && in_words(a) == b.words;
                   });
    return same ? std::optional<ComparisonPlan>(std::move(plan)) : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

int run_comparison_merge(const MergeOptions& options) {
  const MergeableShards parts = read_shards(options.folders);
  if (parts.folders.size() == 1)
    throw InputError(parts.folders.front().string(), "a whole comparison",
                     "the parts of one, as --shard makes them");
  const ComparisonSetting setting = read_comparison_setting(
      read_file_bytes(parts.folders.front() / setting_name, max_file_bytes), setting_name);
  WorkFolder folder(options.output, {parts.description, {}}, false, options.common.overwrite(options.output),
                    notes_of(setting, {}));
  for (const std::filesystem::path& part : parts.folders) folder.journal().add_part(part / notes_name);
  const std::optional<ComparisonPlan> plan = plan_of(setting);
  std::optional<PlanPictures> pictures;  // not prepared: they are only looked at
  if (plan) pictures.emplace(*plan);
  write_results(setting, pictures ? pictures_of(*pictures) : nullptr, {}, options.common, options.output,
                folder);
  return exit_done;
}

}  // namespace

void add_compare_command(CLI::App& program, Action& action) {
  const auto [command, options] = add_command<CompareOptions>(
      program, action, "compare", "Run every estimator on the same pictures", run_compare);
  command.footer(R"(Examples:
  ballservo compare data/comparisons/basic.yaml -o comparison
  ballservo compare data/comparisons/paper.yaml -o paper              the paper's claims, one by one
  ballservo compare --images pictures --truth truth.csv --start truth -o own    on your own pictures
  ballservo compare data/comparisons/full.yaml -o part_2 --shard 2/4  the second of four parts
  ballservo compare merge part_1 part_2 part_3 part_4 -o whole
  ballservo compare data/comparisons/full.yaml -o full --resume       goes on where it was ended

Writes compare.csv (each method in each condition), fits.csv (every fit), frames.csv (every truth), pairs.csv
(one step against converged), tests.csv (paired tests), certificate.csv, timing.csv, tables.tex, report.html.
--seed is added to the plan's own seed.)");
  add_typed_option(command, "PLAN", options.plan, "PLAN", "What to render and run (YAML)");
  add_typed_option(command, "--images", options.pictures.folder, "DIR",
                   "Your own pictures, instead of a plan");
  add_typed_option(command, "--truth", options.pictures.truth, "FILE", "What is known of the balls in them");
  add_typed_option(command, "--colors", options.pictures.colors, "FILE", "Colours that tell a ball");
  add_typed_option(command, "--camera", options.pictures.camera, "FILE", "The pictures' camera");
  add_number_option(command, "--diameter", options.pictures.diameter_m, NumberRange::above(0, 10, "m"),
                    "The balls' diameter in metres: with --camera, places in space are compared too");
  command
      .add_option("--start", options.start,
                  "Where the fits start: vote (needs --colors), or truth, displaced as votes err")
      ->capture_default_str();
  add_work_options(command, options.work);
  add_keys_flag(command, "plan", plan_keys);
  add_common_options(command, options.common);
  CLI::App* merge = add_merge_command(command, action, run_comparison_merge, false);
  merge->description("Put the parts of a comparison together");
  merge->footer(R"(Example: ballservo compare merge part_1 part_2 part_3 -o whole
gives the tables of the whole, the same bytes as in one run.)");
}

}  // namespace ballservo
