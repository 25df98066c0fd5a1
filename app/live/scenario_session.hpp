// A session over a scenario: its run at the wall's pace, and what is done to it.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "app/experiment/runner.hpp"
#include "app/live/live_exchange.hpp"

namespace ballservo {

struct ScenarioSessionOptions {
  PerceptionLevel perception = PerceptionLevel::image;
  std::shared_ptr<const ColorTable> colors;  ///< for level image
  /// Receives each run that has ended, and what was done to it; may be empty.
  std::function<void(const RunRecord& run, const Touches& touches)> keep;
  double trail_s = 60;  ///< of the robot's way that is shown
};

/// Runs on the caller's thread; clients' commands are done between two control steps.
class ScenarioSession {
 public:
  ScenarioSession(Scenario scenario, ScenarioSessionOptions options, LiveExchange& exchange);
  ~ScenarioSession();

  /// One run after the other, until a client ends it or the user interrupts.
  void run();
  long runs() const { return runs_; }

 private:
  using Clock = LiveExchange::Clock;
  using Json = nlohmann::json;
  class Eye;

  void run_once();
  std::vector<Touch> between_steps(const RunView& now);
  void obey_all(const RunView* now);
  Json done(const Json& what, const RunView* now);
  void touch(const Json& what, const RunView& now);
  Json state(const RunView& now) const;
  void show(const RunView& now);
  void publish();
  void draw_later(const RunView& now);
  void show_late_picture();
  bool goes_on() const;
  std::size_t trail_steps() const;

  Scenario scenario_;  // as it was before anybody touched it
  ScenarioSessionOptions options_;
  LiveExchange& exchange_;
  Touches touches_;         // of this run
  std::vector<Touch> due_;  // since its last step
  double noise_ = 1, light_ = 1, speed_ = 1;
  bool paused_ = false, step_ = false, reset_ = false, ended_ = false;
  Clock::time_point pace_start_, shown_at_, pictured_at_;
  double pace_start_s_ = 0;
  std::function<cv::Mat()> picture_;    // what the camera saw, with what was made of it
  std::shared_ptr<const World> world_;  // as it is now
  std::shared_ptr<Eye> eye_;
  Json state_;
  long runs_ = 0;
};

}  // namespace ballservo
