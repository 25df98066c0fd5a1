#include "app/live/footage_session.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/io/ball_rows.hpp"
#include "app/io/interrupt.hpp"
#include "app/live/client_words.hpp"
#include "app/live/picture_questions.hpp"
#include "app/live/remedies.hpp"
#include "app/report/overlay.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "calibration/color/color_file.hpp"

namespace ballservo {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kept_bytes = std::size_t{64} << 20;  // of pictures that a click may still mean
constexpr std::size_t most_undone = 32, pictures_for_rate = 30;
constexpr auto retry = 1000ms;

/// Whose name says in which format the camera is written.
std::filesystem::path camera_file(const FootageOptions& options) {
  return options.camera_output.empty() ? "camera.yaml" : options.camera_output;
}

}  // namespace

FootageSession::FootageSession(FootageOptions options, DetectorFactory factory, LiveExchange& exchange)
    : options_(std::move(options)),
      factory_(std::move(factory)),
      exchange_(exchange),
      boards_(camera_file_format("", camera_file(options_)).models, [this] {
        boards_changed_ = true;
        exchange_.wake();
      }) {
  colors_ = factory_.colors().classes.empty() ? ColorLessons() : ColorLessons(factory_.colors());
  want_settings_of(factory_.colors());
  open_again();
  if (!options_.camera_output.empty())  // said now, if it can't be
    OutputFile(covariance_file_name(options_.camera_output.string()), options_.overwrite_camera);
  if (options_.last_s > 0)
    recent_.emplace(options_.last_s);
  else if (!options_.record.empty())
    start_recording();
  if (!options_.stream.empty()) stream_.emplace(options_.stream);
  pace_start_ = Clock::now();
  next_ = sequence_->next();
  next_taken_ = Clock::now();
  if (next_)
    factory_.make({next_->bgr.cols, next_->bgr.rows}, next_->source);  // says whether the camera fits
}

FootageSession::~FootageSession() {
  stop_lesson_ = true;
  lesson_.reset();  // waits for it
}

void FootageSession::run() {
  while (!ended_ && !interrupt_requested()) {
    for (const LiveCommand& command : exchange_.next_commands())
      answer(command, [&] { return done(command); });
    finish_lesson();
    if (ended_) break;
    if (boards_changed_.exchange(false) && paused_) look_again();
    if (!paused_ || step_)
      advance();
    else if (!staged_ && stages_are_wanted())
      look_again();
    else
      exchange_.wait_until(Clock::now() + LiveExchange::idle);
  }
}

/// Shows the next picture once its time has come.
void FootageSession::advance() {
  if (!next_ && !read_next()) return;
  const bool is_camera = sequence_->files().empty();
  if (!is_camera && !step_) {
    const auto due = pace_start_ + duration_of(next_->time_s);
    if (Clock::now() < due) {
      exchange_.wait_until(std::min(due, Clock::now() + LiveExchange::idle));
      if (Clock::now() < due) return;
    }
    if (Clock::now() > due + LiveExchange::idle) pace_start_ += Clock::now() - due;  // too slow for its pace
  }
  const auto taken = is_camera ? next_taken_ : Clock::now();
  shown_ = std::exchange(next_, std::nullopt);
  if (step_) pace_start_ = Clock::now() - duration_of(shown_->time_s);
  step_ = false;
  ++pictures_;
  show(taken);
  boards_.show(shown_->bgr, taken);
  try {
    if (is_recording_) record(taken);
    if (recent_) recent_->put(shown_->bgr, shown_->time_s, unix_time_s(taken));
  } catch (const InputError& error) {  // a full disk
    message_ = words_of(error);
    is_recording_ = false;
  }
  shown_at_.push_back(Clock::now());
  if (shown_at_.size() > pictures_for_rate) shown_at_.pop_front();
}

/// A camera that has gone is asked for again; what ends begins again.
bool FootageSession::read_next() {
  try {
    if (!sequence_) open_again();
    next_ = sequence_->next();
    if (!next_ && interrupt_requested()) return false;
    if (!next_ && shown_ && sequence_->length() == 1) {  // a still: as a camera that sees nothing move
      next_ = shown_;
      next_->time_s += 1 / options_.fps;
    } else if (!next_) {
      open_again();
      next_ = sequence_->next();
      pace_start_ = Clock::now();
      restart_tracks();
      is_recording_ = false;  // what follows has been recorded
    }
    if (!next_) throw InputError(options_.source, "no picture", "a source with pictures");
    next_taken_ = Clock::now();
    message_.clear();
    return true;
  } catch (const InputError& error) {
    message_ = words_of(error);
    sequence_.reset();
    look_again();
    exchange_.wait_until(Clock::now() + retry);
    return false;
  }
}

