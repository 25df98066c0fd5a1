#include "perception/outline/edge_model.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "perception/outline/camera_response.hpp"

namespace ballservo {
namespace {

// As far inside as the narrowest blur makes of the widest ring.
constexpr float table_low = -7, table_high = 33;
constexpr int cells_per_unit = 64;
constexpr int table_cells = static_cast<int>(table_high - table_low) * cells_per_unit;

double normal_density(double x) { return 0.3989422804014327 * std::exp(-0.5 * x * x); }
double normal_distribution(double x) { return 0.5 * std::erfc(-x * 0.7071067811865476); }

// E sqrt(max(0, x + z)) and its slope, by substituting y = sqrt(x + z), which removes the infinite slope:
// what is left is even in y and vanishes at the end, so that the trapezoidal rule is exact to rounding.
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

// Floats that the compiler computes with at once, in the same order on every machine.
using Float4 = float __attribute__((vector_size(16)));
using Float8 = float __attribute__((vector_size(32)));
using Int8 = int __attribute__((vector_size(32)));

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
Float4 basis_at(const BasisTable& table, float x) {
  if (!(x > table_low)) return Float4{};
  if (x >= table_high) {
    const float root = std::sqrt(x);
    return Float4{1, 0, root - 0.125f / (x * root), 0.5f / root};
  }
  const float position = (x - table_low) * cells_per_unit;
  const auto cell = static_cast<std::size_t>(position);
  const Float4 &a = table.values[cell], &b = table.values[cell + 1];
  return a + (position - static_cast<float>(cell)) * (b - a);
}

constexpr int parameters = 6;  // O, A, B, D, t0, log s
// What is believed of s, a log-normal, and of B (per sqrt(px)) and D (per px), relative to A and about 0.
constexpr double expected_blur_px = 0.8, log_blur_sigma = 0.5;
constexpr double root_sigma_share = 0.4, ramp_sigma_share = 0.02;
// What is outside is believed to that, in percent, where a channel may say nothing of it, as chroma of grey.
constexpr double coded_outside_sigma = 10, unknown = 1e9;
constexpr int iterations = 6;
constexpr double settled_edge_px = 4e-3;  // a step of t0 that ends them: what would follow is its square
using Vector = Eigen::Matrix<double, parameters, 1>;
using Matrix = Eigen::Matrix<double, parameters, parameters>;

struct EdgeEquations {
  Matrix matrix = Matrix::Zero();
  Vector right = Vector::Zero();
  double squares = 0;
};

// Eight samples' Phi, phi, F and F', each in one vector.
struct BasisOfEight {
  Float8 step, density, root, root_slope;
};

// Of the samples at x, which is clamped to the table.
[[gnu::always_inline]] inline void look_up_eight(const BasisTable& table, const Float8& x,
                                                 BasisOfEight& basis) {
  const Float8 low = Float8{} + table_low, high = Float8{} + table_high;
  const Float8 from_low = x > low ? x : low, within = from_low < high ? from_low : high;  // NaN: low
  const Float8 position = (within - table_low) * cells_per_unit;
  const Int8 cell = __builtin_convertvector(position, Int8);
  const Float8 part = position - __builtin_convertvector(cell, Float8);
  Float4 at[8];
  for (int i = 0; i < 8; ++i) {
    const Float4* const node = &table.values[static_cast<std::size_t>(cell[i])];
    at[i] = node[0] + part[i] * (node[1] - node[0]);
  }
  // Transposed by fours, and the fours joined.
  Float4 low_01[2], high_01[2], low_23[2], high_23[2];
  for (int k = 0; k < 2; ++k) {
    const Float4* const four = at + 4 * k;
    low_01[k] = __builtin_shufflevector(four[0], four[1], 0, 4, 1, 5);
    high_01[k] = __builtin_shufflevector(four[0], four[1], 2, 6, 3, 7);
    low_23[k] = __builtin_shufflevector(four[2], four[3], 0, 4, 1, 5);
    high_23[k] = __builtin_shufflevector(four[2], four[3], 2, 6, 3, 7);
  }
  const auto first_half = [](const Float4(&a)[2], const Float4(&b)[2], Float8& joined) {
    joined = __builtin_shufflevector(__builtin_shufflevector(a[0], b[0], 0, 1, 4, 5),
                                     __builtin_shufflevector(a[1], b[1], 0, 1, 4, 5), 0, 1, 2, 3, 4, 5, 6, 7);
  };
  const auto second_half = [](const Float4(&a)[2], const Float4(&b)[2], Float8& joined) {
    joined = __builtin_shufflevector(__builtin_shufflevector(a[0], b[0], 2, 3, 6, 7),
                                     __builtin_shufflevector(a[1], b[1], 2, 3, 6, 7), 0, 1, 2, 3, 4, 5, 6, 7);
  };
  first_half(low_01, low_23, basis.step);
  second_half(low_01, low_23, basis.density);
  first_half(high_01, high_23, basis.root);
  second_half(high_01, high_23, basis.root_slope);
}

[[gnu::always_inline]] inline double total(const Float8& x) {
  const Float4 halves = __builtin_shufflevector(x, x, 0, 1, 2, 3) + __builtin_shufflevector(x, x, 4, 5, 6, 7);
  return static_cast<double>((halves[0] + halves[2]) + (halves[1] + halves[3]));
}

[[gnu::always_inline]] inline void load(const std::array<float, EdgeSamples::most>& from, int first,
                                        Float8& to) {
  std::memcpy(&to, &from[static_cast<std::size_t>(first)], sizeof to);
}

// Of the whole profile at p; the limb turns away over `radius_px`.
[[gnu::always_inline]] inline void add_up(const EdgeSamples& samples, const Vector& p, double radius_px,
                                          EdgeEquations& normal) {
  const BasisTable& table = basis_table();
  const auto width = static_cast<float>(std::exp(p(5)));
  const Eigen::Matrix<float, parameters, 1> q = p.cast<float>();
  const float inverse = 1 / width, root_scale = std::sqrt(width), turn = static_cast<float>(0.25 / radius_px);
  // The row of the Jacobian and, last, the residual; their products by pairs are summed.
  constexpr int columns = parameters + 1;
  Float8 sums[columns][columns] = {};
  const Float8 lane{0, 1, 2, 3, 4, 5, 6, 7}, half = Float8{} + 0.5f;
  for (int i = 0; i < samples.count; i += 8) {
    Float8 distance, intensity, weight;
    load(samples.distance_px, i, distance);
    load(samples.intensity, i, intensity);
    load(samples.weight, i, weight);
    const Float8 counts =
        lane + static_cast<float>(i) < static_cast<float>(samples.count) ? weight : Float8{};
    const Float8 x = (q[4] - distance) * inverse;
    BasisOfEight basis;
    look_up_eight(table, x, basis);
    const Float8 ramp = width * (x * basis.step + basis.density);
    const Float8 bend = turn * ramp;
    const Float8 root_factor = root_scale * (1 - (bend < half ? bend : half));
    const Float8 root = root_factor * basis.root;
    const Float8 slope =
        q[1] * basis.density + q[2] * root_factor * basis.root_slope + q[3] * width * basis.step;
    const Float8 value = q[0] + q[1] * basis.step + q[2] * root + q[3] * ramp;
    const Float8 row[columns] = {counts,
                                 counts * basis.step,
                                 counts * root,
                                 counts * ramp,
                                 counts * slope * inverse,
                                 counts * (0.5f * q[2] * root + q[3] * ramp - x * slope),
                                 counts * (value - intensity)};
    for (int k = 0; k < columns; ++k) {
      for (int l = k; l < columns; ++l) sums[k][l] += row[k] * row[l];
    }
  }
  for (int k = 0; k < parameters; ++k) {
    for (int l = k; l < parameters; ++l) normal.matrix(k, l) = normal.matrix(l, k) = total(sums[k][l]);
    normal.right(k) = -total(sums[k][parameters]);
  }
  normal.squares = total(sums[parameters][parameters]);
}

// Of a channel that is coded from the light of two colours. What halved resolution blurs is the mean of three
// places (Gauss and Hermite's, weights 1/6, 2/3, 1/6).
EdgeEquations coded_equations(const EdgeSamples& samples, const EdgeColors& colors,
                              const CameraResponse& response, const CodedChannel& channel, const Vector& p,
                              double radius_px) {
  const double width = std::exp(p(5)), turn = 0.25 / radius_px, root_scale = std::sqrt(width);
  const int beside = channel.blur_px > 0 ? 1 : 0;
  EdgeEquations normal;
  for (std::size_t i = 0; i < static_cast<std::size_t>(samples.count); ++i) {
    Vector row = Vector::Zero();
    double residual = -static_cast<double>(samples.intensity[i]);
    for (int place = -beside; place <= beside; ++place) {
      const double distance_px =
          static_cast<double>(samples.distance_px[i]) + place * std::sqrt(3.0) * channel.blur_px;
      const double part = beside == 0 ? 1 : place == 0 ? 2.0 / 3 : 1.0 / 6;
      const double x = (p(4) - distance_px) / width;
      const BlurredBasis basis = blurred_basis(x);
      const double ramp = width * basis.ramp;
      const double root_factor = root_scale * (1 - std::min(turn * ramp, 0.5)),
                   root = root_factor * basis.root;
      const double slope =
          p(1) * basis.step_slope + p(2) * root_factor * basis.root_slope + p(3) * width * basis.step;
      const double inside = p(1) * basis.step + p(2) * root + p(3) * ramp;
      const Eigen::Array3f light = (0.01f * static_cast<float>(p(0) * (1 - basis.step)) * colors.outside +
                                    0.01f * static_cast<float>(inside) * colors.inside);
      const CodedLevel coded = code(light, response, channel.of_grey);
      // The level by one percent of either light.
      const double by_outside = 0.01 * part * static_cast<double>((coded.slope * colors.outside).sum()),
                   by_inside = 0.01 * part * static_cast<double>((coded.slope * colors.inside).sum());
      const double by_x = by_inside * slope - by_outside * p(0) * basis.step_slope;
      Vector here;
      here << by_outside * (1 - basis.step), by_inside * basis.step, by_inside * root, by_inside * ramp,
          by_x / width, by_inside * (0.5 * p(2) * root + p(3) * ramp) - x * by_x;
      row += here;
      residual += part * coded.level;
    }
    normal.matrix += row * row.transpose();
    normal.right -= residual * row;
    normal.squares += residual * residual;
  }
  return normal;
}

// Damped Gauss-Newton from p; `equations_at` are the normal equations of `count` samples there.
template <class EquationsAt>
std::optional<EdgeProfileFit> fit_profile(int count, Vector p, double outside_sigma,
                                          const EdgeProfileOptions& options,
                                          const EquationsAt& equations_at) {
  const double contrast = p(1), outside = p(0);
  Eigen::LLT<Matrix> llt;
  double variance = 0;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    EdgeEquations normal = equations_at(p);
    const double freedom = count - parameters;
    const double noise = std::sqrt(normal.squares / std::max(1.0, freedom));
    // Priors count as measurements in units of the noise; a floor stands for quantisation.
    variance = std::max(noise * noise, 0.04);
    const auto believe = [&](int index, double value, double sigma) {
      const double weight = variance / (sigma * sigma);
      normal.matrix(index, index) += weight;
      normal.right(index) += weight * (value - p(index));
    };
    const double step_size = std::max(std::abs(p(1)), options.min_contrast);
    believe(0, outside, outside_sigma);
    believe(2, 0, root_sigma_share * step_size);
    believe(3, 0, ramp_sigma_share * step_size);
    believe(5, std::log(expected_blur_px), log_blur_sigma);
    llt.compute(normal.matrix);
    Vector step = llt.solve(normal.right);
    if (llt.info() != Eigen::Success || !step.allFinite()) return std::nullopt;
    step(4) = std::clamp(step(4), -1.0, 1.0);
    step(5) = std::clamp(step(5), -0.4, 0.4);
    p += step;
    p(5) = std::clamp(p(5), std::log(0.25), std::log(4.0));
    if (std::abs(step(4)) < settled_edge_px && std::abs(step(5)) < 10 * settled_edge_px) break;
  }
  const Vector of_offset = llt.solve(Vector::Unit(4)) * variance;
  const EdgeProfileFit fit{p(4), std::sqrt(of_offset(4)), std::exp(p(5))};
  const bool same_sign = p(1) * contrast > 0 && std::abs(p(1)) >= 0.25 * std::abs(contrast);
  if (!same_sign || !std::isfinite(fit.sigma_px) || !(std::abs(fit.offset_px) <= options.max_offset_px))
    return std::nullopt;
  return fit;
}

}  // namespace

