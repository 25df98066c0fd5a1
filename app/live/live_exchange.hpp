// Where a session, which makes pictures and takes commands, and the server, which has clients, meet.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <set>
#include <string>
#include <vector>

namespace ballservo {

/// What a session shows of one moment.
struct LiveMoment {
  std::uint64_t serial = 0;
  std::string state;                            ///< JSON
  std::chrono::steady_clock::time_point taken;  ///< when its picture was
  /// The picture of a view, or an empty one for a view that there is not. May be called on any one thread;
  /// what it holds is no longer changed.
  std::function<cv::Mat(const std::string& view)> draw;
  std::string line;  ///< for programs that read the stream; may be empty
};

/// A time of the steady clock, s.
inline double seconds_of(std::chrono::steady_clock::duration time) {
  return std::chrono::duration<double>(time).count();
}
inline std::chrono::steady_clock::duration duration_of(double time_s) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(time_s));
}

/// What those look at who read the stream.
inline constexpr const char* stream_view = "stream";

/// What a client asks of the session; `answer` may be called on any thread, and again for what comes later.
struct LiveCommand {
  nlohmann::json what;
  std::function<void(nlohmann::json)> answer;
};

/// Neither side ever waits for the other. Thread-safe.
class LiveExchange {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds idle{100};  ///< for which a session waits that has nothing to do
  static constexpr std::size_t most_waiting = 64;        ///< commands
  static constexpr std::size_t most_at_once = 8;         ///< of them, so that a flood holds no picture up

  /// The session's side. The moment replaces the last one; its serial is returned.
  std::uint64_t publish(nlohmann::json state, Clock::time_point taken,
                        std::function<cv::Mat(const std::string&)> draw, std::string line = {});
  std::vector<LiveCommand> next_commands();  ///< those that wait, the first ones first
  /// Until there is a command, `wake` is called, or it is that late.
  void wait_until(Clock::time_point time);
  void wake();
  bool is_looked_at(const std::string& view) const;

  /// The server's side. `on_publish` is called on the session's thread.
  void set_on_publish(std::function<void()> on_publish);
  std::shared_ptr<const LiveMoment> newest() const;  ///< null before the first
  bool put(LiveCommand command);                     ///< false where too many wait
  void set_views(std::set<std::string> views);       ///< that some client looks at

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<const LiveMoment> newest_;
  std::vector<LiveCommand> commands_;
  std::set<std::string> views_;
  std::function<void()> on_publish_;
  std::uint64_t serial_ = 0;
  bool awake_ = false;
};

}  // namespace ballservo
