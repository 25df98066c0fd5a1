#include "app/live/board_worker.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "app/live/client_words.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/statistics.hpp"
#include "calibration/boards/board_detector.hpp"

namespace ballservo {
namespace {

using Json = nlohmann::json;

Json map_json(const BallSigmaMap& map) {
  Json sigma_mm = Json::array();
  for (const auto& sigma : map.sigma_mm)
    sigma_mm.push_back(std::round(100 * sigma.value_or(not_known)) / 100);
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
    : models_(std::move(models)), changed_(std::move(changed)) {}

void BoardWorker::start(BoardLessons lessons) {
  const std::lock_guard lock(mutex_);
  ++run_;
  lessons_ = std::move(lessons);
  searches_ = true;
  searched_ = 0;
  fits_ = false;
  fit_.reset();
}

void BoardWorker::go_on() {
  const std::lock_guard lock(mutex_);
  if (!lessons_) throw Refusal("no board is looked for: press Start");
  searches_ = true;
}

void BoardWorker::stop() {
  const std::lock_guard lock(mutex_);
  searches_ = false;
}

void BoardWorker::undo() {
  const std::lock_guard lock(mutex_);
  if (!lessons_) throw Refusal("no board is looked for: press Start");
  lessons_->undo();
  want_fit();
}

/// Where there are too few boards there is no fit.
void BoardWorker::want_fit() {
  fits_ = lessons_->taken().size() >= BoardFit::least_boards;
  if (!fits_) return fit_.reset();
  fitter_.ask([this, run = run_, number = ++fits_asked_, lessons = *lessons_] {
    auto fit = std::make_shared<const BoardFit>(fit_boards(lessons.size(), lessons.taken(), models_));
    const std::lock_guard lock(mutex_);
    if (run != run_) return;
    if (number == fits_asked_) fits_ = false;
    if (lessons_->taken().size() >= BoardFit::least_boards) fit_ = std::move(fit);
    changed_();
  });
}

void BoardWorker::show(const cv::Mat& bgr, Clock::time_point taken) {
  const std::lock_guard held(mutex_);
  if (!searches_) return;
  searcher_.ask([this, bgr, taken, run = run_, board = lessons_->board()] {
    BoardFinding finding;
    try {
      finding = find_board(bgr, board);
    } catch (const std::exception& error) {
      finding.reason = error.what();
    }
    const std::lock_guard lock(mutex_);
    if (run != run_ || !searches_) return;
    ++searched_;
    const double time_s = seconds_of(taken.time_since_epoch());
    if (lessons_->look(std::move(finding), {bgr.cols, bgr.rows}, time_s) == BoardLessons::Seen::taken)
      want_fit();
    changed_();
  });
}

Json BoardWorker::state() const {
  const std::lock_guard lock(mutex_);
  if (!lessons_) return {{"on", false}};
  const std::vector<BoardView>& taken = lessons_->taken();
  Json said = {{"on", searches_},
               {"board", lessons_->board_text()},
               {"square_m", lessons_->board().square_m},
               {"corners_px", Json::array()},
               {"said", searches_ ? lessons_->words() : ""},
               {"seen", lessons_->newest().has_value()},
               {"searched", searched_},
               {"taken", taken.size()},
               {"needed", BoardFit::least_boards},
               {"fitting", fits_},
               {"fit", fit_ ? fit_json(*fit_) : Json()},
               {"next", nullptr}};
  if (searches_ && lessons_->newest()) said["corners_px"] = points_px_json(lessons_->newest()->corners_px);
  if (searches_ && lessons_->size().width_px > 0) {
    const BoardHint hint = next_board(lessons_->board(), lessons_->size(), taken, fit_.get());
    said["next"] = {{"place_px", points_px_json({hint.place_px}).front()},
                    {"outline_px", points_px_json(hint.outline_px)},
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
  if (fits_ || !fit_) throw Refusal("the camera is still being fitted: press again in a moment");
  if (!fit_->calibration) throw Refusal(fit_->refused);
  return *fit_->calibration;
}

}  // namespace ballservo
