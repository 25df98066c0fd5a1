#include "app/commands/ball_search.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "app/io/interrupt.hpp"
#include "app/report/picture.hpp"
#include "app/report/stage_pictures.hpp"

namespace ballservo {
namespace {

/// Several inputs of one file name, which is all that the rows say of where a ball was.
void warn_of_repeated_names(const std::vector<std::unique_ptr<FrameSequence>>& sequences) {
  const std::vector<std::string> repeated = repeated_names(sequences);
  if (repeated.empty()) return;
  spdlog::warn(
      "several inputs are called {}{}: `source` names a file without its folders, so that their rows can be "
      "told apart by their order alone",
      repeated.front(), repeated.size() > 1 ? fmt::format(", and so are {} more", repeated.size() - 1) : "");
}

/// A sequence that ended after `read` pictures although it should have clearly more.
void warn_of_missing_pictures(const FrameSequence& sequence, long read) {
  constexpr double counts_are_true_to = 0.02;  // of a container's, which may be estimates
  if (static_cast<double>(read + 1) >= (1 - counts_are_true_to) * static_cast<double>(sequence.length()))
    return;
  spdlog::warn("{}: {} pictures could be read, of some {} that it should have: it is cut off or damaged",
               sequence.name(), read, sequence.length());
}

/// Whether hardly a pixel's channels differ by more than noise.
bool is_grey(const cv::Mat& bgr) {
  constexpr int most_apart = 8;
  constexpr double most_colored = 1e-4;
  const auto colored = std::count_if(bgr.begin<cv::Vec3b>(), bgr.end<cv::Vec3b>(), [](const cv::Vec3b& c) {
    const auto [low, high] = std::minmax({c[0], c[1], c[2]});
    return high - low > most_apart;
  });
  return static_cast<double>(colored) < most_colored * static_cast<double>(bgr.total());
}

}  // namespace

std::string light_text(const AssumedLight& light) {
  const LogGain factor = light.gain.exp();
  return fmt::format("grey levels x{:.2f} in blue, x{:.2f} in green, x{:.2f} in red{}", factor[0], factor[1],
                     factor[2],
                     light.power < 1   ? ", linear where the taught ones were sRGB"
                     : light.power > 1 ? ", sRGB where the taught ones were linear"
                                       : "");
}

void warn_of_other_light(const std::string& lights) {
  spdlog::warn(
      "a ball showed only in another light than the taught one, which was assumed ({}); if that is no ball "
      "of yours, teach the colours in this light",
      lights);
}

nlohmann::json light_json(const AssumedLight& light) {
  const LogGain factor = light.gain.exp();
  return {{"factor_bgr", {factor[0], factor[1], factor[2]}}, {"power", light.power}};
}

void add_ball_search_options(CLI::App& command, BallSearchOptions& options, const std::string& sources_help,
                             const std::string& output_help, const std::string& stages_help) {
  command.add_option("SOURCE", options.sources, sources_help)->required();
  add_ball_options(command, options.balls);
  add_output_option(command, "-o,--output", options.output, "FILE.csv", output_help);
  add_output_option(command, "--stages", options.stages, "DIR", stages_help);
}

BallSearch::BallSearch(const BallSearchOptions& options, const std::string& name)
    : options_(options), factory_(options.balls, options.common) {
  sequences_ = open_sources(options.sources, options.fps, options.common.max_pixels);
  warn_of_repeated_names(sequences_);
  const bool streams_to_stdout = options.stream == standard_output;
  const bool rows_to_stdout =
      options.output == standard_output || (options.output.empty() && !streams_to_stdout);
  if (rows_to_stdout && options.common.json == standard_output)
    throw InputError("--json", "stdout, where the rows go", "-o FILE beside it");
  if (streams_to_stdout && (rows_to_stdout || options.common.json == standard_output))
    throw InputError(rows_to_stdout ? "-o" : "--json", "stdout, where the stream goes", "the name of a file");
  if (!rows_to_stdout && !options.output.empty())
    csv_file_.emplace(options.output, options.common.overwrite(options.output));
  if (!options.stages.empty()) stages_.emplace(options.stages, options.common.overwrite(options.stages));
  long total = 0;
  for (const auto& sequence : sequences_) total += sequence->length();
  progress_ = std::make_unique<Progress>(name, total, options.common.quiet);
}

void BallSearch::each_sequence(const std::function<void(FrameSequence&)>& follow) {
  for (const auto& sequence : sequences_) {
    const long before = pictures_;
    follow(*sequence);
    if (interrupted_) return;
    warn_of_missing_pictures(*sequence, pictures_ - before);
  }
}

std::optional<Frame> BallSearch::next(FrameSequence& sequence) {
  interrupted_ = interrupted_ || interrupt_requested();
  if (interrupted_) return std::nullopt;
  std::optional<Frame> frame = sequence.next();
  if (!frame) return frame;
  all_grey_ = all_grey_ && is_grey(frame->bgr);
  progress_->step(++pictures_);
  return frame;
}

void BallSearch::left_out(const LeftOut& left_out, const Frame& frame) {
  if (!left_out || left_out_pictures_++ > 0) return;
  left_out_example_ = fmt::format("{}, frame {}", frame.source, frame.index);
  if (left_out.regions > 0) left_out_example_ += fmt::format(", {} smaller regions", left_out.regions);
  if (left_out.shorter_px > 0)
    left_out_example_ += fmt::format(", runs shorter than {} px", left_out.shorter_px);
}

void BallSearch::assumed_light(const AssumedLight& light, const std::string& where) {
  if (other_lights_++ == 0) first_light_ = fmt::format("{}: {}", where, light_text(light));
}

void BallSearch::add_row(const Frame& frame, std::optional<int> track_id, ClassIndex color_class,
                         std::string_view state, const BallObservation& ball) {
  csv_ += ball_row(
      {frame.source, frame.index, frame.time_s, track_id, factory_.colors().name_of(color_class), state},
      factory_.with_total_covariance(ball));
}

void BallSearch::write_stages(const std::string& name, const Frame& frame, const DetectionStages& stages,
                              const Detector& detector) const {
  const cv::Mat grid = labelled_grid(stage_pictures(frame.bgr, stages, detector));
  stages_->write(name + "_stages.png", picture_bytes(grid, ".png"));
}

void BallSearch::end() {
  if (left_out_pictures_ > 0)
    spdlog::warn(
        "{} had more regions of the balls' colours than are searched, and small balls may have "
        "been missed (left out in {}): colours that the background has too? Teach them with --background",
        counted(left_out_pictures_, "picture"), left_out_example_);
  if (other_lights_ > 0)
    warn_of_other_light(first_light_ +
                        (other_lights_ > 1 ? fmt::format(", and {} more", other_lights_ - 1) : ""));
  options_.common.files->commit(stages_);
}

Refusal BallSearch::no_ball(const std::string& hint) const {
  return Refusal(fmt::format(
      "no ball in {}{}; {}", counted(pictures_, "picture"),
      csv_file_ ? fmt::format(", {} is not written", options_.output.string()) : "",
      all_grey_ ? "all is grey there: it takes a colour camera, light, and pictures saved in colour" : hint));
}

int BallSearch::finish(nlohmann::json results, const std::string& summary) {
  results["interrupted"] = interrupted_;
  if (csv_file_) {
    csv_file_->write(csv_);
    options_.common.files->commit(csv_file_);
  } else if (options_.stream != standard_output) {
    print_result("{}", csv_);
  }
  write_json_results(options_.common, results);
  if (csv_file_ && !options_.common.quiet)
    print_result("{}{}: {}\n", interrupted_ ? "interrupted; " : "", summary, options_.output.string());
  return interrupted_ ? exit_interrupted : exit_done;
}

}  // namespace ballservo
