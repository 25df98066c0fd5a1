// What the controller is about, and why it changes that: its state machine, as one table.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace ballservo {

/// search: no ball yet, look and then turn. explore: not found by turning, drive to another place and look
/// from there. acquire: seen, stand until it is confirmed. approach: the law drives, around obstacles where
/// there are any. hold: arrived, stand. reacquire: out of sight, drive to where it was last. blocked: no way
/// on, look around and back up. lost: stop, and say so. given_up: a search has ended without the ball. stale:
/// no frames, stop. fault: something that is not finite came in, stop.
enum class ControlState {
  search,
  explore,
  acquire,
  approach,
  hold,
  reacquire,
  blocked,
  lost,
  given_up,
  stale,
  fault
};
inline constexpr std::size_t control_state_count = 11;
std::string_view control_state_name(ControlState state);

/// What a control step finds: the events of the table and the conditions that guard them.
enum class Finding : unsigned {
  always,
  bad_clock,
  bad_measurement,
  bad_command,
  no_frames,
  frames,
  seen_now,
  seen,
  unseen,
  trusted,
  untrusted,
  unconfirmed,
  stands,
  turned_around,
  arrived_there,
  out_of_time,
  arrived,
  off_goal,
  nothing_known,
  not_there,
  stuck,
  unstuck,
  // guards
  moves,
  is_blocked,
  no_place_left,
  followed,
  can_return,
};
inline constexpr std::size_t finding_count = static_cast<std::size_t>(Finding::can_return) + 1;
/// In the words of the documentation's table.
std::string_view finding_text(Finding finding);

/// Several findings at once; `always` is one of them.
class Findings {
 public:
  Findings() = default;
  Findings(Finding finding) { add(finding); }  // NOLINT: one is several
  void add(Finding finding, bool holds = true) {
    if (holds) bits_.set(static_cast<std::size_t>(finding));
  }
  bool has(Finding finding) const { return bits_[static_cast<std::size_t>(finding)]; }

 private:
  std::bitset<finding_count> bits_{1u << static_cast<unsigned>(Finding::always)};
};

/// What a transition brings about besides the state.
enum class Effect { none, begin_turn, resume_turn, pass_over, set_out, trust, lose };

/// A set of states.
using StateSet = std::uint16_t;

/// A row of the table: in one of the states `from`, when `event` and `guard` hold, the state becomes `next`.
struct Transition {
  StateSet from;
  Finding event, guard;
  ControlState next;  ///< `blocked` keeps in mind what it interrupts, and `unstuck` goes on with that
  std::string_view reason;
  Effect effect = Effect::none;
};

/// The table as Markdown, as servo/README.md shows it.
std::string transition_table();

/// The state of one controller. `blocked` is not an activity of its own: it interrupts one.
class ControlStates {
 public:
  /// `finds_ways`: whether ways around obstacles are looked for.
  explicit ControlStates(bool finds_ways) : finds_ways_(finds_ways) {}

  /// The run begins.
  void start(double time_s) { since_s_ = time_s; }

  /// Takes the first transition of the table that these findings allow; null where none is.
  const Transition* react(Findings findings, double time_s);
  /// The state stays, for another reason; a literal.
  void explain(std::string_view reason) { reason_ = reason; }

  ControlState state() const { return blocked_ ? ControlState::blocked : activity_; }
  /// The state, or what `blocked` interrupts: explore, approach or reacquire.
  ControlState activity() const { return activity_; }
  bool blocked() const { return blocked_; }
  std::string_view reason() const { return reason_; }
  double since_s() const { return since_s_; }       ///< of the activity
  int lost_events() const { return lost_events_; }  ///< so far

 private:
  bool finds_ways_;
  ControlState activity_ = ControlState::search;
  bool blocked_ = false, followed_ = false;
  std::string_view reason_ = "start: looking for the ball";
  double since_s_ = 0;
  int lost_events_ = 0;
};

}  // namespace ballservo
