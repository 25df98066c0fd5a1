#include "perception/edge_model.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace ballservo {
namespace {

constexpr double table_low = -7, table_high = 12;
constexpr int cells_per_unit = 64;
constexpr int table_cells = static_cast<int>(table_high - table_low) * cells_per_unit;

double normal_density(double x) { return 0.3989422804014327 * std::exp(-0.5 * x * x); }
double normal_distribution(double x) { return 0.5 * std::erfc(-x * 0.7071067811865476); }

// E sqrt(max(0, x + z)) by substituting y = sqrt(x + z), which removes the root's infinite slope.
double blurred_root(double x) {
  const double high = std::sqrt(std::max(0.0, x) + 9.0);
  constexpr int steps = 400;
  double sum = 0;
  for (int i = 0; i <= steps; ++i) {
    const double y = high * i / steps;
    const double weight = i == 0 || i == steps ? 1 : (i % 2 == 1 ? 4 : 2);
    sum += weight * 2 * y * y * normal_density(y * y - x);
  }
  return sum * high / steps / 3;
}

struct BasisTable {
  std::array<std::array<float, 3>, table_cells + 2> values;  // Phi, phi, F

  BasisTable() {
    for (int i = 0; i < static_cast<int>(values.size()); ++i) {
      const double x = table_low + static_cast<double>(i) / cells_per_unit;
      values[static_cast<std::size_t>(i)] = {static_cast<float>(normal_distribution(x)),
                                             static_cast<float>(normal_density(x)),
                                             static_cast<float>(blurred_root(x))};
    }
  }
};

}  // namespace

BlurredBasis blurred_basis(double x) {
  static const BasisTable table;
  if (!(x > table_low)) return {0, 0, 0, 0, 0, 0};
  if (x >= table_high) {
    const double root = std::sqrt(x);
    return {1, 0, root - 0.125 / (x * root), 0.5 / root, x, 1};
  }
  const double position = (x - table_low) * cells_per_unit;
  const int cell = static_cast<int>(position);
  const double part = position - cell;
  const auto& a = table.values[static_cast<std::size_t>(cell)];
  const auto& b = table.values[static_cast<std::size_t>(cell) + 1];
  const auto between = [part](float low, float high) { return low + part * (high - low); };
  const double step = between(a[0], b[0]), density = between(a[1], b[1]);
  return {step,
          density,
          between(a[2], b[2]),
          static_cast<double>(b[2] - a[2]) * cells_per_unit,
          x * step + density,
          step};
}

std::optional<EdgeProfileFit> fit_edge_profile(const std::vector<EdgeSample>& samples, double start_offset_px,
                                               const EdgeProfilePrior& prior,
                                               const EdgeProfileOptions& options) {
  constexpr int parameters = 6;  // O, A, B, D, t0, log s
  using Vector = Eigen::Matrix<double, parameters, 1>;
  using Matrix = Eigen::Matrix<double, parameters, parameters>;
  if (samples.size() < 2 * parameters) return std::nullopt;

  double inside = 0, outside = 0;
  int inside_count = 0, outside_count = 0;
  for (const EdgeSample& sample : samples) {
    const double t = sample.distance_px - start_offset_px;
    if (t < -1.5 * prior.blur_px) inside += sample.intensity, ++inside_count;
    if (t > 1.5 * prior.blur_px) outside += sample.intensity, ++outside_count;
  }
  if (inside_count < 4 || outside_count < 4) return std::nullopt;
  outside /= outside_count;
  const double contrast = inside / inside_count - outside;
  if (!(std::abs(contrast) >= options.min_contrast)) return std::nullopt;

  Vector p;
  p << outside, contrast, prior.root, 0, start_offset_px, std::log(prior.blur_px);
  double noise = 0;
  Matrix information = Matrix::Zero();
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    const double s = std::exp(p(5)), root_scale = std::sqrt(s);
    Matrix normal = Matrix::Zero();
    Vector right = Vector::Zero();
    double squares = 0;
    for (const EdgeSample& sample : samples) {
      const double x = (p(4) - sample.distance_px) / s;
      const BlurredBasis basis = blurred_basis(x);
      const double ramp = s * basis.ramp, limb = 1 - std::min(0.5, 0.25 * ramp / prior.radius_px);
      const double root = root_scale * basis.root * limb;
      const double slope_x =
          p(1) * basis.step_slope + p(2) * root_scale * basis.root_slope * limb + p(3) * s * basis.ramp_slope;
      Vector row;
      row << 1, basis.step, root, ramp, slope_x / s, -x * slope_x + 0.5 * p(2) * root + p(3) * ramp;
      const double residual = p(0) + p(1) * basis.step + p(2) * root + p(3) * ramp - sample.intensity;
      normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
      right -= row * residual;
      squares += residual * residual;
    }
    normal.triangularView<Eigen::StrictlyUpper>() = normal.transpose();
    const double freedom = static_cast<double>(samples.size()) - parameters;
    noise = std::sqrt(squares / std::max(1.0, freedom));
    // Priors count as measurements in units of the noise; a floor stands for quantisation.
    const double variance = std::max(noise * noise, 0.04);
    const auto believe = [&](int index, double value, double sigma) {
      const double weight = variance / (sigma * sigma);
      normal(index, index) += weight;
      right(index) += weight * (value - p(index));
    };
    const double step_size = std::max(std::abs(p(1)), options.min_contrast);
    believe(2, prior.root, prior.root_sigma_fraction * step_size);
    believe(3, 0, prior.ramp_sigma_fraction * step_size);
    believe(5, std::log(prior.blur_px), prior.log_blur_sigma);
    information = normal / variance;
    const Eigen::LDLT<Matrix> ldlt(normal);
    Vector step = ldlt.solve(right);
    if (!step.allFinite()) return std::nullopt;
    step(4) = std::clamp(step(4), -1.0, 1.0);
    step(5) = std::clamp(step(5), -0.4, 0.4);
    p += step;
    p(5) = std::clamp(p(5), std::log(0.25), std::log(4.0));
    if (std::abs(step(4)) < 1e-4 && std::abs(step(5)) < 1e-3) break;
  }
  const Matrix covariance = information.inverse();
  EdgeProfileFit fit;
  fit.offset_px = p(4);
  fit.sigma_px = std::sqrt(covariance(4, 4));
  fit.blur_px = std::exp(p(5));
  fit.outside = p(0);
  fit.step = p(1);
  fit.root = p(2);
  fit.ramp = p(3);
  fit.residual = noise;
  const bool same_sign = fit.step * contrast > 0 && std::abs(fit.step) >= 0.25 * std::abs(contrast);
  if (!same_sign || !std::isfinite(fit.sigma_px) || !(std::abs(fit.offset_px) <= options.max_offset_px))
    return std::nullopt;
  return fit;
}

}  // namespace ballservo