void FootageSession::open_again() {
  sequence_.reset();
  sequence_ = options_.open
                  ? options_.open()
                  : std::move(open_sources({options_.source}, options_.fps, options_.max_pixels).front());
  set_camera();
}

const CameraControls* FootageSession::controls() const { return sequence_ ? sequence_->controls() : nullptr; }

/// As it is wanted, if it can be set.
void FootageSession::set_camera() {
  if (controls() != nullptr) ignored_ = controls()->set(wanted_);
}

void FootageSession::restart_tracks() {
  tracker_.reset();
  tracks_.clear();
}

bool FootageSession::stages_are_wanted() const {
  return shown_ && !colors_.empty() &&
         std::any_of(live_views().begin(), live_views().end(), [&](const LiveView& view) {
           return !view.title.empty() && exchange_.is_looked_at(view.name);
         });
}

/// Finds the balls of the picture, and its stages where somebody looks at them.
std::shared_ptr<const DetectionStages> FootageSession::follow() {
  const cv::Mat& bgr = shown_->bgr;
  const ImageSize size{bgr.cols, bgr.rows};
  if (tracker_ && !(tracker_->detector().rays().size() == size)) restart_tracks();
  if (!tracker_) {
    TrackerOptions tracker_options;
    tracker_options.fixed_colors = options_.fixed_colors;
    tracker_options.seek_light_at_once = !taught_;  // in this light: who has clicked does not wait for others
    tracker_.emplace(factory_.make(size, shown_->source, {false, shown_->coarse_chroma}), tracker_options);
    detector_ = std::make_shared<const Detector>(tracker_->detector());
    time_base_s_ = shown_->time_s;
  }
  if (colors_.empty()) return nullptr;
  tracks_ = tracker_->update(bgr, shown_->time_s - time_base_s_);
  for (Track& track : tracks_) track.ball = factory_.with_total_covariance(track.ball);
  if (!staged_) return nullptr;
  const auto stages = std::make_shared<DetectionStages>();
  Detector(tracker_->detector()).detect(bgr, {{0, 0}, bgr.size()}, stages.get());
  return stages;
}

void FootageSession::show(Clock::time_point taken) {
  const auto begin = Clock::now();
  std::shared_ptr<const DetectionStages> stages;
  staged_ = stages_are_wanted();
  try {
    stages = follow();
  } catch (const InputError& error) {  // a picture of another size than the camera's
    message_ = words_of(error);
    restart_tracks();
  }
  work_ms_ = 1000 * seconds_of(Clock::now() - begin);
  const bool is_read = stream_ || exchange_.is_looked_at(stream_view);
  std::string line = is_read ? stream_line(*shown_, tracks_, factory_.colors(), unix_time_s()) : "";
  if (stream_ && !stream_->send(line)) ended_ = true;
  const cv::Mat& bgr = shown_->bgr;
  const std::uint64_t serial = exchange_.publish(
      state(stages.get()), taken,
      [bgr, stages, detector = detector_, colors = colors_.table()](const std::string& view) {
        return live_picture(view, {bgr, stages.get(), detector.get(), *colors});
      },
      std::move(line));
  kept_.push_back({serial, bgr});
  kept_bytes_ += bgr.total() * bgr.elemSize();
  while (kept_.size() > 1 && kept_bytes_ > kept_bytes) {
    kept_bytes_ -= kept_.front().bgr.total() * kept_.front().bgr.elemSize();
    kept_.pop_front();
  }
}

/// Shows the same picture again, after something else has changed.
void FootageSession::look_again() {
  if (shown_) show(Clock::now());
}

FootageSession::Json FootageSession::balls() const {
  Json listed = Json::array();
  for (const Track& track : tracks_) {
    Json ball = track_json(track, factory_.colors());
    const TangentCone& cone = track.ball.cone;
    ball["rim_px"] = points_px_json(  // the outline as a polygon, as the lens bends it
        project_outline(detector_->rays().camera(), cone.axis, std::sin(cone.alpha_rad), 48));
    if (track.ball.position) ball["position"] = position_text(*track.ball.position);
    listed.push_back(std::move(ball));
  }
  return listed;
}

