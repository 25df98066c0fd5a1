#include "perception/outline/camera_response.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

constexpr double clear_evidence = 6, settled_evidence = 30, most_of_one_ball = 20;
constexpr int most_looks = 64;

// The grey level that shows this much light, beyond the ends in a straight line, and d light / d grey there.
struct GreyLevel {
  double level, slope;
};

GreyLevel grey_level(const CameraResponse& response, double light) {
  const auto above =
      std::lower_bound(response.light.begin(), response.light.end() - 1, static_cast<float>(light));
  const auto at = static_cast<std::size_t>(above - response.light.begin());
  const auto slope = static_cast<double>(response.slope[at]);
  return {static_cast<double>(at) + (light - static_cast<double>(response.light[at])) / slope, slope};
}

// The profile's terms at every pixel do not depend on the channel.
Eigen::Vector4d terms_at(float distance_px, const EdgeProfileFit& edge) {
  const BlurredBasis basis =
      blurred_basis((edge.offset_px - static_cast<double>(distance_px)) / edge.blur_px);
  return {1, basis.step, basis.root, basis.ramp};
}

}  // namespace

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

void ResponseBelief::add(double evidence) {
  evidence_ += std::clamp(evidence, -most_of_one_ball, most_of_one_ball);
  ++looks_;
}

bool ResponseBelief::open() const { return std::abs(evidence_) < settled_evidence && looks_ < most_looks; }

const CameraResponse& ResponseBelief::likelier() const {
  return evidence_ > clear_evidence ? CameraResponse::srgb() : CameraResponse::linear();
}

double squares_left(const std::vector<RingColor>& pixels, const EdgeProfileFit& edge,
                    const CameraResponse& response) {
  // Least squares of light first, then Gauss-Newton steps on grey levels, where the noise is even.
  constexpr int steps = 3;
  std::array<Eigen::Vector4d, 3> levels;
  levels.fill(Eigen::Vector4d::Zero());
  double squares = 0;
  for (int step = 0; step < steps; ++step) {
    std::array<Eigen::Matrix4d, 3> normal;
    std::array<Eigen::Vector4d, 3> right;
    normal.fill(1e-6 * Eigen::Matrix4d::Identity());
    right.fill(Eigen::Vector4d::Zero());
    squares = 0;
    for (const RingColor& pixel : pixels) {
      const Eigen::Vector4d row = terms_at(pixel.distance_px, edge);
      for (int c = 0; c < 3; ++c) {
        const auto channel = static_cast<std::size_t>(c);
        const unsigned char grey = pixel.bgr[c];
        GreyLevel model{0, 1};
        double error = static_cast<double>(response.light[grey]);  // of grey level / slope
        if (step > 0) {
          model = grey_level(response, row.dot(levels[channel]));
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
