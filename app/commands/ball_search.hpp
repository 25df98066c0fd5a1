// What detect and track share: pictures in, rows of balls out.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/commands/ball_options.hpp"
#include "app/commands/command.hpp"
#include "app/io/ball_rows.hpp"
#include "app/io/image_source.hpp"
#include "app/io/progress.hpp"
#include "calibration/base/fault.hpp"
#include "perception/tracking/light_adaptation.hpp"

namespace ballservo {

struct BallSearchOptions {
  CommonOptions common;
  BallOptions balls;
  std::vector<std::string> sources;
  std::filesystem::path output, stages;
  std::optional<std::string> stream;  ///< of track: "-" or "udp:HOST:PORT"
  double fps = 30;
};

/// Adds SOURCE, the options of the balls, -o and --stages, with the help that is said to each.
void add_ball_search_options(CLI::App& command, BallSearchOptions& options, const std::string& sources_help,
                             const std::string& output_help, const std::string& stages_help);

nlohmann::json light_json(const AssumedLight& light);
std::string light_text(const AssumedLight& light);
void warn_of_other_light(const std::string& lights);

class BallSearch {
 public:
  /// Opens the sources and the outputs, and warns of what the rows cannot tell apart. Throws InputError.
  BallSearch(const BallSearchOptions& options, const std::string& name);

  const DetectorFactory& factory() const { return factory_; }
  std::size_t sequences() const { return sequences_.size(); }
  long pictures() const { return pictures_; }
  bool interrupted() const { return interrupted_; }

  /// Hands on one sequence after the other, until the work is interrupted; warns of those that are cut off.
  void each_sequence(const std::function<void(FrameSequence&)>& follow);
  /// The next picture; nothing at the sequence's end, or where the user has had enough.
  std::optional<Frame> next(FrameSequence& sequence);
  /// Ends the work as an interrupt does.
  void stop() { interrupted_ = true; }

  /// Remembers what a picture had too much of, for one warning in the end.
  void left_out(const LeftOut& left_out, const Frame& frame);
  /// Remembers where no ball showed but in another light than the taught one, for one warning in the end.
  void assumed_light(const AssumedLight& light, const std::string& where);
  /// A row of detections.csv or tracks.csv.
  void add_row(const Frame& frame, std::optional<int> track_id, ClassIndex color_class,
               std::string_view state, const BallObservation& ball);
  bool shows_stages() const { return stages_.has_value(); }
  void write_stages(const std::string& name, const Frame& frame, const DetectionStages& stages,
                    const Detector& detector) const;

  /// Says what was left out and puts the stages in place; what a Refusal may follow.
  void end();
  /// For a run without rows. `hint`: what to do, unless the pictures have no colour at all.
  Refusal no_ball(const std::string& hint) const;
  /// Writes the rows, to stdout where no file was named, and then the JSON results; `summary` is said where
  /// the rows went into a file. Returns the exit code.
  int finish(nlohmann::json results, const std::string& summary);

 private:
  const BallSearchOptions& options_;
  DetectorFactory factory_;
  std::vector<std::unique_ptr<FrameSequence>> sequences_;
  std::optional<OutputFile> csv_file_;
  std::optional<OutputFolder> stages_;
  std::unique_ptr<Progress> progress_;
  std::string csv_ = ball_rows_header(), left_out_example_, first_light_;
  long pictures_ = 0, left_out_pictures_ = 0, other_lights_ = 0;
  bool interrupted_ = false, all_grey_ = true;
};

}  // namespace ballservo
