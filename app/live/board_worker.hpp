// Calibration while pictures run: the newest is searched for a board, and a camera is fitted to those taken,
// each on a thread of its own.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "app/live/board_lessons.hpp"
#include "app/live/newest_job.hpp"

namespace ballservo {

/// Nothing here waits for a search or a fit but the end of it. Thread-safe.
class BoardWorker {
 public:
  using Clock = std::chrono::steady_clock;

  /// Among `models` the fit chooses. `changed` is called on a thread of the worker's.
  BoardWorker(std::vector<LensModel> models, std::function<void()> changed);

  /// Begins anew.
  void start(BoardLessons lessons);
  /// Goes on where it was stopped. Throws Refusal where nothing was begun.
  void go_on();
  /// Searches no further; what was taken stays.
  void stop();
  /// Throws Refusal where nothing has been taken.
  void undo();
  /// The newest picture; one that has not been looked at yet is not any more.
  void show(const cv::Mat& bgr, Clock::time_point taken);
  /// What the page shows: see README.md.
  nlohmann::json state() const;
  /// The camera of all that was taken. Throws Refusal where there is none, or it is still being fitted.
  BoardCalibration calibration() const;

 private:
  void want_fit();

  const std::vector<LensModel> models_;
  const std::function<void()> changed_;
  mutable std::mutex mutex_;
  bool searches_ = false, fits_ = false;
  std::uint64_t run_ = 0;  // `start` counts it: what comes of an earlier one is dropped
  std::uint64_t fits_asked_ = 0;
  long searched_ = 0;  // pictures of this run
  std::optional<BoardLessons> lessons_;
  std::shared_ptr<const BoardFit> fit_;
  NewestJob fitter_, searcher_;  // last: they use all of the above, and the search asks for fits
};

}  // namespace ballservo
