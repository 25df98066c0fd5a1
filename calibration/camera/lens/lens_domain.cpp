#include "calibration/camera/lens/lens_domain.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "calibration/camera/dual.hpp"
#include "calibration/camera/lens/lens_list.hpp"

namespace ballservo {
namespace {

constexpr int outward_steps = 1024, directions = 32;

template <class T, int count>
std::array<T, count + 1> constants(const double* coefficients) {
  std::array<T, count + 1> k;  // one more, so that a lens without coefficients has an array too
  for (int i = 0; i < count; ++i) k[static_cast<std::size_t>(i)] = T(coefficients[i]);
  k[count] = T(0.0);
  return k;
}

/// A two-dimensional chart of the rays: the plane Z = 1 for perspective lenses, equidistant polar coordinates
/// (angle from the axis times direction) for the others.
template <class Lens, class T>
Ray3<T> ray_of_chart(const T& a, const T& b) {
  if constexpr (Lens::perspective) {
    return {a, b, T(1.0)};
  } else {
    using std::cos;
    using std::sin;
    using std::sqrt;
    const T t2 = a * a + b * b;
    if (scalar_part(t2) < 1e-8) {
      const T sinc = 1.0 - t2 * (1.0 / 6) + t2 * t2 * (1.0 / 120);
      return {a * sinc, b * sinc, 1.0 - t2 * 0.5 + t2 * t2 * (1.0 / 24)};
    }
    const T t = sqrt(t2);
    const T sinc = sin(t) / t;
    return {a * sinc, b * sinc, cos(t)};
  }
}

/// The normalised position of a point of the chart, and its Jacobian by the chart.
template <class Lens>
void distort_chart(const double* coefficients, const Eigen::Vector2d& w, Eigen::Vector2d& m,
                   Eigen::Matrix2d& jacobian) {
  using T = Dual<2>;
  const auto k = constants<T, lens_coefficient_count<Lens>>(coefficients);
  const auto position =
      Lens::distort(k.data(), ray_of_chart<Lens>(T::variable(w.x(), 0), T::variable(w.y(), 1)));
  m << position.x.a, position.y.a;
  jacobian.row(0) = position.x.v;
  jacobian.row(1) = position.y.v;
}

template <class Lens>
double chart_radius(double angle_rad) {
  if constexpr (!Lens::perspective) return angle_rad;
  return angle_rad < M_PI / 2 ? std::tan(angle_rad) : std::numeric_limits<double>::infinity();
}

/// Bisects between an angle that is fine and one that is not.
template <class Predicate>
double last_good(double good, double bad, Predicate is_good) {
  for (int i = 0; i < 60 && bad - good > 1e-13; ++i) {
    const double middle = 0.5 * (good + bad);
    (is_good(middle) ? good : bad) = middle;
  }
  return good;
}

template <class Lens>
LensDomain find_domain_from_ray(const double* coefficients) {
  const double limit = Lens::perspective ? M_PI / 2 : M_PI;
  const auto k = constants<double, lens_coefficient_count<Lens>>(coefficients);
  double max_angle = limit;
  for (int d = 0; d < directions; ++d) {
    const Eigen::Vector2d direction(std::cos(2 * M_PI * d / directions), std::sin(2 * M_PI * d / directions));
    // A pole of a rational lens has a positive determinant on both sides: there the sign of the distance
    // itself changes.
    const auto is_good = [&](double angle) {
      Eigen::Vector2d m;
      Eigen::Matrix2d jacobian;
      distort_chart<Lens>(k.data(), chart_radius<Lens>(angle) * direction, m, jacobian);
      return jacobian.determinant() > 0 && direction.dot(jacobian * direction) > 0 && direction.dot(m) > 0;
    };
    double good = 0;
    for (int i = 1; i < outward_steps && good < max_angle; ++i) {
      const double angle = limit * i / outward_steps;
      if (is_good(angle)) {
        good = angle;
        continue;
      }
      max_angle = std::min(max_angle, last_good(good, angle, is_good));
      break;
    }
  }
  return {max_angle, std::numeric_limits<double>::infinity()};
}

template <class Lens>
LensDomain find_domain_from_pixel(const double* coefficients) {
  const auto k = constants<Dual<2>, lens_coefficient_count<Lens>>(coefficients);
  LensDomain domain{M_PI / 2, std::numeric_limits<double>::infinity()};
  for (int d = 0; d < directions; ++d) {
    const Eigen::Vector2d direction(std::cos(2 * M_PI * d / directions), std::sin(2 * M_PI * d / directions));
    // Radii from 0 to infinity are the tangents of these angles.
    const auto ray_at = [&](double t, Eigen::Matrix2d& jacobian) {
      const Eigen::Vector2d m = std::tan(t) * direction;
      const auto ray = Lens::undistort(
          k.data(), Position2<Dual<2>>{Dual<2>::variable(m.x(), 0), Dual<2>::variable(m.y(), 1)});
      jacobian.row(0) = ray.x.v;
      jacobian.row(1) = ray.y.v;
      return Eigen::Vector2d(ray.x.a, ray.y.a);
    };
    const auto is_good = [&](double t) {
      Eigen::Matrix2d jacobian;
      const Eigen::Vector2d ray = ray_at(t, jacobian);
      return jacobian.determinant() > 0 && direction.dot(jacobian * direction) > 0 && direction.dot(ray) > 0;
    };
    double good = 0;
    for (int i = 1; i < outward_steps; ++i) {
      const double t = M_PI / 2 * i / outward_steps;
      if (is_good(t)) {
        good = t;
        continue;
      }
      const double edge = last_good(good, t, is_good);
      Eigen::Matrix2d unused;
      domain.max_radius = std::min(domain.max_radius, std::tan(edge));
      domain.max_angle_rad = std::min(domain.max_angle_rad, std::atan(ray_at(edge, unused).norm()));
      break;
    }
  }
  return domain;
}

/// Newton's method in the chart with halved steps; true if it ends on the position, inside the domain.
template <class Lens>
bool solve_chart(const double* k, double max_chart_radius, const Eigen::Vector2d& position,
                 Eigen::Vector2d& w) {
  const double accepted = 1e-13 * (1 + position.norm());
  Eigen::Vector2d m;
  Eigen::Matrix2d jacobian;
  distort_chart<Lens>(k, w, m, jacobian);
  double error = (position - m).norm();
  for (int i = 0; i < 50; ++i) {
    if (!std::isfinite(error)) return false;
    if (error == 0) break;
    const Eigen::Vector2d step = jacobian.inverse() * (position - m);
    if (!step.allFinite()) return false;
    bool improved = false;
    for (double scale = 1; scale > 1e-4 && !improved; scale *= 0.5) {
      const Eigen::Vector2d trial = w + scale * step;
      if (trial.norm() < max_chart_radius) {
        Eigen::Vector2d trial_m;
        Eigen::Matrix2d trial_jacobian;
        distort_chart<Lens>(k, trial, trial_m, trial_jacobian);
        const double trial_error = (position - trial_m).norm();
        if (trial_error < error) {
          w = trial, m = trial_m, jacobian = trial_jacobian, error = trial_error, improved = true;
          continue;
        }
      }
      if (error <= accepted) return true;
    }
    if (!improved) break;
  }
  return error <= accepted;
}

/// The chart radius at which the lens reaches `distance` from the principal point towards `direction`:
/// Newton kept inside a bracket. The end of the domain where it never does.
template <class Lens>
double radial_start(const double* k, double max_chart_radius, double distance,
                    const Eigen::Vector2d& direction) {
  Eigen::Vector2d m;
  Eigen::Matrix2d jacobian;
  double low = 0, high = max_chart_radius;
  if (!std::isfinite(high)) {
    for (high = std::max(1.0, distance); high < 1e9; high *= 2) {
      distort_chart<Lens>(k, high * direction, m, jacobian);
      if (direction.dot(m) >= distance) break;
    }
  }
  double radius = std::min(distance, 0.5 * (low + high));
  for (int i = 0; i < 80; ++i) {
    distort_chart<Lens>(k, radius * direction, m, jacobian);
    const double excess = direction.dot(m) - distance;
    (excess < 0 ? low : high) = radius;
    double next = radius - excess / direction.dot(jacobian * direction);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - radius) <= 1e-12 * (1 + radius)) return next;
    radius = next;
  }
  return radius;
}

