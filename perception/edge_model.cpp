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

// E sqrt(max(0, x + z)) and its slope, by substituting y = sqrt(x + z), which removes the root's infinite
// slope: what is left is even in y and vanishes at the end, so that the trapezoidal rule is exact to
// rounding.
std::array<double, 2> blurred_root(double x) {
  const double high = std::sqrt(std::max(0.0, x) + 9.0);
  constexpr int steps = 128;
  double value = 0, slope = 0;
  for (int i = 1; i <= steps; ++i) {
    const double y = high * i / steps, z = y * y - x;
    const double weight = 2 * y * y * normal_density(z);
    value += weight;
    slope += z * weight;
  }
  return {value * high / steps, slope * high / steps};
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
      const std::array<double, 2> root = blurred_root(x);
      values[static_cast<std::size_t>(i)] =
          Float4{static_cast<float>(normal_distribution(x)), static_cast<float>(normal_density(x)),
                 static_cast<float>(root[0]), static_cast<float>(root[1])};
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

// Four samples' Phi, phi, F and F', each in one vector.
struct BasisOfFour {
  Float4 step, density, root, root_slope;
};

BasisOfFour look_up_four(const BasisTable& table, Float4 x) {
  using Choice = int __attribute__((vector_size(16)));
  const Float4 a = look_up(table, x[0]), b = look_up(table, x[1]), c = look_up(table, x[2]),
               d = look_up(table, x[3]);
  const Float4 low_ab = __builtin_shuffle(a, b, Choice{0, 4, 1, 5}),
               high_ab = __builtin_shuffle(a, b, Choice{2, 6, 3, 7}),
               low_cd = __builtin_shuffle(c, d, Choice{0, 4, 1, 5}),
               high_cd = __builtin_shuffle(c, d, Choice{2, 6, 3, 7});
  return {__builtin_shuffle(low_ab, low_cd, Choice{0, 1, 4, 5}),
          __builtin_shuffle(low_ab, low_cd, Choice{2, 3, 6, 7}),
          __builtin_shuffle(high_ab, high_cd, Choice{0, 1, 4, 5}),
          __builtin_shuffle(high_ab, high_cd, Choice{2, 3, 6, 7})};
}

double total(Float4 x) {
  return static_cast<double>(x[0]) + static_cast<double>(x[1]) + static_cast<double>(x[2]) +
         static_cast<double>(x[3]);
}

// Of the whole profile at p; the limb turns away over `radius_px`.
NormalEquations normal_equations(const EdgeSamples& samples, const Vector& p, double radius_px) {
  const BasisTable& table = basis_table();
  const auto s = static_cast<float>(std::exp(p(5)));
  const Eigen::Matrix<float, parameters, 1> q = p.cast<float>();
  const Float4 inverse = all(1 / s), root_scale = all(std::sqrt(s)), width = all(s);
  const Float4 turn = all(static_cast<float>(0.25 / radius_px));
  // The row of the Jacobian and, last, the residual; their products by pairs are summed.
  constexpr int columns = parameters + 1;
  Float4 sums[columns][columns] = {};
  const Float4 lane{0, 1, 2, 3};
  for (int i = 0; i < samples.count; i += 4) {
    const auto at = static_cast<std::size_t>(i);
    const Float4 distance{samples.distance_px[at], samples.distance_px[at + 1], samples.distance_px[at + 2],
                          samples.distance_px[at + 3]};
    const Float4 intensity{samples.intensity[at], samples.intensity[at + 1], samples.intensity[at + 2],
                           samples.intensity[at + 3]};
    const Float4 weight{samples.weight[at], samples.weight[at + 1], samples.weight[at + 2],
                        samples.weight[at + 3]};
    const Float4 counts =
        lane + all(static_cast<float>(i)) < all(static_cast<float>(samples.count)) ? weight : all(0);
    const Float4 x = (all(q[4]) - distance) * inverse;
    const BasisOfFour basis = look_up_four(table, x);
    const Float4 ramp = width * (x * basis.step + basis.density);
    const Float4 bend = turn * ramp;
    const Float4 root_factor = root_scale * (all(1) - (bend < all(0.5f) ? bend : all(0.5f)));
    const Float4 root = root_factor * basis.root;
    const Float4 slope = all(q[1]) * basis.density + all(q[2]) * root_factor * basis.root_slope +
                         all(q[3]) * width * basis.step;
    const Float4 value = all(q[0]) + all(q[1]) * basis.step + all(q[2]) * root + all(q[3]) * ramp;
    const Float4 row[columns] = {counts,
                                 counts * basis.step,
                                 counts * root,
                                 counts * ramp,
                                 counts * slope * inverse,
                                 counts * (all(0.5f * q[2]) * root + all(q[3]) * ramp - x * slope),
                                 counts * (value - intensity)};
    for (int k = 0; k < columns; ++k) {
      for (int l = k; l < columns; ++l) sums[k][l] += row[k] * row[l];
    }
  }
  NormalEquations normal;
  for (int k = 0; k < parameters; ++k) {
    for (int l = k; l < parameters; ++l) normal.matrix(k, l) = normal.matrix(l, k) = total(sums[k][l]);
    normal.right(k) = -total(sums[k][parameters]);
  }
  normal.squares = total(sums[parameters][parameters]);
  return normal;
}

}  // namespace

