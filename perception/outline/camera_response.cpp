#include "perception/outline/camera_response.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

const CameraResponse& CameraResponse::linear() {
  static const CameraResponse response = [] {
    CameraResponse made;
    for (std::size_t k = 0; k < 256; ++k) made.light[k] = static_cast<float>(k), made.slope[k] = 1;
    return made;
  }();
  return response;
}

const CameraResponse& CameraResponse::srgb() {
  static const CameraResponse response = [] {
    CameraResponse made;
    for (std::size_t k = 0; k < 256; ++k) {
      const double level = static_cast<double>(k) / 255;
      const bool dark = level <= 0.04045;
      const double base = (level + 0.055) / 1.055;
      made.light[k] = static_cast<float>(255 * (dark ? level / 12.92 : std::pow(base, 2.4)));
      made.slope[k] = static_cast<float>(dark ? 1 / 12.92 : 2.4 / 1.055 * std::pow(base, 1.4));
    }
    return made;
  }();
  return response;
}

namespace {

constexpr double clear_evidence = 6, settled_evidence = 30, most_of_one_ball = 20;
constexpr int most_looks = 64;

}  // namespace

void ResponseBelief::add(double evidence) {
  evidence_ += std::clamp(evidence, -most_of_one_ball, most_of_one_ball);
  ++looks_;
}

bool ResponseBelief::open() const { return std::abs(evidence_) < settled_evidence && looks_ < most_looks; }

const CameraResponse& ResponseBelief::likelier() const {
  return evidence_ > clear_evidence ? CameraResponse::srgb() : CameraResponse::linear();
}

}  // namespace ballservo
