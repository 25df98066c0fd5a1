#include "calibration/camera/lens/lens_domain.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/camera/lens/lens_models.hpp"

namespace ballservo {
namespace {

constexpr int outward_steps = 1024, directions = 32;

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

/// A map of the plane at one point: its value there and its derivative.
struct Mapped {
  Eigen::Vector2d value;
  Eigen::Matrix2d jacobian;
};
template <class Map>
Mapped mapped(const Eigen::Vector2d& at, const Map& map) {
  const auto image = map(Dual<2>::variable(at.x(), 0), Dual<2>::variable(at.y(), 1));
  Mapped result;
  result.value << image.x.a, image.y.a;
  result.jacobian.row(0) = image.x.v;
  result.jacobian.row(1) = image.y.v;
  return result;
}

/// From the chart to the normalised position.
template <class Lens>
Mapped distort_chart(const double* coefficients, const Eigen::Vector2d& w) {
  const auto k = lens_constants<Lens, Dual<2>>(coefficients);
  return mapped(w, [&](const Dual<2>& a, const Dual<2>& b) {
    return Lens::distort(k.data(), ray_of_chart<Lens>(a, b));
  });
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

/// How far outwards (`limit` at most) a map of the plane stays one-to-one: `at(t, direction)` is it at the
/// point that the parameter t stands for.
template <class At>
double one_to_one_limit(double limit, const At& at) {
  double smallest = limit;
  for (int d = 0; d < directions; ++d) {
    const Eigen::Vector2d direction(std::cos(2 * M_PI * d / directions), std::sin(2 * M_PI * d / directions));
    // A pole of a rational lens has a positive determinant on both sides: there the sign of the distance
    // itself changes.
    const auto is_good = [&](double t) {
      const Mapped there = at(t, direction);
      return there.jacobian.determinant() > 0 && direction.dot(there.jacobian * direction) > 0 &&
             direction.dot(there.value) > 0;
    };
    double good = 0;
    for (int i = 1; i < outward_steps && good < smallest; ++i) {
      const double t = limit * i / outward_steps;
      if (!is_good(t)) {
        smallest = std::min(smallest, last_good(good, t, is_good));
        break;
      }
      good = t;
    }
  }
  return smallest;
}

template <class Lens>
LensDomain find_domain(const double* coefficients) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if constexpr (IsDefinedFromPixel<Lens>::value) {
    const auto k = lens_constants<Lens, Dual<2>>(coefficients);
    // Radii from 0 to infinity are the tangents of the parameter.
    const auto ray_at = [&](double t, const Eigen::Vector2d& direction) {
      return mapped(std::tan(t) * direction, [&](const Dual<2>& x, const Dual<2>& y) {
        return Lens::undistort(k.data(), Position2<Dual<2>>{x, y});
      });
    };
    const double edge = one_to_one_limit(M_PI / 2, ray_at);
    if (edge == M_PI / 2) return {M_PI / 2, infinity};
    return {std::atan(ray_at(edge, Eigen::Vector2d::UnitX()).value.norm()), std::tan(edge)};
  } else {
    const auto position_at = [&](double angle_rad, const Eigen::Vector2d& direction) {
      return distort_chart<Lens>(coefficients, chart_radius<Lens>(angle_rad) * direction);
    };
    return {one_to_one_limit(Lens::perspective ? M_PI / 2 : M_PI, position_at), infinity};
  }
}

/// Newton's method in the chart with halved steps; true if it ends on the position, inside the domain. After
/// a step this small only its square is left, which is nothing.
template <class Lens>
bool solve_chart(const double* k, double max_chart_radius, const Eigen::Vector2d& position,
                 Eigen::Vector2d& w) {
  constexpr double last_step = 1e-8;
  const double accepted = 1e-13 * (1 + position.norm());
  Mapped here = distort_chart<Lens>(k, w);
  double error = (position - here.value).norm();
  for (int i = 0; i < 50; ++i) {
    if (!std::isfinite(error)) return false;
    if (error == 0) break;
    const Eigen::Vector2d step = here.jacobian.inverse() * (position - here.value);
    if (!step.allFinite()) return false;
    if (step.norm() < last_step) {
      w += step;
      return w.norm() < max_chart_radius;
    }
    bool improved = false;
    for (double scale = 1; scale > 1e-4 && !improved; scale *= 0.5) {
      const Eigen::Vector2d trial = w + scale * step;
      if (trial.norm() < max_chart_radius) {
        const Mapped there = distort_chart<Lens>(k, trial);
        const double trial_error = (position - there.value).norm();
        if (trial_error < error) {
          w = trial, here = there, error = trial_error, improved = true;
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
  double low = 0, high = max_chart_radius;
  if (!std::isfinite(high)) {
    for (high = std::max(1.0, distance); high < 1e9; high *= 2)
      if (direction.dot(distort_chart<Lens>(k, high * direction).value) >= distance) break;
  }
  double radius = std::min(distance, 0.5 * (low + high));
  for (int i = 0; i < 80; ++i) {
    const Mapped here = distort_chart<Lens>(k, radius * direction);
    const double excess = direction.dot(here.value) - distance;
    (excess < 0 ? low : high) = radius;
    double next = radius - excess / direction.dot(here.jacobian * direction);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - radius) <= 1e-12 * (1 + radius)) return next;
    radius = next;
  }
  return radius;
}

template <class Lens>
std::optional<Eigen::Vector3d> solve(const double* k, const LensDomain& domain,
                                     const Eigen::Vector2d& position,
                                     const std::optional<Eigen::Vector3d>& guess) {
  if constexpr (IsDefinedFromPixel<Lens>::value) {
    if (!(position.norm() < domain.max_radius)) return std::nullopt;
    const auto ray = Lens::undistort(k, Position2<double>{position.x(), position.y()});
    return Eigen::Vector3d(ray.x, ray.y, ray.z);
  } else {
    const double max_chart_radius = chart_radius<Lens>(domain.max_angle_rad);
    const auto ray_at = [](const Eigen::Vector2d& w) {
      const auto ray = ray_of_chart<Lens>(w.x(), w.y());
      return Eigen::Vector3d(ray.x, ray.y, ray.z);
    };
    if (guess && (!Lens::perspective || guess->z() > 0)) {
      Eigen::Vector2d w = guess->head<2>();
      if constexpr (Lens::perspective)
        w /= guess->z();
      else if (w.norm() > 0)
        w *= std::atan2(w.norm(), guess->z()) / w.norm();
      if (w.norm() < max_chart_radius && solve_chart<Lens>(k, max_chart_radius, position, w))
        return ray_at(w);
    }
    const double distance = position.norm();
    if (distance == 0) return Eigen::Vector3d(0, 0, 1);
    const Eigen::Vector2d direction = position / distance;
    Eigen::Vector2d w = radial_start<Lens>(k, max_chart_radius, distance, direction) * direction;
    // Not the very edge, where the Jacobian is singular.
    if (w.norm() >= max_chart_radius) w *= (1 - 1e-6) * max_chart_radius / w.norm();
    if (!solve_chart<Lens>(k, max_chart_radius, position, w)) return std::nullopt;
    return ray_at(w);
  }
}

}  // namespace

LensDomain find_lens_domain(LensModel model, const double* coefficients) {
  return with_lens(model, [&](auto lens) { return find_domain<decltype(lens)>(coefficients); });
}

std::optional<Eigen::Vector3d> solve_ray(LensModel model, const double* coefficients,
                                         const LensDomain& domain, const Eigen::Vector2d& position,
                                         const std::optional<Eigen::Vector3d>& guess) {
  if (!position.allFinite()) return std::nullopt;
  return with_lens(model,
                   [&](auto lens) { return solve<decltype(lens)>(coefficients, domain, position, guess); });
}

}  // namespace ballservo
