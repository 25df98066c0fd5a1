#include "app/commands/command.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <limits>
#include <map>
#include <opencv2/core/utility.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/options.hpp"

namespace ballservo {
namespace {

[[noreturn]] void refuse(const std::string& name, const std::string& found, const std::string& allowed) {
  throw InputError(name, found.empty() ? "nothing" : found, allowed);
}

/// What follows from the common options before the command does anything.
void apply(CommonOptions& options) {
  if (options.quiet) spdlog::set_level(spdlog::level::err);
  if (options.threads > 0) {
    cv::setNumThreads(options.threads);
    options.processors = std::make_shared<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                               static_cast<std::size_t>(options.threads));
  }
  // Long work must not end at a name that was taken, or a folder that cannot be written, all along.
  if (!options.json.empty()) OutputFile(options.json, options.overwrite());
}

/// Two outputs of one name would leave one of them.
void check_outputs_differ(const CLI::App& command) {
  std::map<std::filesystem::path, std::string> names;
  for (const char* const name :
       {"--output", "--json", "--report", "--preview", "--overlay", "--stages", "--video"}) {
    const CLI::Option* const option = command.get_option_no_throw(name);
    if (!option || option->empty() || option->get_type_size() == 0) continue;
    const auto path = std::filesystem::absolute(option->as<std::string>()).lexically_normal();
    const auto [other, is_new] = names.emplace(path, name);
    if (!is_new)
      throw InputError(name, path.string() + ", as " + other->second, "a name of its own for each output");
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

std::string unused_name(std::set<std::string>& used, const std::string& name) {
  std::string candidate = name;
  for (int i = 2; !used.insert(candidate).second; ++i) candidate = fmt::format("{}_{}", name, i);
  return candidate;
}

CLI::Option* add_number_option(CLI::App& command, const std::string& name, double& value,
                               const NumberRange& range, const std::string& help) {
  return command
      .add_option_function<std::string>(
          name,
          [&value, range, name](const std::string& text) {
            const auto number = parse_number(text);
            if (!number || !range.contains(*number)) refuse(name, text, range.to_text());
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
            const auto number = parse_integer(text);
            if (!number || *number < low || *number > high) {
              const bool bounded = high < std::numeric_limits<int>::max();
              refuse(name, text,
                     bounded ? "a whole number from " + std::to_string(low) + " to " + std::to_string(high)
                             : "a whole number of at least " + std::to_string(low));
            }
            value = static_cast<int>(*number);
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
  command.add_option("--json", options.json, "Write the results as JSON here")->type_name("FILE");
  command.add_flag("--quiet", options.quiet, "Say nothing but errors");
  command.add_flag("--force", options.force, "Replace outputs that exist");
  command
      .add_option_function<std::string>(
          "--seed",
          [&options](const std::string& text) {
            const auto seed = parse_integer(text);
            if (!seed || *seed < 0) refuse("--seed", text, "a whole number of at least 0");
            options.seed = static_cast<std::uint64_t>(*seed);
          },
          "Seed of everything random (default 0)")
      ->type_name("N");
  add_integer_option(command, "--threads", options.threads, 0, 1024,
                     "Threads to work with; the results are the same with any number (default 0: one a "
                     "processor; for the pixels of detect and track, one)");
  add_number_option(command, "--max-pixels", options.max_pixels, NumberRange::at_least(1, "pixels"),
                    "Refuse larger pictures, before they are decoded (default 32e6)");
  command.parse_complete_callback([&command, &options] {
    check_outputs_differ(command);
    apply(options);
  });
}

void write_json_results(const CommonOptions& options, const nlohmann::json& results) {
  if (!options.json.empty()) write_file(options.json, results.dump(2) + "\n", options.overwrite());
}

}  // namespace ballservo
