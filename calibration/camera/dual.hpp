// Forward-mode automatic differentiation with a handful of derivatives, for the lens formulas.
//
// Members are called as in ceres::Jet, so that one template serves both (`scalar_part`).
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace ballservo {

/// A number and its derivatives by N variables.
template <int N>
struct Dual {
  double a = 0;                        ///< value
  Eigen::Matrix<double, N, 1> v = {};  ///< derivatives

  Dual() { v.setZero(); }
  Dual(double value) : a(value) { v.setZero(); }  // NOLINT: numbers in formulas convert by themselves
  Dual(double value, const Eigen::Matrix<double, N, 1>& derivatives) : a(value), v(derivatives) {}
  /// The variable of the given index itself.
  static Dual variable(double value, int index) { return {value, Eigen::Matrix<double, N, 1>::Unit(index)}; }

  friend Dual operator-(const Dual& x) { return {-x.a, -x.v}; }
  friend Dual operator+(const Dual& x, const Dual& y) { return {x.a + y.a, x.v + y.v}; }
  friend Dual operator-(const Dual& x, const Dual& y) { return {x.a - y.a, x.v - y.v}; }
  friend Dual operator*(const Dual& x, const Dual& y) { return {x.a * y.a, x.v * y.a + y.v * x.a}; }
  friend Dual operator/(const Dual& x, const Dual& y) {
    const double quotient = x.a / y.a;
    return {quotient, (x.v - y.v * quotient) / y.a};
  }
  friend Dual operator+(const Dual& x, double y) { return {x.a + y, x.v}; }
  friend Dual operator+(double x, const Dual& y) { return {x + y.a, y.v}; }
  friend Dual operator-(const Dual& x, double y) { return {x.a - y, x.v}; }
  friend Dual operator-(double x, const Dual& y) { return {x - y.a, -y.v}; }
  friend Dual operator*(const Dual& x, double y) { return {x.a * y, x.v * y}; }
  friend Dual operator*(double x, const Dual& y) { return {x * y.a, y.v * x}; }
  friend Dual operator/(const Dual& x, double y) { return {x.a / y, x.v / y}; }
};

template <int N>
Dual<N> sqrt(const Dual<N>& x) {
  const double root = std::sqrt(x.a);
  return {root, x.v / (2 * root)};
}

template <int N>
Dual<N> sin(const Dual<N>& x) {
  return {std::sin(x.a), x.v * std::cos(x.a)};
}

template <int N>
Dual<N> cos(const Dual<N>& x) {
  return {std::cos(x.a), x.v * -std::sin(x.a)};
}

template <int N>
Dual<N> atan2(const Dual<N>& y, const Dual<N>& x) {
  return {std::atan2(y.a, x.a), (y.v * x.a - x.v * y.a) / (x.a * x.a + y.a * y.a)};
}

/// The value without derivatives, of a double, a Dual or a ceres::Jet.
inline double scalar_part(double x) { return x; }
template <class Jet>
double scalar_part(const Jet& x) {
  return x.a;
}

}  // namespace ballservo