BlurredBasis blurred_basis(double x) {
  const Float4 basis = look_up(basis_table(), static_cast<float>(x));
  const double step = static_cast<double>(basis[0]), density = static_cast<double>(basis[1]);
  const double ramp = x > static_cast<double>(table_low) ? x * step + density : 0;
  return {step, density, static_cast<double>(basis[2]), static_cast<double>(basis[3]), ramp, step};
}

std::optional<EdgeProfileFit> fit_edge_profile(const EdgeSamples& samples, double start_offset_px,
                                               const EdgeProfilePrior& prior,
                                               const EdgeProfileOptions& options) {
  if (samples.count < 2 * parameters) return std::nullopt;
  float inside = 0, outside = 0;
  int inside_count = 0, outside_count = 0;
  const auto clear = static_cast<float>(1.5 * prior.blur_px), start = static_cast<float>(start_offset_px);
  for (std::size_t i = 0; i < static_cast<std::size_t>(samples.count); ++i) {
    const float t = samples.distance_px[i] - start;
    if (t < -clear) inside += samples.intensity[i], ++inside_count;
    if (t > clear) outside += samples.intensity[i], ++outside_count;
  }
  if (inside_count < 4 || outside_count < 4) return std::nullopt;
  const double outside_level = static_cast<double>(outside) / outside_count;
  const double contrast = static_cast<double>(inside) / inside_count - outside_level;
  if (!(std::abs(contrast) >= options.min_contrast)) return std::nullopt;

  Vector p;
  p << outside_level, contrast, prior.root, 0, start_offset_px, std::log(prior.blur_px);
  double noise = 0;
  Eigen::LLT<Matrix> llt;
  double variance = 0;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    NormalEquations normal = normal_equations(samples, p, prior.radius_px);
    const double freedom = samples.count - parameters;
    noise = std::sqrt(normal.squares / std::max(1.0, freedom));
    // Priors count as measurements in units of the noise; a floor stands for quantisation.
    variance = std::max(noise * noise, 0.04);
    const auto believe = [&](int index, double value, double sigma) {
      const double weight = variance / (sigma * sigma);
      normal.matrix(index, index) += weight;
      normal.right(index) += weight * (value - p(index));
    };
    const double step_size = std::max(std::abs(p(1)), options.min_contrast);
    believe(2, prior.root, prior.root_sigma_fraction * step_size);
    believe(3, 0, prior.ramp_sigma_fraction * step_size);
    believe(5, std::log(prior.blur_px), prior.log_blur_sigma);
    llt.compute(normal.matrix);
    Vector step = llt.solve(normal.right);
    if (llt.info() != Eigen::Success || !step.allFinite()) return std::nullopt;
    step(4) = std::clamp(step(4), -1.0, 1.0);
    step(5) = std::clamp(step(5), -0.4, 0.4);
    p += step;
    p(5) = std::clamp(p(5), std::log(0.25), std::log(4.0));
    if (std::abs(step(4)) < options.settled_px && std::abs(step(5)) < 10 * options.settled_px) break;
  }
  const Vector of_offset = llt.solve(Vector::Unit(4)) * variance;
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
