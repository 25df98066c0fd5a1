// Progress of long work on stderr: a bar on a terminal, plain lines every few seconds otherwise.
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace ballservo {

/// Time left (s) by the rate so far; none where too little is done to say: the first pieces are slow.
std::optional<double> time_left_s(double elapsed_s, long done, long total);

class Progress {
 public:
  /// `total` 0: unknown. Nothing is ever shown when `quiet`, nor before the first second has passed.
  Progress(std::string what, long total, bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void step(long done);  ///< `done` of `total` so far

 private:
  std::string what_;
  long total_ = 0;
  bool quiet_ = false, terminal_ = false, shown_ = false;
  std::chrono::steady_clock::time_point start_, last_;
};

}  // namespace ballservo
