#include "app/commands/command.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <opencv2/core/utility.hpp>

#include "app/io/interrupt.hpp"
#include "app/io/work_folder.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/options.hpp"

namespace ballservo {
namespace {

/// Of --seed; a sweep counts on from it.
constexpr long long max_seed = 1'000'000'000'000'000'000;

constexpr const char* outputs_group = "Outputs";

long long whole_number(const std::string& option, const std::string& text, long long low, long long high) {
  const auto number = parse_integer(text);
  if (!number || *number < low || *number > high)
    throw InputError(option, text, fmt::format("a whole number from {} to {}", low, high));
  return *number;
}

/// What follows from the common options before the command does anything.
void apply(CommonOptions& options) {
  if (options.quiet) spdlog::set_level(spdlog::level::err);
  if (options.threads > 0) {
    cv::setNumThreads(options.threads);
    options.processors = std::make_shared<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                               static_cast<std::size_t>(options.threads));
  }
  if (options.json == standard_output) give_stdout_to_json();
}

bool is_input(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const auto speaks_of = [&](const char* word) { return type.find(word) != std::string::npos; };
  return option.get_group() != outputs_group &&
         (option.get_positional() || speaks_of("FILE") || speaks_of("DIR") || speaks_of("IMAGE") ||
          speaks_of("VIDEO"));
}

/// The names in FILE, FILE:NAME, NAME=FILE,FILE.
std::vector<std::string> names_in(const std::string& value) {
  std::error_code error;
  if (std::filesystem::exists(value, error)) return {value};
  std::vector<std::string> names;
  for (const std::string& part : split(value.substr(value.find('=') + 1), ','))
    names.insert(names.end(), {part, part.substr(0, part.rfind(':'))});
  return names;
}

/// An option that lacks its value would take the next option for it.
void refuse_options_as_values(const CLI::App& command) {
  for (const CLI::Option* const option : command.get_options())
    for (const std::string& value : option->results())
      if (value.size() > 1 && value.front() == '-' && command.get_option_no_throw(value))
        throw InputError(option->get_name(), value, "a value; that is another option");
}

/// Names the files of the run, outputs first.
void register_files(const CLI::App& command, RunFiles& files) {
  for (const CLI::Option* const option : command.get_options()) {
    if (option->get_group() != outputs_group) continue;
    const bool dash = option->get_name() == "--json" || option->get_type_name() == "FILE.csv";
    for (const std::string& name : option->results()) files.writes(option->get_name(), name, dash);
  }
  for (const CLI::Option* const option : command.get_options()) {
    if (!is_input(*option)) continue;
    for (const std::string& value : option->results()) {
      if (value.empty())
        throw InputError(option->get_name(), "an empty name", "the name of what is to be read");
      for (const std::string& name : names_in(value)) files.reads(option->get_name(), name);
    }
  }
}

}  // namespace

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == std::string::npos) return parts;
    begin = end + 1;
  }
}

std::string counted(long count, const std::string& thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

std::string unused_name(std::set<std::string>& used, const std::string& name) {
  std::string candidate = name;
  for (int i = 2; !used.insert(candidate).second; ++i) candidate = fmt::format("{}_{}", name, i);
  return candidate;
}

CLI::Option* add_output_option(CLI::App& command, const std::string& name, std::filesystem::path& value,
                               const std::string& type, const std::string& help) {
  return add_typed_option(command, name, value, type, help)->group(outputs_group);
}

CLI::Option* add_number_option(CLI::App& command, const std::string& name, double& value,
                               const NumberRange& range, const std::string& help) {
  return command
      .add_option_function<std::string>(
          name,
          [&value, range, name](const std::string& text) {
            const auto number = parse_number(text);
            if (!number || !range.contains(*number)) throw InputError(name, text, range.to_text());
            value = *number;
          },
          help)
      ->type_name("NUMBER");
}

CLI::Option* add_integer_option(CLI::App& command, const std::string& name, int& value, int low, int high,
                                const std::string& help) {
  return command
      .add_option_function<std::string>(
          name,
          [&value, low, high, name](const std::string& text) {
            value = static_cast<int>(whole_number(name, text, low, high));
          },
          help)
      ->type_name("N");
}

void add_keys_flag(CLI::App& command, const std::string& file, std::vector<OptionRow> (*keys)()) {
  command.add_flag_callback(
      "--keys",
      [file, keys] {
        print_result("{}", option_page(file, keys()));
        throw CLI::Success();
      },
      "Print every key of a " + file + ": unit, default, allowed values, meaning");
}

void add_common_options(CLI::App& command, CommonOptions& options) {
  add_output_option(command, "--json", options.json, "FILE", "Write the results as JSON here; -: to stdout");
  command.add_flag("--quiet", options.quiet, "Say nothing but errors");
  command.add_flag("--force", options.force, "Replace outputs that exist");
  command
      .add_option_function<std::string>(
          "--seed",
          [&options](const std::string& text) {
            options.seed = static_cast<std::uint64_t>(whole_number("--seed", text, 0, max_seed));
          },
          "Seed of everything random (default 0)")
      ->type_name("N");
  add_integer_option(command, "--threads", options.threads, 0, max_threads,
                     "Threads to work with; the results are the same with any number (default 0: one a "
                     "processor; for the pixels of detect and track, one)");
  add_number_option(command, "--max-pixels", options.max_pixels, NumberRange::at_least(1, "pixels"),
                    "Refuse larger pictures, before they are decoded (default 32e6)");
  command.parse_complete_callback([&command, &options] {
    refuse_options_as_values(command);
    register_files(command, *options.files);
    tidy_when_stopped([files = options.files] { files->tidy(); });
    apply(options);
  });
}

void check_outputs(const CLI::App& command, const CommonOptions& options) {
  const auto given = [&](const char* flag) {
    const CLI::Option* const option = command.get_option_no_throw(flag);
    return option && option->count() > 0 && option->as<bool>();
  };
  const bool has_jobs = command.get_option_no_throw("--resume") != nullptr;
  FaultList faults;
  for (const CLI::Option* const option : command.get_options()) {
    if (option->get_group() != outputs_group) continue;
    const bool folder = option->get_type_name() == "DIR" && !given("--teach");
    for (const std::filesystem::path name : option->results()) {
      std::error_code unreadable;
      if (name == standard_output) continue;
      if (folder && has_jobs &&
          (given("--resume") || std::filesystem::exists(name / WorkFolder::journal_name, unreadable)))
        continue;
      faults.collect([&] {
        folder ? void(OutputFolder(name, options.overwrite(name)))
               : void(OutputFile(name, options.overwrite(name)));
      });
    }
  }
  faults.throw_if_any();
}

void write_json_results(const CommonOptions& options, const nlohmann::json& results) {
  if (options.json.empty()) return;
  const std::string text = results.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  if (options.json == standard_output) return write_json(text);
  OutputFile file(options.json, options.overwrite(options.json));
  file.write(text);
  options.files->commit(file);
}

}  // namespace ballservo
