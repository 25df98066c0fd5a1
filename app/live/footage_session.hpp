// A session over a camera, a video, a folder or a recording: balls are followed in it, and colours taught.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/commands/ball_options.hpp"
#include "app/io/image_source.hpp"
#include "app/io/recording.hpp"
#include "app/io/track_stream.hpp"
#include "app/live/board_worker.hpp"
#include "app/live/color_lessons.hpp"
#include "app/live/live_exchange.hpp"
#include "perception/tracking/tracker.hpp"

namespace ballservo {

struct FootageOptions {
  std::string source;
  std::function<std::unique_ptr<FrameSequence>()> open;  ///< opens the source; empty: as its name says
  double fps = 30, max_pixels = 0;
  bool fixed_colors = false;
  std::filesystem::path colors_output;  ///< where `save` writes; empty: nowhere, the page downloads
  std::filesystem::path record;         ///< empty: no recording
  double last_s = 0;                    ///< above 0: nothing is recorded until asked for; so much is at hand
  std::string stream;                   ///< see TrackStream; empty: none
  Overwrite overwrite_colors = Overwrite::refuse, overwrite_recording = Overwrite::refuse;
  std::string board = "chessboard:9x6";  ///< which the page proposes to calibrate with
  double square_m = 0;                   ///< of that board; 0: not known
  std::filesystem::path camera_output;   ///< where `save_camera` writes; empty: nowhere, the page downloads
  Overwrite overwrite_camera = Overwrite::refuse;
};

/// Runs on the caller's thread; clients' commands are done between two pictures.
class FootageSession {
 public:
  /// Opens the source and the outputs. Throws InputError.
  FootageSession(FootageOptions options, DetectorFactory factory, LiveExchange& exchange);
  ~FootageSession();

  /// Until a client ends it, or the user interrupts. What happens to the source meanwhile is shown.
  void run();
  long pictures() const { return pictures_; }

 private:
  using Clock = LiveExchange::Clock;
  using Json = nlohmann::json;

  /// What a lesson's thread hands back.
  struct Learnt {
    ColorLessons colors;
    Json circle_px;  // of a ball that was pointed at
    std::string name;
  };
  struct Lesson {
    LiveCommand command;
    std::future<Learnt> learnt;
    std::future<void> thread;
  };
  struct Kept {
    std::uint64_t serial;
    cv::Mat bgr;
  };

  void advance();
  bool read_next();
  void open_again();
  std::shared_ptr<const DetectionStages> follow();
  bool stages_are_wanted() const;
  void show(Clock::time_point taken);
  void restart_tracks();
  void learn(ColorLessons colors);
  void use(ColorLessons colors);
  void look_again();
  Json state(const DetectionStages* stages) const;
  Json balls() const;
  Json calibration() const;
  void record(Clock::time_point taken);
  void start_recording();
  std::filesystem::path take_folder();
  FilesBeside beside() const;

  Json done(const LiveCommand& command);
  Json teach(const LiveCommand& command);
  Json rename(const LiveCommand& command);
  Json keep_recent(const LiveCommand& command);
  Json begin_lesson(const LiveCommand& command, std::function<Learnt(const ColorLessons&)> learn);
  void finish_lesson();
  Json why(const Json& what);
  Json camera(const Json& what);
  const CameraControls* controls() const;
  void want_settings_of(const ColorTable& colors);
  void set_camera();
  Json save();
  Json load(const Json& what);
  Json save_camera();
  const cv::Mat& picture_of(const Json& what) const;

  FootageOptions options_;
  DetectorFactory factory_;
  LiveExchange& exchange_;
  std::unique_ptr<FrameSequence> sequence_;
  std::optional<Frame> next_, shown_;
  std::optional<Tracker> tracker_;
  std::shared_ptr<const Detector> detector_;  // knows camera and colours of what is drawn
  std::vector<Track> tracks_;
  ColorLessons colors_;
  std::vector<ColorLessons> undone_to_;  // what `undo` goes back to, the last one last
  std::optional<Lesson> lesson_;
  std::atomic<bool> stop_lesson_{false};
  std::atomic<bool> boards_changed_{false};
  BoardWorker boards_;
  std::optional<RecordingWriter> recording_;
  std::optional<RecentPictures> recent_;
  std::future<void> keeping_;
  int folders_ = 0;  // that recordings have taken
  std::optional<TrackStream> stream_;
  bool is_recording_ = false, paused_ = false, step_ = false, ended_ = false;
  bool taught_ = false;                   // since the program started, or began to record
  bool staged_ = false;                   // the stages of what is shown were wanted
  std::string message_;                   // what is wrong with the source
  std::map<std::string, double> wanted_;  // how the camera is to be set, also when it comes back
  std::string ignored_;                   // what of it the camera ignored
  std::deque<Kept> kept_;
  std::size_t kept_bytes_ = 0;
  Clock::time_point pace_start_, next_taken_;
  double time_base_s_ = 0, work_ms_ = 0;
  std::deque<Clock::time_point> shown_at_;
  long pictures_ = 0;
};

}  // namespace ballservo
