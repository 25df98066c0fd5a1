// What can go wrong with what a user gives us, and how it is said.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace ballservo {

/// One thing that is wrong with an input: where, what was found there, and what is allowed.
struct Fault {
  std::string place;    ///< file, with line and key where known: "scene.yaml:12: camera.rate_hz"
  std::string found;    ///< what stands there: "-30"
  std::string allowed;  ///< what may stand there: "a number above 0 (Hz)"
};

/// "place: found FOUND; allowed: ALLOWED", the one form in which faults are shown.
std::string to_text(const Fault& fault);

/// Bad usage or bad input; the program exits with 2 and prints each fault on a line of its own.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::vector<Fault> faults);
  InputError(std::string place, std::string found, std::string allowed);

  const std::vector<Fault>& faults() const { return faults_; }

 private:
  std::vector<Fault> faults_;
};

/// Everything was well formed, but the answer is no (no board found, nothing to learn); the program exits
/// with 1.
class Refusal : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Collects faults so that a user sees all of them at once.
class FaultList {
 public:
  void add(std::string place, std::string found, std::string allowed);
  /// Calls, and takes over the faults of an InputError: the next thing is looked at all the same.
  template <class Call>
  void collect(const Call& call) {
    try {
      call();
    } catch (const InputError& error) {
      faults_.insert(faults_.end(), error.faults().begin(), error.faults().end());
    }
  }
  bool empty() const { return faults_.empty(); }
  const std::vector<Fault>& faults() const { return faults_; }
  /// Throws InputError with all faults collected so far, if there are any.
  void throw_if_any() const;

 private:
  std::vector<Fault> faults_;
};

/// A fault at `place` unless the value lies from `low` to `high`.
void check_range(FaultList& faults, const std::string& place, double value, double low, double high);

}  // namespace ballservo
