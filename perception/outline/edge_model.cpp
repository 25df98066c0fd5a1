#include "perception/outline/edge_model.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

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

constexpr int parameters = 7;  // O, A, B, D, t0, log s, E
// What is believed of s, a log-normal, and of B (per sqrt(px)), D and E (per px), relative to A and about 0.
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

// Of eight samples: the row of the Jacobian and, last, the residual. A short row leaves E out.
template <int columns>
using RowOfEight = std::array<Float8, columns>;
template <int columns>
struct RowsOfEight {
  std::array<RowOfEight<columns>, EdgeSamples::most / 8> of;
  std::size_t count = 0;
};

// The k-th row of the normal equations: so few sums stay in registers.
template <int k, int columns>
[[gnu::always_inline]] inline void sum_products(const RowsOfEight<columns>& rows, EdgeEquations& normal) {
  constexpr int last = columns - 1;
  Float8 sums[columns - k] = {};
  for (std::size_t i = 0; i < rows.count; ++i) {
    const RowOfEight<columns>& row = rows.of[i];
    for (int l = k; l < columns; ++l) sums[l - k] += std::get<k>(row) * row[static_cast<std::size_t>(l)];
  }
  for (int l = k; l < last; ++l) normal.matrix(k, l) = normal.matrix(l, k) = total(sums[l - k]);
  if constexpr (k < last)
    normal.right(k) = -total(sums[last - k]);
  else
    normal.squares = total(sums[0]);
}

template <int columns, int... k>
[[gnu::always_inline]] inline void sum_all_products(const RowsOfEight<columns>& rows,
                                                    std::integer_sequence<int, k...>, EdgeEquations& normal) {
  normal = {};
  (sum_products<k>(rows, normal), ...);
}

// What `p` makes of the profile; the limb turns away over `radius_px`.
struct Profile {
  Profile(const Vector& p, double radius_px)
      : q(p.cast<float>()),
        width(static_cast<float>(std::exp(p(5)))),
        inverse(1 / width),
        root_scale(std::sqrt(width)),
        turn(static_cast<float>(0.25 / radius_px)) {}

  const BasisTable& table = basis_table();
  Eigen::Matrix<float, parameters, 1> q;
  float width, inverse, root_scale, turn;
};

// Of eight samples: what comes from inside, its parts, and how it changes with x and with log s at that x.
struct InsideOfEight {
  Float8 x, step, density, root, ramp, value, by_x, by_log_width;
};

[[gnu::always_inline]] inline void inside_at(const Profile& profile, const Float8& distance_px,
                                             InsideOfEight& inside) {
  const auto& q = profile.q;
  const Float8 half = Float8{} + 0.5f;
  const Float8 x = (q[4] - distance_px) * profile.inverse;
  BasisOfEight basis;
  look_up_eight(profile.table, x, basis);
  inside.x = x;
  inside.step = basis.step;
  inside.density = basis.density;
  inside.ramp = profile.width * (x * basis.step + basis.density);
  const Float8 bend = profile.turn * inside.ramp;
  const Float8 root_factor = profile.root_scale * (1 - (bend < half ? bend : half));
  inside.root = root_factor * basis.root;
  inside.value = q[1] * basis.step + q[2] * inside.root + q[3] * inside.ramp;
  inside.by_x =
      q[1] * basis.density + q[2] * root_factor * basis.root_slope + q[3] * profile.width * basis.step;
  inside.by_log_width = 0.5f * q[2] * inside.root + q[3] * inside.ramp;
}

struct EightSamples {
  Float8 distance_px, intensity, weights;
};

// From the i-th; those beyond the last weigh nothing.
[[gnu::always_inline]] inline void load_eight(const EdgeSamples& samples, int i, EightSamples& eight) {
  const Float8 lane{0, 1, 2, 3, 4, 5, 6, 7};
  load(samples.distance_px, i, eight.distance_px);
  load(samples.intensity, i, eight.intensity);
  load(samples.weight, i, eight.weights);
  eight.weights = lane + static_cast<float>(i) < static_cast<float>(samples.count) ? eight.weights : Float8{};
}

[[gnu::always_inline]] inline void add_up(const EdgeSamples& samples, const Profile& profile,
                                          EdgeEquations& normal) {
  RowsOfEight<parameters + 1> rows;
  for (int i = 0; i < samples.count; i += 8) {
    EightSamples eight;
    load_eight(samples, i, eight);
    const Float8& weights = eight.weights;
    InsideOfEight inside;
    inside_at(profile, eight.distance_px, inside);
    // The background's slope.
    const float slope = profile.q[6];
    const Float8 ramp = inside.ramp - profile.width * inside.x;
    const Float8 by_x = inside.by_x + slope * profile.width * (inside.step - 1);
    rows.of[rows.count++] = {weights,
                             weights * inside.step,
                             weights * inside.root,
                             weights * inside.ramp,
                             weights * by_x * profile.inverse,
                             weights * (inside.by_log_width + slope * ramp - inside.x * by_x),
                             weights * ramp,
                             weights * (profile.q[0] + inside.value + slope * ramp - eight.intensity)};
  }
  sum_all_products(rows, std::make_integer_sequence<int, parameters + 1>(), normal);
}