template <class Lens>
std::optional<Eigen::Vector3d> solve(const double* coefficients, const LensDomain& domain,
                                     const Eigen::Vector2d& position, const Eigen::Vector3d* guess) {
  const auto k = constants<double, lens_coefficient_count<Lens>>(coefficients);
  if constexpr (IsDefinedFromPixel<Lens>::value) {
    if (!(position.norm() < domain.max_radius)) return std::nullopt;
    const auto ray = Lens::undistort(k.data(), Position2<double>{position.x(), position.y()});
    return Eigen::Vector3d(ray.x, ray.y, ray.z);
  } else {
    const double max_chart_radius = chart_radius<Lens>(domain.max_angle_rad);
    const auto ray_at = [](const Eigen::Vector2d& w) {
      const auto ray = ray_of_chart<Lens>(w.x(), w.y());
      return Eigen::Vector3d(ray.x, ray.y, ray.z);
    };
    if (guess) {
      Eigen::Vector2d w = guess->head<2>();
      if constexpr (Lens::perspective)
        w /= guess->z();
      else if (w.norm() > 0)
        w *= std::atan2(w.norm(), guess->z()) / w.norm();
      if (w.norm() < max_chart_radius && solve_chart<Lens>(k.data(), max_chart_radius, position, w))
        return ray_at(w);
    }
    const double distance = position.norm();
    if (distance == 0) return Eigen::Vector3d(0, 0, 1);
    const Eigen::Vector2d direction = position / distance;
    Eigen::Vector2d w = radial_start<Lens>(k.data(), max_chart_radius, distance, direction) * direction;
    // Not the very edge, where the Jacobian is singular.
    if (w.norm() >= max_chart_radius) w *= (1 - 1e-6) * max_chart_radius / w.norm();
    if (!solve_chart<Lens>(k.data(), max_chart_radius, position, w)) return std::nullopt;
    return ray_at(w);
  }
}

}  // namespace

LensDomain find_lens_domain(LensModel model, const double* coefficients) {
  return with_lens(model, [&](auto lens) {
    using Lens = decltype(lens);
    if constexpr (IsDefinedFromPixel<Lens>::value)
      return find_domain_from_pixel<Lens>(coefficients);
    else
      return find_domain_from_ray<Lens>(coefficients);
  });
}

std::optional<Eigen::Vector3d> solve_ray(LensModel model, const double* coefficients,
                                         const LensDomain& domain, const Eigen::Vector2d& position,
                                         const Eigen::Vector3d* guess) {
  if (!position.allFinite()) return std::nullopt;
  return with_lens(model,
                   [&](auto lens) { return solve<decltype(lens)>(coefficients, domain, position, guess); });
}

}  // namespace ballservo
