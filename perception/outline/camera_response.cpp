#include "perception/outline/camera_response.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

CameraResponse response_of(bool srgb, bool coarse_chroma) {
  CameraResponse made;
  made.coarse_chroma = coarse_chroma;
  for (std::size_t k = 0; k < 256; ++k) {
    const double level = static_cast<double>(k) / 255, base = (level + 0.055) / 1.055;
    const bool dark = level <= 0.04045;
    made.light[k] = srgb ? static_cast<float>(255 * (dark ? level / 12.92 : std::pow(base, 2.4))) : k;
    made.slope[k] = srgb ? static_cast<float>(dark ? 1 / 12.92 : 2.4 / 1.055 * std::pow(base, 1.4)) : 1;
  }
  for (std::size_t k = 0; k < made.level_of_root.size(); ++k) {
    const double light = std::pow(k / 255.0, 2);
    made.level_of_root[k] =
        static_cast<float>(255 * (!srgb                ? light
                                  : light <= 0.0031308 ? 12.92 * light
                                                       : 1.055 * std::pow(light, 1 / 2.4) - 0.055));
  }
  return made;
}

constexpr double most_of_one_picture = 20;  // edges count no more than that
constexpr int most_looks = 64;

}  // namespace

const CameraResponse& CameraResponse::linear(bool coarse_chroma) {
  static const CameraResponse fine = response_of(false, false), with_coarse = response_of(false, true);
  return coarse_chroma ? with_coarse : fine;
}

const CameraResponse& CameraResponse::srgb(bool coarse_chroma) {
  static const CameraResponse fine = response_of(true, false), with_coarse = response_of(true, true);
  return coarse_chroma ? with_coarse : fine;
}

GreyLevel CameraResponse::shown(double of_light) const {
  const double square = 255 * of_light, lit = square > 1 ? square : 1, root = std::sqrt(lit);
  const auto cell = static_cast<std::size_t>(std::min(root, root_cells - 1.0));
  const auto at = static_cast<double>(level_of_root[cell]),
             rise = static_cast<double>(level_of_root[cell + 1]) - at;
  const double below = square > 1 ? 0 : (square - 1) * static_cast<double>(level_of_root[1]);
  return {at + (root - static_cast<double>(cell)) * rise + below, root / (127.5 * rise)};
}

// Coarse colours look like a linear response: edges that show them say nothing of it.
void ResponseBelief::add(const ResponseEvidence& evidence) {
  const auto capped = [](double x) { return std::clamp(x, -most_of_one_picture, most_of_one_picture); };
  coarse_chroma_ += capped(evidence.coarse_chroma);
  if (!coarse_chroma()) srgb_ += capped(evidence.srgb) + evidence.srgb_by_noise;
  ++looks_;
}

bool ResponseBelief::open() const {
  const bool settled = coarse_chroma_ >= settled_chroma ||
                       (coarse_chroma_ <= -settled_chroma && std::abs(srgb_) >= settled_response);
  return !settled && looks_ < most_looks;
}

std::array<ResponseBelief::Alternative, 2> ResponseBelief::alternatives() const {
  const auto probability = [](double log_odds) { return 1 / (1 + std::exp(-log_odds)); };
  const double coarse = probability(coarse_chroma_), srgb = probability(srgb_);
  const CameraResponse& believed = srgb_ > 0 ? CameraResponse::srgb() : CameraResponse::linear();
  const CameraResponse& other = srgb_ > 0 ? CameraResponse::linear() : CameraResponse::srgb();
  const double of_believed = (1 - coarse) * std::max(srgb, 1 - srgb),
               of_other = (1 - coarse) * std::min(srgb, 1 - srgb);
  return {{{&other, of_other},
           coarse_chroma() ? Alternative{&believed, of_believed}
                           : Alternative{&CameraResponse::srgb(true), coarse}}};
}

double squares_left(const std::vector<RingColor>& pixels, const EdgeProfileFit& edge,
                    const CameraResponse& response) {
  // Least squares of light first, then Gauss-Newton steps on grey levels, where the noise is even.
  constexpr int steps = 3;
  using Levels = Eigen::Matrix<double, 5, 1>;  // O, A, B, D, E
  std::array<Levels, 3> levels;
  levels.fill(Levels::Zero());
  double squares = 0;
  for (int step = 0; step < steps; ++step) {
    std::array<Eigen::Matrix<double, 5, 5>, 3> normal;
    std::array<Levels, 3> right;
    normal.fill(1e-6 * Eigen::Matrix<double, 5, 5>::Identity());
    right.fill(Levels::Zero());
    squares = 0;
    for (const RingColor& pixel : pixels) {
      // The profile's terms do not depend on the channel.
      const double x = (edge.offset_px - static_cast<double>(pixel.distance_px)) / edge.blur_px;
      const BlurredBasis basis = blurred_basis(x);
      Levels row;
      row << 1, basis.step, basis.root, basis.ramp, basis.ramp - x;
      for (int c = 0; c < 3; ++c) {
        const auto channel = static_cast<std::size_t>(c);
        const unsigned char grey = pixel.bgr[c];
        GreyLevel model{0, 1};
        double error = static_cast<double>(response.light[grey]);  // of grey level / slope
        if (step > 0) {
          model = response.shown(row.dot(levels[channel]));
          error = (grey - model.level) * model.slope;
          squares += (grey - model.level) * (grey - model.level);
        }
        const double weight = 1 / (model.slope * model.slope);
        normal[channel] += weight * row * row.transpose();
        right[channel] += weight * error * row;
      }
    }
    for (std::size_t c = 0; c < 3; ++c) levels[c] += normal[c].ldlt().solve(right[c]);
  }
  return squares;
}

}  // namespace ballservo