BlurredBasis blurred_basis(double x) {
  const Float4 basis = basis_at(basis_table(), static_cast<float>(x));
  const double step = static_cast<double>(basis[0]), density = static_cast<double>(basis[1]);
  const double ramp = x > static_cast<double>(table_low) ? x * step + density : 0;
  return {step, density, static_cast<double>(basis[2]), static_cast<double>(basis[3]), ramp, step};
}

std::optional<EdgeProfileFit> fit_edge_profile(const EdgeSamples& samples, double start_offset_px,
                                               const EdgeProfileOptions& options) {
  if (samples.count < 2 * parameters) return std::nullopt;
  float inside = 0, outside = 0;
  int inside_count = 0, outside_count = 0;
  const auto clear = static_cast<float>(1.5 * expected_blur_px), start = static_cast<float>(start_offset_px);
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
  p << outside_level, contrast, 0, 0, start_offset_px, std::log(expected_blur_px);
  return fit_profile(samples.count, p, unknown, options, [&](const Vector& at) {
    EdgeEquations normal;
    compute_by<add_up>(options.instructions, samples, at, options.radius_px, normal);
    return normal;
  });
}

CodedLevel code(const Eigen::Array3f& light, const CameraResponse& response, const Eigen::Vector3f& of_grey) {
  CodedLevel coded{0, {0, 0, 0}};
  for (int c = 0; c < 3; ++c) {
    const GreyLevel grey = response.shown(std::max(static_cast<double>(light[c]), 0.0));
    coded.level += static_cast<double>(of_grey[c]) * grey.level;
    coded.slope[c] = of_grey[c] / static_cast<float>(grey.slope);
  }
  return coded;
}

std::optional<EdgeProfileFit> fit_coded_profile(const EdgeSamples& samples, const EdgeColors& colors,
                                                const CameraResponse& response, const CodedChannel& channel,
                                                const EdgeProfileFit& start,
                                                const EdgeProfileOptions& options) {
  if (samples.count < 2 * parameters) return std::nullopt;
  Vector p;
  p << 100, 100, 0, 0, start.offset_px, std::log(expected_blur_px);
  return fit_profile(samples.count, p, coded_outside_sigma, options, [&](const Vector& at) {
    return coded_equations(samples, colors, response, channel, at, options.radius_px);
  });
}

}  // namespace ballservo
