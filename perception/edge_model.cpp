#include "perception/edge_model.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace ballservo {
namespace {

constexpr float table_low = -7, table_high = 12;
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

// Four floats that the compiler computes with at once, in the same order on every machine.
using Float4 = float __attribute__((vector_size(16)));
Float4 all(float x) { return Float4{x, x, x, x}; }

// Phi, phi, F and F' at every node.
struct BasisTable {
  std::array<Float4, table_cells + 2> values;

  BasisTable() {
    for (int i = 0; i < static_cast<int>(values.size()); ++i) {
      const double x = static_cast<double>(table_low) + static_cast<double>(i) / cells_per_unit;
      constexpr double h = 0.5 / cells_per_unit;
      values[static_cast<std::size_t>(i)] =
          Float4{static_cast<float>(normal_distribution(x)), static_cast<float>(normal_density(x)),
                 static_cast<float>(blurred_root(x)),
                 static_cast<float>((blurred_root(x + h) - blurred_root(x - h)) / (2 * h))};
    }
  }
};

const BasisTable& basis_table() {
  static const BasisTable table;
  return table;
}

// Phi, phi, F and F' at x.
Float4 look_up(const BasisTable& table, float x) {
  if (!(x > table_low)) return all(0);
  if (x >= table_high) {
    const float root = std::sqrt(x);
    return Float4{1, 0, root - 0.125f / (x * root), 0.5f / root};
  }
  const float position = (x - table_low) * cells_per_unit;
  const auto cell = static_cast<std::size_t>(position);
  const Float4 &a = table.values[cell], &b = table.values[cell + 1];
  return a + all(position - static_cast<float>(cell)) * (b - a);
}

constexpr int parameters = 6;  // O, A, B, D, t0, log s
using Vector = Eigen::Matrix<double, parameters, 1>;
using Matrix = Eigen::Matrix<double, parameters, parameters>;

struct NormalEquations {
  Matrix matrix = Matrix::Zero();
  Vector right = Vector::Zero();
  double squares = 0;
};

// Of the whole profile at p; the limb turns away over `radius_px`.
NormalEquations normal_equations(const EdgeSample* samples, std::size_t count, const Vector& p,
                                 double radius_px) {
  const BasisTable& table = basis_table();
  const auto s = static_cast<float>(std::exp(p(5))), inverse = 1 / s, root_scale = std::sqrt(s);
  const Eigen::Matrix<float, parameters, 1> q = p.cast<float>();
  const auto turn = static_cast<float>(0.25 / radius_px);
  // Rows of J'J and J'r: of the first four unknowns with the first four and with (t0, log s, residual), and
  // of the latter among themselves.
  Float4 level_level[4] = {}, level_edge[4] = {}, edge_edge[3] = {};
  for (std::size_t i = 0; i < count; ++i) {
    const float x = (q[4] - samples[i].distance_px) * inverse;
    const Float4 basis = look_up(table, x);
    const float step = basis[0], density = basis[1];
    const float ramp = s * (x * step + density);
    const float limb = 1 - std::min(0.5f, turn * ramp);
    const float root_factor = root_scale * limb;
    const float root = root_factor * basis[2];
    const float slope_x = q[1] * density + q[2] * root_factor * basis[3] + q[3] * s * step;
    const float residual = q[0] + q[1] * step + q[2] * root + q[3] * ramp - samples[i].intensity;
    const Float4 level{1, step, root, ramp};
    const Float4 edge{slope_x * inverse, 0.5f * q[2] * root + q[3] * ramp - x * slope_x, residual, 0};
    for (int k = 0; k < 4; ++k) {
      level_level[k] += all(level[k]) * level;
      level_edge[k] += all(level[k]) * edge;
    }
    for (int k = 0; k < 3; ++k) edge_edge[k] += all(edge[k]) * edge;
  }
  NormalEquations normal;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) normal.matrix(i, k) = static_cast<double>(level_level[i][k]);
    for (int k = 0; k < 2; ++k) {
      normal.matrix(i, 4 + k) = normal.matrix(4 + k, i) = static_cast<double>(level_edge[i][k]);
    }
    normal.right(i) = -static_cast<double>(level_edge[i][2]);
  }
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2; ++k) normal.matrix(4 + i, 4 + k) = static_cast<double>(edge_edge[i][k]);
    normal.right(4 + i) = -static_cast<double>(edge_edge[i][2]);
  }
  normal.squares = static_cast<double>(edge_edge[2][2]);
  return normal;
}

}  // namespace

