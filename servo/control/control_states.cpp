#include "servo/control/control_states.hpp"

#include <array>

namespace ballservo {

namespace {

constexpr std::array<std::string_view, control_state_count> state_names{
    "search",  "explore", "acquire",  "approach", "hold", "reacquire",
    "blocked", "lost",    "given_up", "stale",    "fault"};

constexpr std::array<std::string_view, finding_count> finding_texts{
    "",
    "time or odometry is not finite or does not advance",
    "a measurement is not finite",
    "a command is not finite",
    "no frame for latency + 0.2 s",
    "frames arrive",
    "the ball was seen within 0.25 s",
    "the ball was seen within 0.6 s",
    "the ball was not seen within 0.6 s",
    "three confirmed sightings in a row",
    "fewer than three confirmed sightings in a row",
    "not seen for 0.5 s, or not confirmed within 2 s",
    "at rest for 0.4 s",
    "turned all around, or no turn possible",
    "at the other place",
    "15 s under way, or no way leads there",
    "at rest at the goal, the ball too: 0.4 mm, 0.4 mrad",
    "2.5 mm or 2.5 mrad off the goal, or the ball moves",
    "no place of the ball is known",
    "not seen for 0.4 s where it should be, or for 30 s",
    "steering finds no way on",
    "steering goes on",
    "not blocked",
    "blocked",
    "no excursion left",
    "the ball was followed before",
    "the ball was followed before, and ways are looked for",
};

constexpr StateSet set(ControlState state) {
  return static_cast<StateSet>(1u << static_cast<unsigned>(state));
}
template <typename... Others>
constexpr StateSet set(ControlState state, Others... others) {
  return static_cast<StateSet>(set(state) | set(others...));
}
constexpr StateSet any = (1u << control_state_count) - 1;

using S = ControlState;
using F = Finding;

// The first row that holds is taken. A step asks three times: `bad_clock` before all else, `stuck` and
// `unstuck` when steering has answered, `bad_command` when the drive's limits have been applied, everything
// else between.
constexpr Transition transitions[] = {
    {any, F::bad_clock, F::always, S::fault, "time or odometry is not finite or does not advance"},
    {any, F::bad_command, F::always, S::fault, "a command was not finite"},
    {any, F::bad_measurement, F::always, S::fault, "a measurement is not finite"},
    {any & ~set(S::given_up), F::no_frames, F::always, S::stale, "no frames from the camera"},

    {set(S::reacquire), F::seen_now, F::always, S::acquire, "the ball is back: stand until it is confirmed"},
    {set(S::explore), F::seen_now, F::is_blocked, S::acquire,
     "the ball is back: stand until it is confirmed"},
    {set(S::search, S::explore, S::lost, S::given_up), F::seen_now, F::always, S::acquire,
     "a ball is seen: stand until it is confirmed"},

    {set(S::search), F::turned_around, F::no_place_left, S::given_up,
     "turned all around without seeing the ball"},
    {set(S::search), F::turned_around, F::always, S::explore,
     "not here: driving to another place to look from", Effect::set_out},
    {set(S::explore), F::arrived_there, F::moves, S::search, "at another place: turning to look from here",
     Effect::begin_turn},
    {set(S::explore), F::out_of_time, F::moves, S::search, "at another place: turning to look from here",
     Effect::begin_turn},
    {set(S::explore), F::out_of_time, F::is_blocked, S::search, "no way on: turning to look from here",
     Effect::begin_turn},

    {set(S::acquire, S::stale, S::fault), F::trusted, F::always, S::approach,
     "the ball is confirmed: driving to it", Effect::trust},
    {set(S::acquire), F::unconfirmed, F::can_return, S::reacquire,
     "out of sight: driving to where it was last", Effect::lose},
    {set(S::acquire), F::unconfirmed, F::always, S::search, "what was seen was not confirmed",
     Effect::pass_over},

    {set(S::approach, S::hold), F::unseen, F::can_return, S::reacquire,
     "out of sight: driving to where it was last", Effect::lose},
    {set(S::approach, S::hold), F::unseen, F::always, S::lost,
     "the ball has not been seen for too long: stopped", Effect::lose},
    {set(S::approach, S::hold), F::untrusted, F::always, S::acquire,
     "the track began anew: stand until it is confirmed"},
    {set(S::approach), F::arrived, F::moves, S::hold, "arrived: standing at the goal"},
    {set(S::hold), F::off_goal, F::always, S::approach, "off the goal: correcting"},

    {set(S::reacquire), F::nothing_known, F::always, S::lost, "nothing is remembered of the ball"},
    {set(S::reacquire), F::not_there, F::always, S::lost, "not where it was last: stopped"},
    {set(S::lost), F::stands, F::always, S::search, "not seen again: turning towards where it went",
     Effect::begin_turn},

    {set(S::stale, S::fault), F::seen, F::always, S::acquire,
     "frames are good again: stand until the ball is confirmed"},
    {set(S::stale, S::fault), F::frames, F::can_return, S::reacquire,
     "out of sight: driving to where it was last", Effect::lose},
    {set(S::stale, S::fault), F::frames, F::followed, S::lost,
     "frames are good again, but the ball is not in them: stopped", Effect::lose},
    {set(S::stale, S::fault), F::frames, F::always, S::search, "frames are good again: looking for the ball",
     Effect::resume_turn},

    {set(S::explore, S::approach, S::reacquire), F::stuck, F::moves, S::blocked, "as steering says"},
    {set(S::explore, S::approach, S::reacquire), F::unstuck, F::is_blocked, S::blocked, "going on"},
};

std::string names_of(StateSet states) {
  if (states == any) return "any";
  if (states == (any & ~set(S::given_up))) return "any but given_up";
  std::string names;
  for (std::size_t k = 0; k < control_state_count; ++k) {
    if ((states & (1u << k)) != 0) names += (names.empty() ? "" : ", ") + std::string(state_names[k]);
  }
  return names;
}

}  // namespace

std::string_view control_state_name(ControlState state) {
  return state_names[static_cast<std::size_t>(state)];
}

std::string_view finding_text(Finding finding) { return finding_texts[static_cast<std::size_t>(finding)]; }

std::string transition_table() {
  std::string table = "| state | event | if | next | reason |\n|---|---|---|---|---|\n";
  for (const Transition& row : transitions) {
    const bool back = row.event == Finding::unstuck;
    table += "| " + names_of(row.from) + " | " + std::string(finding_text(row.event)) + " | " +
             std::string(finding_text(row.guard)) + " | " +
             (back ? "as before" : std::string(control_state_name(row.next))) + " | " +
             std::string(row.reason) + " |\n";
  }
  return table;
}

const Transition* ControlStates::react(Findings findings, double time_s) {
  findings.add(blocked_ ? Finding::is_blocked : Finding::moves);
  findings.add(Finding::followed, followed_);
  findings.add(Finding::can_return, followed_ && finds_ways_);
  for (const Transition& row : transitions) {
    if ((row.from & set(activity_)) == 0 || !findings.has(row.event) || !findings.has(row.guard)) continue;
    blocked_ = row.event == Finding::stuck;
    if (row.next != ControlState::blocked && row.next != activity_) {
      activity_ = row.next;
      since_s_ = time_s;
    }
    reason_ = row.reason;
    followed_ |= row.effect == Effect::trust;
    lost_events_ += row.effect == Effect::lose ? 1 : 0;
    return &row;
  }
  return nullptr;
}

}  // namespace ballservo
