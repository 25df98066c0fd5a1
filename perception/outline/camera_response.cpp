#include "perception/outline/camera_response.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

namespace {

CameraResponse linear_response() {
  CameraResponse made;
  for (std::size_t k = 0; k < 256; ++k) made.light[k] = static_cast<float>(k), made.slope[k] = 1;
  return made;
}

CameraResponse srgb_response() {
  CameraResponse made;
  for (std::size_t k = 0; k < 256; ++k) {
    const double level = static_cast<double>(k) / 255;
    const bool dark = level <= 0.04045;
    const double base = (level + 0.055) / 1.055;
    made.light[k] = static_cast<float>(255 * (dark ? level / 12.92 : std::pow(base, 2.4)));
    made.slope[k] = static_cast<float>(dark ? 1 / 12.92 : 2.4 / 1.055 * std::pow(base, 1.4));
  }
  return made;
}

CameraResponse coarse(CameraResponse response) {
  response.coarse_chroma = true;
  return response;
}

// One picture counts no more than that. Beyond `settled` no picture could turn the belief at once.
constexpr double most_of_one_picture = 20, settled_response = 30, settled_chroma = 30;
constexpr int most_looks = 64;
// What one camera's pictures carry over to the next still: less than a clear picture's own edges say.
constexpr double carried = 8, carried_chroma = 2;

}  // namespace

const CameraResponse& CameraResponse::linear(bool coarse_chroma) {
  static const CameraResponse fine = linear_response(), with_coarse = coarse(fine);
  return coarse_chroma ? with_coarse : fine;
}

const CameraResponse& CameraResponse::srgb(bool coarse_chroma) {
  static const CameraResponse fine = srgb_response(), with_coarse = coarse(fine);
  return coarse_chroma ? with_coarse : fine;
}

float CameraResponse::level(float of_light) const {
  const auto above = std::lower_bound(light.begin(), light.end() - 1, of_light);
  const auto at = static_cast<std::size_t>(above - light.begin());
  return static_cast<float>(at) + (of_light - light[at]) / slope[at];
}

// Coarse colours look like a linear response: edges that show them say nothing of it.
void ResponseBelief::add(const ResponseEvidence& evidence) {
  const auto capped = [](double x) { return std::clamp(x, -most_of_one_picture, most_of_one_picture); };
  coarse_chroma_ += capped(evidence.coarse_chroma);
  if (evidence.coarse_chroma <= 0) srgb_ += capped(evidence.srgb);
  ++looks_;
}

bool ResponseBelief::open() const {
  const bool settled = coarse_chroma_ >= settled_chroma ||
                       (coarse_chroma_ <= -settled_chroma && std::abs(srgb_) >= settled_response);
  return !settled && looks_ < most_looks;
}

void ResponseBelief::doubt() {
  srgb_ = std::clamp(srgb_, prior - carried, prior + 2);
  coarse_chroma_ = std::clamp(coarse_chroma_, -carried_chroma, carried_chroma);
  looks_ = 0;
}

}  // namespace ballservo