BlurredBasis blurred_basis(double x) {
  const Float4 basis = look_up(basis_table(), static_cast<float>(x));
  const double step = static_cast<double>(basis[0]), density = static_cast<double>(basis[1]);
  const double ramp = x > static_cast<double>(table_low) ? x * step + density : 0;
  return {step, density, static_cast<double>(basis[2]), static_cast<double>(basis[3]), ramp, step};
}

std::optional<EdgeProfileFit> fit_edge_profile(const EdgeSample* samples, std::size_t count,
                                               double start_offset_px, const EdgeProfilePrior& prior,
                                               const EdgeProfileOptions& options) {
  if (count < 2 * parameters) return std::nullopt;
  float inside = 0, outside = 0;
  int inside_count = 0, outside_count = 0;
  const auto clear = static_cast<float>(1.5 * prior.blur_px), start = static_cast<float>(start_offset_px);
  for (std::size_t i = 0; i < count; ++i) {
    const float t = samples[i].distance_px - start;
    if (t < -clear) inside += samples[i].intensity, ++inside_count;
    if (t > clear) outside += samples[i].intensity, ++outside_count;
  }
  if (inside_count < 4 || outside_count < 4) return std::nullopt;
  const double outside_level = static_cast<double>(outside) / outside_count;
  const double contrast = static_cast<double>(inside) / inside_count - outside_level;
  if (!(std::abs(contrast) >= options.min_contrast)) return std::nullopt;

  Vector p;
  p << outside_level, contrast, prior.root, 0, start_offset_px, std::log(prior.blur_px);
  double noise = 0;
  Matrix information = Matrix::Zero();
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    NormalEquations normal = normal_equations(samples, count, p, prior.radius_px);
    const double freedom = static_cast<double>(count) - parameters;
    noise = std::sqrt(normal.squares / std::max(1.0, freedom));
    // Priors count as measurements in units of the noise; a floor stands for quantisation.
    const double variance = std::max(noise * noise, 0.04);
    const auto believe = [&](int index, double value, double sigma) {
      const double weight = variance / (sigma * sigma);
      normal.matrix(index, index) += weight;
      normal.right(index) += weight * (value - p(index));
    };
    const double step_size = std::max(std::abs(p(1)), options.min_contrast);
    believe(2, prior.root, prior.root_sigma_fraction * step_size);
    believe(3, 0, prior.ramp_sigma_fraction * step_size);
    believe(5, std::log(prior.blur_px), prior.log_blur_sigma);
    information = normal.matrix / variance;
    const Eigen::LLT<Matrix> llt(normal.matrix);
    Vector step = llt.solve(normal.right);
    if (llt.info() != Eigen::Success || !step.allFinite()) return std::nullopt;
    step(4) = std::clamp(step(4), -1.0, 1.0);
    step(5) = std::clamp(step(5), -0.4, 0.4);
    p += step;
    p(5) = std::clamp(p(5), std::log(0.25), std::log(4.0));
    if (std::abs(step(4)) < options.settled_px && std::abs(step(5)) < 10 * options.settled_px) break;
  }
  const Vector of_offset = information.llt().solve(Vector::Unit(4));
  EdgeProfileFit fit;
  fit.offset_px = p(4);
  fit.sigma_px = std::sqrt(of_offset(4));
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