// The grey levels of eight lights, and d level / d light; as `CameraResponse::shown`.
[[gnu::always_inline]] inline void show_eight(const CameraResponse& response, const Float8& light,
                                              Float8& level, Float8& slope) {
  constexpr float last_cell = CameraResponse::root_cells - 1;
  const Float8 square = 255 * light, one = Float8{} + 1, most = Float8{} + last_cell;
  const Float8 lit = square > one ? square : one;  // NaN: 1
  Float8 root, at, next;
  for (int i = 0; i < 8; ++i) root[i] = std::sqrt(lit[i]);
  const Int8 cell = __builtin_convertvector(root < most ? root : most, Int8);
  for (int i = 0; i < 8; ++i) {
    const float* const node = &response.level_of_root[static_cast<std::size_t>(cell[i])];
    at[i] = node[0];
    next[i] = node[1];
  }
  slope = (next - at) * (127.5f / root);
  level = at + (root - __builtin_convertvector(cell, Float8)) * (next - at) +
          (square < one ? (square - 1) * response.level_of_root[1] : Float8{});
}

// An edge between two colours in one channel of a coded picture.
struct CodedEdge {
  const EdgeColors& colors;
  const CameraResponse& response;
  const CodedChannel& channel;
};

// What halved resolution blurs is the mean of three places (Gauss and Hermite's, weights 1/6, 2/3, 1/6).
[[gnu::always_inline]] inline void add_up_coded(const EdgeSamples& samples, const CodedEdge& edge,
                                                const Profile& profile, EdgeEquations& normal) {
  const int beside = edge.channel.blur_px > 0 ? 1 : 0;
  const auto apart_px = static_cast<float>(std::sqrt(3.0) * edge.channel.blur_px);
  const Eigen::Array3f percent_inside = 0.01f * edge.colors.inside,
                       percent_outside = 0.01f * edge.colors.outside;
  RowsOfEight<parameters> rows;
  for (int i = 0; i < samples.count; i += 8) {
    EightSamples eight;
    load_eight(samples, i, eight);
    const Float8& weights = eight.weights;
    RowOfEight<parameters>& row = rows.of[rows.count++];
    row = {};
    row[6] = -weights * eight.intensity;
    for (int place = -beside; place <= beside; ++place) {
      const float part = beside == 0 ? 1 : place == 0 ? 2.0f / 3 : 1.0f / 6;
      InsideOfEight inside;
      inside_at(profile, eight.distance_px + static_cast<float>(place) * apart_px, inside);
      const Float8 outside = 1 - inside.step;
      Float8 level{}, by_inside{}, by_outside{};  // and its change by one percent of either light
      for (int c = 0; c < 3; ++c) {
        Float8 grey, slope;
        show_eight(edge.response,
                   profile.q[0] * outside * percent_outside[c] + inside.value * percent_inside[c], grey,
                   slope);
        const float of_grey = part * edge.channel.of_grey[c];
        level += of_grey * grey;
        by_inside += of_grey * percent_inside[c] * slope;
        by_outside += of_grey * percent_outside[c] * slope;
      }
      by_inside *= weights;
      by_outside *= weights;
      const Float8 by_x = by_inside * inside.by_x - by_outside * profile.q[0] * inside.density;
      row[0] += by_outside * outside;
      row[1] += by_inside * inside.step;
      row[2] += by_inside * inside.root;
      row[3] += by_inside * inside.ramp;
      row[4] += by_x * profile.inverse;
      row[5] += by_inside * inside.by_log_width - inside.x * by_x;
      row[6] += weights * level;
    }
  }
  sum_all_products(rows, std::make_integer_sequence<int, parameters>(), normal);
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
    for (const int ramp : {3, 6}) believe(ramp, 0, ramp_sigma_share * step_size);
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
  p << outside_level, contrast, 0, 0, start_offset_px, std::log(expected_blur_px), 0;
  return fit_profile(samples.count, p, unknown, options, [&](const Vector& at) {
    EdgeEquations normal;
    const Profile profile(at, options.radius_px);
    compute_by<add_up>(options.instructions, samples, profile, normal);
    return normal;
  });
}

std::optional<EdgeProfileFit> fit_coded_profile(const EdgeSamples& samples, const EdgeColors& colors,
                                                const CameraResponse& response, const CodedChannel& channel,
                                                const EdgeProfileFit& start,
                                                const EdgeProfileOptions& options) {
  if (samples.count < 2 * parameters) return std::nullopt;
  Vector p;
  p << 100, 100, 0, 0, start.offset_px, std::log(expected_blur_px), 0;
  return fit_profile(samples.count, p, coded_outside_sigma, options, [&](const Vector& at) {
    EdgeEquations normal;
    const CodedEdge edge{colors, response, channel};
    const Profile profile(at, options.radius_px);
    compute_by<add_up_coded>(options.instructions, samples, edge, profile, normal);
    return normal;
  });
}

}  // namespace ballservo
