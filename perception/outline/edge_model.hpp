// How the edge of a ball looks across its outline: a step and the shading of the limb, seen through a blur.
//
// With t the distance outside the outline (px) and s the blur's standard deviation (px), the intensity is
//   O + A Phi(-(t - t0)/s) + B [sqrt(max(0, t0 - t)) * G_s] + D [max(0, t0 - t) * G_s]
//     + E [max(0, t - t0) * G_s]
// where * G_s is convolution with a Gaussian. Near its limb a Lambertian sphere is n.l = const + const
// sqrt(depth) + O(depth), so the square root and the ramp carry the shading, and t0 stays the geometric edge.
// E is the background's slope; in one channel of a coded picture it is 0.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "perception/segmentation/instructions.hpp"

namespace ballservo {

struct CameraResponse;

/// Values of the basis functions and their slopes at x = (t0 - t)/s, for s = 1:
/// Phi(x), its slope phi(x); F(x) = E sqrt(max(0, x + z)), z normal, and F'(x); ramp x Phi(x) + phi(x), slope
/// Phi(x).
struct BlurredBasis {
  double step, step_slope;
  double root, root_slope;
  double ramp, ramp_slope;
};

/// By table, to 1e-5 (tested against quadrature).
BlurredBasis blurred_basis(double x);

/// The pixels near one arc segment of the outline.
struct EdgeSamples {
  static constexpr int most = 192;
  std::array<float, most> distance_px{};  ///< outside the assumed outline, negative inside
  std::array<float, most> intensity{};    ///< grey levels
  std::array<float, most> weight{};       ///< 1 / noise, where that differs from pixel to pixel
  int count = 0;

  void add(float distance, float level, float one_over_noise = 1) {  ///< more than `most` are not needed
    if (count == most) return;
    const auto i = static_cast<std::size_t>(count++);
    distance_px[i] = distance;
    intensity[i] = level;
    weight[i] = one_over_noise;
  }
};

struct EdgeProfileOptions {
  double min_contrast = 6;   ///< grey levels; below that there is no edge to place
  double max_offset_px = 3;  ///< an edge further from the assumed outline is not the ball's
  double radius_px = 1e9;    ///< of the outline: how fast the limb turns
  Instructions instructions = Instructions::fastest;
};

struct EdgeProfileFit {
  double offset_px = 0;  ///< t0
  double sigma_px = 0;   ///< its standard deviation, from the residuals
  double blur_px = 0;    ///< s
};

/// Fits the profile by damped Gauss-Newton; nothing where there is no clear edge within reach.
std::optional<EdgeProfileFit> fit_edge_profile(const EdgeSamples& samples, double start_offset_px,
                                               const EdgeProfileOptions& options);

/// What there is on both sides of an edge.
template <class Values>
struct BothSides {
  Values inside, outside;
};
using EdgeColors = BothSides<Eigen::Array3f>;  ///< light (BGR)

/// Luma's parts of blue, green and red (Rec. 601): of grey levels, not of light.
inline const Eigen::Vector3f luma_of(0.114f, 0.587f, 0.299f);

/// What a coded picture keeps of its grey levels: luma at full resolution, chroma at half of it.
struct CodedChannel {
  Eigen::Vector3f of_grey;  ///< its parts of blue, green and red
  double blur_px = 0;       ///< standard deviation of what halving its resolution adds
};

/// Fits the same profile to samples of one coded channel. The light at each pixel is a mix of both sides,
/// O Phi((t - t0)/s) times the one outside, and the rest of the profile times the one inside, in percent; a
/// coarse channel is blurred once more, as grey levels. `start`: a fit of this edge's colours.
std::optional<EdgeProfileFit> fit_coded_profile(const EdgeSamples& samples, const EdgeColors& colors,
                                                const CameraResponse& response, const CodedChannel& channel,
                                                const EdgeProfileFit& start,
                                                const EdgeProfileOptions& options);

}  // namespace ballservo