/// What `boards_` has come to, and what the page proposes.
FootageSession::Json FootageSession::calibration() const {
  Json said = boards_.state();
  said["proposed"] = {{"board", options_.board}, {"square_m", options_.square_m}};
  said["output"] = options_.camera_output.filename().string();
  said["diameter"] = factory_.diameter();
  return said;
}

FootageSession::Json FootageSession::state(const DetectionStages* stages) const {
  double rate_hz = 0;
  if (shown_at_.size() > 1)
    rate_hz = static_cast<double>(shown_at_.size() - 1) / seconds_of(shown_at_.back() - shown_at_.front());
  Json views = Json::array();
  for (const LiveView& view : live_views()) views.push_back({{"name", view.name}, {"remedy", view.remedy}});
  Json warnings = colors_.warnings();
  if (!factory_.doubt().empty()) warnings.push_back(factory_.doubt());
  if (factory_.camera_counts_as_exact())
    warnings.push_back("nothing beside the camera's file says how well it is known: 95 % counts it as exact");
  Json said = {{"kind", "footage"},
               {"source", options_.source},
               {"file", shown_->source},
               {"frame", pictures_},
               {"time_s", shown_->time_s - time_base_s_},
               {"width_px", shown_->bgr.cols},
               {"height_px", shown_->bgr.rows},
               {"rate_hz", rate_hz},
               {"work_ms", work_ms_},
               {"paused", paused_},
               {"learning", lesson_.has_value()},
               {"undo", !undone_to_.empty()},
               {"message", message_},
               {"camera", controls() != nullptr},
               {"ignored", ignored_},
               {"balls", balls()},
               {"classes", colors_.classes()},
               {"calibration", calibration()},
               {"warnings", warnings},
               {"colors_output", options_.colors_output.filename().string()},
               {"views", views},
               {"can_record", !options_.record.empty()},
               {"recent_s", recent_ ? Json(recent_->seconds()) : Json()},
               {"recording", nullptr}};
  if (recording_)
    said["recording"] = {{"on", is_recording_},
                         {"folder", recording_->folder().string()},
                         {"kept", recording_->kept()},
                         {"lost", recording_->lost()},
                         {"fault", recording_->fault()}};
  if (stages) said["candidates"] = candidates_json(*stages, *colors_.table());
  return said;
}

/// The folder that was named, and after it others beside it.
std::filesystem::path FootageSession::take_folder() {
  if (folders_++ == 0) return options_.record;
  options_.overwrite_recording = Overwrite::refuse;
  return unused_path(options_.record);
}

/// The tracks begin anew, so that the recording gives the same.
void FootageSession::start_recording() {
  const std::filesystem::path folder = take_folder();
  recording_.emplace(folder, options_.overwrite_recording);
  is_recording_ = true;
  taught_ = false;
  restart_tracks();
}

FilesBeside FootageSession::beside() const {
  const Json settings = {{"source", options_.source},
                         {"camera_settings", sequence_ ? sequence_->camera_settings() : decltype(wanted_)()},
                         {"fixed_colors", options_.fixed_colors}};
  FilesBeside files{{"settings.json", settings.dump(2) + "\n"}};
  if (!colors_.empty()) files["taught.colors"] = color_file_bytes(*colors_.table());
  return files;
}

FootageSession::Json FootageSession::keep_recent(const LiveCommand& command) {
  if (!recent_) throw Refusal("start with --record DIR --last SECONDS");
  if (keeping_.valid() && keeping_.wait_for(0s) != std::future_status::ready)
    throw Refusal("the last ones are still being written");
  if (recent_->pictures().empty()) throw Refusal("there is no picture yet");
  const std::filesystem::path folder = take_folder();
  keeping_ = std::async(std::launch::async, [command, folder, overwrite = options_.overwrite_recording,
                                             pictures = recent_->pictures(), beside = beside()] {
    answer(command, [&]() -> Json {
      write_recording(folder, overwrite, pictures, beside);
      return {{"folder", folder.string()}, {"pictures", pictures.size()}};
    });
  });
  return nullptr;
}

void FootageSession::record(Clock::time_point taken) {
  const double time_s = shown_->time_s - time_base_s_;
  if (time_s == 0) recording_->put_beside(beside());
  std::string rows;
  for (const Track& track : tracks_)
    rows += ball_row({recording_->next_name(), 0, time_s, track.id,
                      factory_.colors().name_of(track.color_class), track_state_name(track.state)},
                     track.ball);
  if (recording_->put(shown_->bgr, time_s, unix_time_s(taken), std::move(rows)) || recording_->lost() > 1)
    return;
  const std::string fault = recording_->fault();
  spdlog::warn("{}: pictures are lost: {}", recording_->folder().string(),
               fault.empty() ? "they come faster than they can be compressed and written" : fault);
}

