#include "servo/control/control_states.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <tuple>
#include <vector>

namespace ballservo {
namespace {

constexpr std::size_t first_guard = static_cast<std::size_t>(Finding::moves);

Findings only(std::initializer_list<Finding> list) {
  Findings findings;
  for (const Finding finding : list) findings.add(finding);
  return findings;
}

TEST(ControlStates, TheGuideShowsTheTableThatTheControllerRunsBy) {
  std::ifstream file(BALLSERVO_SERVO_GUIDE);
  ASSERT_TRUE(file) << BALLSERVO_SERVO_GUIDE;
  std::ostringstream guide;
  guide << file.rdbuf();
  EXPECT_NE(guide.str().find("\n" + transition_table() + "\n"), std::string::npos)
      << "servo/README.md should hold this table:\n\n"
      << transition_table();
}

TEST(ControlStates, EveryFindingHasItsWords) {
  std::set<std::string_view> texts;
  for (std::size_t k = 1; k < finding_count; ++k) {
    const std::string_view text = finding_text(static_cast<Finding>(k));
    EXPECT_FALSE(text.empty()) << k;
    EXPECT_TRUE(texts.insert(text).second) << text;
  }
}

TEST(ControlStates, StartsWithASearchAndStaysWhereNothingIsFound) {
  ControlStates states(true);
  EXPECT_EQ(states.state(), ControlState::search);
  EXPECT_EQ(states.react({}, 1.0), nullptr);
  EXPECT_EQ(states.state(), ControlState::search);
  EXPECT_EQ(states.reason(), "start: looking for the ball");
}

// Whatever is found in whatever order, from the start on.
TEST(ControlStates, EveryStateAndEveryTransitionCanComeAbout) {
  struct Place {
    ControlStates states;
    bool followed = false;
  };
  std::set<const Transition*> taken;
  std::set<ControlState> visited;
  for (const bool finds_ways : {false, true}) {
    std::vector<Place> places{{ControlStates(finds_ways)}};
    std::set<std::tuple<ControlState, ControlState, bool>> known;
    for (std::size_t at = 0; at < places.size(); ++at) {
      for (std::size_t event = 1; event < first_guard; ++event) {
        for (const bool no_place : {false, true}) {
          Place place = places[at];
          Findings findings = only({static_cast<Finding>(event)});
          findings.add(Finding::no_place_left, no_place);
          const Transition* transition = place.states.react(findings, 0);
          if (transition == nullptr) continue;
          taken.insert(transition);
          visited.insert(place.states.state());
          place.followed |= transition->effect == Effect::trust;
          if (known.insert({place.states.state(), place.states.activity(), place.followed}).second) {
            places.push_back(place);
          }
        }
      }
    }
  }
  const std::string table = transition_table();
  EXPECT_EQ(taken.size(), static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n')) - 2);
  EXPECT_EQ(visited.size(), control_state_count);
}

TEST(ControlStates, NonsenseStopsInEveryState) {
  for (const Finding bad : {Finding::bad_clock, Finding::bad_measurement, Finding::bad_command}) {
    for (const Finding first : {Finding::seen_now, Finding::no_frames, Finding::turned_around}) {
      ControlStates states(true);
      states.react(only({first}), 0);
      states.react(only({bad, Finding::trusted, Finding::seen_now}), 1);
      EXPECT_EQ(states.state(), ControlState::fault);
    }
  }
}

TEST(ControlStates, BlockedGoesOnWithWhatItInterrupted) {
  ControlStates states(true);
  states.react(only({Finding::seen_now}), 0);
  states.react(only({Finding::trusted}), 0);
  ASSERT_EQ(states.state(), ControlState::approach);
  states.react(only({Finding::stuck}), 1);
  EXPECT_EQ(states.state(), ControlState::blocked);
  EXPECT_EQ(states.activity(), ControlState::approach);
  EXPECT_EQ(states.react(only({Finding::stuck}), 2), nullptr);
  EXPECT_EQ(states.react(only({Finding::arrived}), 2), nullptr) << "it does not stand by its own will";
  states.react(only({Finding::unstuck}), 3);
  EXPECT_EQ(states.state(), ControlState::approach);
  EXPECT_EQ(states.reason(), "going on");
}

TEST(ControlStates, ALostBallCountsAndIsReturnedToOnlyWhereWaysAreLookedFor) {
  for (const bool finds_ways : {false, true}) {
    ControlStates states(finds_ways);
    states.react(only({Finding::seen_now}), 0);
    states.react(only({Finding::trusted}), 0);
    states.react(only({Finding::unseen}), 1);
    EXPECT_EQ(states.state(), finds_ways ? ControlState::reacquire : ControlState::lost);
    EXPECT_EQ(states.lost_events(), 1);
  }
}

}  // namespace
}  // namespace ballservo
