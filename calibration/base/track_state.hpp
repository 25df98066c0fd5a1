// How a ball is known in one picture: one set of names for perception, servo and the result files.
#pragma once

#include <string_view>

namespace ballservo {

enum class TrackState {
  none,       ///< not at all
  tentative,  ///< seen, not yet often enough to be believed
  confirmed,  ///< seen and believed
  coasting    ///< not seen; predicted from when it was
};

/// "none", "tentative", "confirmed", "coasting".
constexpr std::string_view track_state_name(TrackState state) {
  constexpr std::string_view names[]{"none", "tentative", "confirmed", "coasting"};
  return names[static_cast<int>(state)];
}

}  // namespace ballservo
