// How each peer is set up, and which settings a user would try.
#pragma once

#include <string>
#include <vector>

#include "app/comparison/estimators/opencv_peers.hpp"
#include "app/comparison/estimators/vpdot2_peer.hpp"

namespace ballservo {

struct PeerSettings {
  HoughSettings hough{HoughMode::gradient, 100, 20};
  HoughSettings hough_alt{HoughMode::gradient_alt, 300, 0.8};
  HsvSettings hsv;
  VpDot2Settings vpdot2;
};

/// The small grids that the best settings of each peer are chosen from, on other frames than it is measured
/// on.
const std::vector<HoughSettings>& hough_grid(HoughMode mode);
const std::vector<HsvSettings>& hsv_grid();
const std::vector<VpDot2Settings>& vpdot2_grid();

/// "param1 100, param2 20", in the words of the peer's own interface.
std::string in_words(const HoughSettings& settings);
std::string in_words(const HsvSettings& settings);
std::string in_words(const VpDot2Settings& settings);
std::string in_words(const PeerSettings& settings);

}  // namespace ballservo
