// Threads that share the rows of a picture, and wait between pictures.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace ballservo {

/// Takes memory and starts its threads on construction alone. One caller at a time.
class RowTeam {
 public:
  /// `threads` in all, the caller's own among them; 1 starts none.
  explicit RowTeam(int threads);
  ~RowTeam();
  RowTeam(const RowTeam&) = delete;
  RowTeam& operator=(const RowTeam&) = delete;

  int threads() const { return static_cast<int>(helpers_.size()) + 1; }

  /// Cuts `rows` into one band for each thread, alike to a row, calls work(first, end) for each at the same
  /// time, and returns when all are done. `work` must not throw.
  template <class Work>
  void run(int rows, const Work& work) {
    run(
        rows,
        [](const void* the_work, int first, int end) { (*static_cast<const Work*>(the_work))(first, end); },
        &work);
  }

 private:
  using Call = void (*)(const void* work, int first, int end);
  void run(int rows, Call call, const void* work);
  void do_band(int band) const;
  void help(int band);

  std::vector<std::thread> helpers_;
  std::mutex mutex_;
  std::condition_variable begun_, ended_;
  long round_ = 0;  // of work, so that a helper knows a new one from the one that it has done
  int busy_ = 0;    // helpers that have not ended this round
  bool closed_ = false;
  int rows_ = 0;
  Call call_ = nullptr;
  const void* work_ = nullptr;
};

}  // namespace ballservo