/// Says what came of it; null where a thread of its own does that.
FootageSession::Json FootageSession::done(const LiveCommand& command) {
  const Json& what = command.what;
  const std::string verb = text_at(what, "do");
  if (verb == "teach") return teach(command);
  if (verb == "rename") return rename(command);
  if (verb == "keep") return keep_recent(command);
  if (verb == "why") return why(what);
  if (verb == "camera" || verb == "hold") return camera(what);
  if (verb == "save") return save();
  if (verb == "load") return load(what);
  if (verb == "save_camera") return save_camera();
  if (verb.rfind("calibrate", 0) == 0) boards_changed_ = true;
  if (verb == "calibrate") {
    const double square_m = length_m_at(what, "square_m", "the square's side", 0.001, 1);
    boards_.start(BoardLessons(text_at(what, "board"), square_m));
  } else if (verb == "calibrate_go_on") {
    boards_.go_on();
  } else if (verb == "calibrate_stop") {
    boards_.stop();
  } else if (verb == "calibrate_undo") {
    boards_.undo();
  } else if (verb == "diameter") {
    factory_.set_diameter(number_text(length_m_at(what, "diameter_m", "the ball's diameter", 0.001, 9.999)));
    restart_tracks();
    look_again();
  } else if (verb == "undo") {
    if (undone_to_.empty()) throw Refusal("there is nothing to undo");
    use(std::move(undone_to_.back()));
    undone_to_.pop_back();
  } else if (verb == "pause") {
    paused_ = !paused_;
    if (!paused_ && next_) pace_start_ = Clock::now() - duration_of(next_->time_s);
    look_again();
  } else if (verb == "step") {
    paused_ = step_ = true;
  } else if (verb == "record") {
    if (options_.record.empty()) throw Refusal("start with --record DIR: the page writes nowhere else");
    if (is_recording_)
      is_recording_ = false;
    else
      start_recording();
  } else if (verb == "end") {
    ended_ = true;
  } else {
    throw Refusal(fmt::format("'{}' is nothing that can be done here", verb.substr(0, 40)));
  }
  return Json::object();
}

/// The picture that a client has clicked on.
const cv::Mat& FootageSession::picture_of(const Json& what) const {
  const double serial = number_at(what, "serial", -1);
  for (const Kept& kept : kept_) {
    if (static_cast<double>(kept.serial) == serial) return kept.bgr;
  }
  throw Refusal("that picture is gone by now: pause, and click again");
}

/// Null: `finish_lesson` answers.
FootageSession::Json FootageSession::begin_lesson(const LiveCommand& command,
                                                  std::function<Learnt(const ColorLessons&)> learn) {
  if (lesson_) throw Refusal("the last lesson is still being learnt");
  std::packaged_task<Learnt(const ColorLessons&)> task(std::move(learn));
  lesson_.emplace(Lesson{command, task.get_future(), {}});
  lesson_->thread = std::async(std::launch::async, [this, task = std::move(task), base = colors_]() mutable {
    task(base);
    exchange_.wake();
  });
  return nullptr;
}

FootageSession::Json FootageSession::teach(const LiveCommand& command) {
  const Json& what = command.what;
  PointedLesson lesson;
  lesson.bgr = picture_of(what);
  lesson.at = {{number_at(what, "u_px", -1e9), number_at(what, "v_px", -1e9)},
               number_at(what, "radius_px", 0)};
  lesson.name = text_at(what, "name");
  return begin_lesson(command, [this, lesson, reply = command.answer](const ColorLessons& base) {
    Learnt learnt;
    learnt.colors = base.with(
        lesson,
        [this] {
          if (stop_lesson_) throw Interrupted();
        },
        [&](const PointedBall& ball) {
          learnt.circle_px = {ball.center_px.x(), ball.center_px.y(), ball.radius_px};
          reply({{"answer", "found"}, {"circle_px", learnt.circle_px}});
        },
        learnt.name);
    return learnt;
  });
}

FootageSession::Json FootageSession::rename(const LiveCommand& command) {
  const std::string from = text_at(command.what, "class"), to = text_at(command.what, "name");
  return begin_lesson(command, [from, to](const ColorLessons& base) {
    return Learnt{base.renamed(from, to), nullptr, to};
  });
}

