#include "app/live/board_worker.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <cmath>
#include <utility>

#include "calibration/base/fault.hpp"
#include "calibration/base/statistics.hpp"
#include "calibration/boards/board_detector.hpp"

namespace ballservo {
namespace {

using Json = nlohmann::json;

/// The tracks come first.
void give_way() {
  constexpr int niceness = 5;
  setpriority(PRIO_PROCESS, 0, niceness);  // in Linux of this thread
}

double rounded(double value, double parts = 10) { return std::round(parts * value) / parts; }

Json map_json(const BallSigmaMap& map) {
  Json sigma_mm = Json::array();
  for (const auto& sigma : map.sigma_mm) sigma_mm.push_back(rounded(sigma.value_or(not_known), 100));
  return {{"columns", map.columns}, {"rows", map.rows}, {"sigma_mm", sigma_mm}};
}

Json fit_json(const BoardFit& fit) {
  Json said = {{"boards", fit.boards}, {"refused", fit.refused}, {"enough", fit.is_good_enough()}};
  if (!fit.calibration) return said;
  const BoardCalibration& found = *fit.calibration;
  said["model"] = lens_model_name(found.camera.parameters().model);
  said["rms_px"] = found.rms_px;
  said["ball_sigma_mm"] = found.ball_sigma_mm.value_or(not_known);
  said["covered_ball_sigma_mm"] = found.covered_ball_sigma_mm.value_or(not_known);
  said["lacks"] = fit.lacks;
  said["warnings"] = found.warnings;
  said["map"] = fit.map ? map_json(*fit.map) : Json();
  return said;
}

}  // namespace

BoardWorker::BoardWorker(std::vector<LensModel> models, std::function<void()> changed)
    : models_(std::move(models)),
      changed_(std::move(changed)),
      search_thread_([this] { search(); }),
      fit_thread_([this] { fit(); }) {}

BoardWorker::~BoardWorker() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  work_.notify_all();
  search_thread_.join();
  fit_thread_.join();
}

void BoardWorker::start(BoardLessons lessons) {
  const std::lock_guard lock(mutex_);
  ++run_;
  lessons_ = std::move(lessons);
  searches_ = true;
  searched_ = 0;
  wants_fit_ = fits_ = false;
  fit_.reset();
  newest_.reset();
}

void BoardWorker::go_on() {
  const std::lock_guard lock(mutex_);
  if (!lessons_) throw Refusal("no board is looked for: press Start");
  searches_ = true;
}

void BoardWorker::stop() {
  const std::lock_guard lock(mutex_);
  searches_ = false;
  newest_.reset();
}

void BoardWorker::undo() {
  const std::lock_guard lock(mutex_);
  if (!lessons_) throw Refusal("no board is looked for: press Start");
  lessons_->undo();
  want_fit();
}

/// Where there are too few boards there is no fit.
void BoardWorker::want_fit() {
  wants_fit_ = lessons_->taken().size() >= BoardFit::least_boards;
  if (!wants_fit_) fit_.reset();
  work_.notify_all();
}

void BoardWorker::show(const cv::Mat& bgr, Clock::time_point taken) {
  {
    const std::lock_guard lock(mutex_);
    if (!searches_) return;
    newest_ = Picture{bgr, taken};
  }
  work_.notify_all();
}

void BoardWorker::search() {
  give_way();
  std::unique_lock lock(mutex_);
  while (true) {
    work_.wait(lock, [this] { return ended_ || newest_; });
    if (ended_) return;
    const Picture picture = *std::exchange(newest_, std::nullopt);
    const std::uint64_t run = run_;
    const Board board = lessons_->board();
    lock.unlock();
    BoardFinding finding;
    try {
      finding = find_board(picture.bgr, board);
    } catch (const std::exception& error) {
      finding.reason = error.what();
    }
    lock.lock();
    if (run != run_ || !searches_) continue;
    ++searched_;
    const double time_s = std::chrono::duration<double>(picture.taken.time_since_epoch()).count();
    if (lessons_->look(std::move(finding), {picture.bgr.cols, picture.bgr.rows}, time_s) ==
        BoardLessons::Seen::taken)
      want_fit();
    changed_();
  }
}

void BoardWorker::fit() {
  give_way();
  std::unique_lock lock(mutex_);
  while (true) {
    work_.wait(lock, [this] { return ended_ || wants_fit_; });
    if (ended_) return;
    wants_fit_ = false;
    fits_ = true;
    const std::uint64_t run = run_;
    const BoardLessons lessons = *lessons_;
    lock.unlock();
    auto fit = std::make_shared<const BoardFit>(fit_boards(lessons.size(), lessons.taken(), models_));
    lock.lock();
    if (run != run_) continue;
    fits_ = false;
    if (lessons_->taken().size() >= BoardFit::least_boards) fit_ = std::move(fit);
    changed_();
  }
}

Json BoardWorker::state() const {
  const std::lock_guard lock(mutex_);
  if (!lessons_) return {{"on", false}};
  Json corners_px = Json::array();
  if (searches_ && lessons_->newest()) {
    for (const Eigen::Vector2d& corner : lessons_->newest()->corners_px)
      corners_px.push_back({rounded(corner.x()), rounded(corner.y())});
  }
  const std::vector<BoardView>& taken = lessons_->taken();
  Json said = {{"on", searches_},
               {"board", lessons_->board_text()},
               {"square_m", lessons_->board().square_m},
               {"corners_px", corners_px},
               {"said", searches_ ? lessons_->words() : ""},
               {"seen", lessons_->newest().has_value()},
               {"searched", searched_},
               {"taken", taken.size()},
               {"needed", BoardFit::least_boards},
               {"fitting", wants_fit_ || fits_},
               {"fit", fit_ ? fit_json(*fit_) : Json()},
               {"next", nullptr}};
  if (searches_ && lessons_->size().width_px > 0) {
    const BoardHint hint = next_board(lessons_->board(), lessons_->size(), taken, fit_.get());
    Json outline_px = Json::array();
    for (const Eigen::Vector2d& corner : hint.outline_px)
      outline_px.push_back({rounded(corner.x()), rounded(corner.y())});
    said["next"] = {{"place_px", {rounded(hint.place_px.x()), rounded(hint.place_px.y())}},
                    {"outline_px", outline_px},
                    {"words", hint.words}};
  }
  return said;
}

BoardCalibration BoardWorker::calibration() const {
  const std::lock_guard lock(mutex_);
  const std::size_t taken = lessons_ ? lessons_->taken().size() : 0;
  if (taken < BoardFit::least_boards)
    throw Refusal(fmt::format("{} pictures of the board are taken: {} are the least, 10 settle a lens", taken,
                              BoardFit::least_boards));
  if (wants_fit_ || fits_ || !fit_)
    throw Refusal("the camera is still being fitted: press again in a moment");
  if (!fit_->calibration) throw Refusal(fit_->refused);
  return *fit_->calibration;
}

}  // namespace ballservo