void FootageSession::finish_lesson() {
  if (!lesson_ || lesson_->learnt.wait_for(0s) != std::future_status::ready) return;
  Lesson lesson = *std::exchange(lesson_, std::nullopt);
  answer(lesson.command, [&]() -> Json {
    Learnt learnt = lesson.learnt.get();
    learn(std::move(learnt.colors));
    return {{"class", learnt.name}, {"circle_px", learnt.circle_px}};
  });
}

void FootageSession::learn(ColorLessons colors) {
  undone_to_.push_back(colors_);
  if (undone_to_.size() > most_undone) undone_to_.erase(undone_to_.begin());
  use(std::move(colors));
}

void FootageSession::use(ColorLessons colors) {
  taught_ = true;
  colors_ = std::move(colors);
  factory_.set_colors(colors_.table());
  restart_tracks();
  look_again();
}

FootageSession::Json FootageSession::why(const Json& what) {
  const cv::Mat& bgr = picture_of(what);
  const Eigen::Vector2d point(number_at(what, "u_px", -1), number_at(what, "v_px", -1));
  if (colors_.empty()) throw Refusal("no colour has been taught yet: press Teach, and click on a ball");
  Detector detector = tracker_ ? tracker_->detector() : factory_.make({bgr.cols, bgr.rows}, options_.source);
  return why_no_ball(bgr, point, detector, bgr.data == shown_->bgr.data ? tracks_ : std::vector<Track>());
}

/// How the camera is set, after what is asked for has been done.
FootageSession::Json FootageSession::camera(const Json& what) {
  if (controls() == nullptr) throw Refusal("this source is no camera that can be set");
  const std::string name = text_at(what, "name").substr(0, 40);
  if (text_at(what, "do") == "hold") {
    ignored_ = controls()->hold();
    wanted_ = controls()->values();
  } else if (!name.empty()) {
    const double value = number_at(what, "value", std::nan(""));
    ignored_ = controls()->set({{name, value}});
    if (ignored_.empty()) wanted_[name] = value;
  }
  Json listed = Json::array();
  for (const CameraControl& control : controls()->all())
    listed.push_back({{"name", control.name},
                      {"value", control.value},
                      {"minimum", control.minimum},
                      {"maximum", control.maximum},
                      {"step", control.step}});
  return {{"controls", listed}, {"ignored", ignored_}};
}

/// Colours that were taught with the camera's automatics off want it set so again.
void FootageSession::want_settings_of(const ColorTable& colors) {
  if (!colors.camera_settings.empty() && is_held(colors.camera_settings)) wanted_ = colors.camera_settings;
}

FootageSession::Json FootageSession::save() {
  if (colors_.empty()) throw Refusal("no colour has been taught yet");
  ColorTable table = *colors_.table();
  if (controls() != nullptr) table.camera_settings = controls()->values();
  const std::string bytes = color_file_bytes(table);
  if (!options_.colors_output.empty()) {
    write_file(options_.colors_output, bytes, options_.overwrite_colors);
    options_.overwrite_colors = Overwrite::allow;  // its own file
    return {{"saved", options_.colors_output.string()}};
  }
  return download_json("taught.colors", bytes);
}

FootageSession::Json FootageSession::load(const Json& what) {
  if (lesson_) throw Refusal("the last lesson is still being learnt");
  const auto bytes = from_base64(text_at(what, "base64"));
  if (!bytes) throw Refusal("that is no file that came through whole");
  ColorLessons colors = ColorLessons(parse_color_file(*bytes, "the file"));
  want_settings_of(*colors.table());
  set_camera();
  learn(std::move(colors));
  return {{"classes", colors_.table()->classes.size()}};
}

/// Of the boards that were held before it; and goes on with it, without boards.
FootageSession::Json FootageSession::save_camera() {
  const BoardCalibration found = boards_.calibration();
  const std::filesystem::path file = camera_file(options_);
  const std::string text = camera_file_text(found.camera, camera_file_format("", file), file.stem().string());
  const std::string beside = camera_covariance_text(found.camera, found.covariance.parameters);
  boards_.stop();
  factory_.set_camera({found.camera, found.covariance.parameters});
  restart_tracks();
  look_again();
  if (options_.camera_output.empty())
    return {
        {"files",
         {download_json(file.string(), text), download_json(covariance_file_name(file.string()), beside)}}};
  write_file(file, text, options_.overwrite_camera);
  write_file(covariance_file_name(file.string()), beside, options_.overwrite_camera);
  options_.overwrite_camera = Overwrite::allow;  // its own file
  return {{"saved", file.string()}};
}

}  // namespace ballservo
