#include "servo/features/ball_feature.hpp"

#include <visp3/visual_features/vpFeatureException.h>

#include <cmath>
#include <iostream>
#include <utility>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

namespace {

constexpr unsigned int rows = 3, middle = 1;
constexpr double min_level_distance_m = 1e-6;  // nearer to the vertical through F there is no azimuth

bool selects(unsigned int select, unsigned int row) {
  return (select & vpBasicFeature::FEATURE_LINE[row]) != 0;
}

Eigen::Matrix3d cross(const Eigen::Vector3d& p) {
  Eigen::Matrix3d m;
  m << 0, -p.z(), p.y(),  //
      p.z(), 0, -p.x(),   //
      -p.y(), p.x(), 0;
  return m;
}

}  // namespace

BallFeature::BallFeature(const char* name, const Eigen::Isometry3d& X_FC, MiddleRow middle_row,
                         CoordinatesOf coordinates_of)
    : name_(name), X_FC_(X_FC), middle_row_(middle_row), coordinates_of_(std::move(coordinates_of)) {
  BallFeature::init();
}

void BallFeature::init() {
  dim_s = rows;
  s.resize(rows);
  L_.setZero();
}

bool BallFeature::defined_at(const Eigen::Vector3d& p_CB) const {
  return p_CB.allFinite() && coordinates_of_(X_FC_ * p_CB);
}

void BallFeature::buildFrom(const Eigen::Vector3d& p_CB) {
  if (!defined_at(p_CB)) {
    throw vpFeatureException(vpFeatureException::badInitializationError, "%s is not defined there", name_);
  }
  const Coordinates now = *coordinates_of_(X_FC_ * p_CB);
  for (unsigned int row = 0; row < rows; ++row) s[row] = now.s[row];
  const Eigen::Matrix3d by_p = now.ds_dq * X_FC_.linear();
  L_ << -by_p, by_p * cross(p_CB);
}

vpMatrix BallFeature::interaction(unsigned int select) {
  vpMatrix L(getDimension(select), 6);
  unsigned int filled = 0;
  for (unsigned int row = 0; row < rows; ++row) {
    if (!selects(select, row)) continue;
    for (unsigned int column = 0; column < 6; ++column) L[filled][column] = L_(row, column);
    ++filled;
  }
  return L;
}

vpColVector BallFeature::error(const vpBasicFeature& s_star, unsigned int select) {
  const vpColVector desired = s_star.get_s();
  if (desired.size() != rows) {
    throw vpFeatureException(vpFeatureException::sizeMismatchError, "%s: s* has another dimension", name_);
  }
  vpColVector e(getDimension(select));
  unsigned int filled = 0;
  for (unsigned int row = 0; row < rows; ++row) {
    if (!selects(select, row)) continue;
    const bool angle = row == middle && middle_row_ == MiddleRow::angle;
    e[filled++] = angle ? wrap_angle(s[row] - desired[row]) : s[row] - desired[row];
  }
  return e;
}

void BallFeature::print(unsigned int select) const { get_s(select).t().print(std::cout, 10, name_); }

Eigen::Matrix3d ahead_left_up() {
  Eigen::Matrix3d R_FC;
  R_FC << 0, 0, 1,  //
      -1, 0, 0,     //
      0, -1, 0;
  return R_FC;
}

ConeFeature::ConeFeature(const Eigen::Matrix3d& R_FC)
    : BallFeature("ConeFeature (log range, azimuth, elevation): ", Eigen::Isometry3d(R_FC), MiddleRow::angle,
                  [](const Eigen::Vector3d& q) -> std::optional<Coordinates> {
                    if (!(std::hypot(q.x(), q.y()) > min_level_distance_m)) return std::nullopt;
                    const double a = q.x(), b = q.y(), c = q.z();
                    const double rho2 = q.squaredNorm(), r2 = a * a + b * b, r = std::sqrt(r2);
                    Coordinates now{{std::log(q.norm()), std::atan2(b, a), std::atan2(c, r)}, {}};
                    now.ds_dq << a / rho2, b / rho2, c / rho2,  //
                        -b / r2, a / r2, 0,                     //
                        -a * c / (r * rho2), -b * c / (r * rho2), r / rho2;
                    return now;
                  }) {}

FloorFeature::FloorFeature(const Eigen::Isometry3d& X_RC)
    : BallFeature("FloorFeature (range, bearing, height): ", X_RC, MiddleRow::angle,
                  [](const Eigen::Vector3d& p_RB) -> std::optional<Coordinates> {
                    const double x = p_RB.x(), y = p_RB.y(), r2 = x * x + y * y, r = std::hypot(x, y);
                    if (!(r > min_level_distance_m)) return std::nullopt;
                    Coordinates now{{r, std::atan2(y, x), p_RB.z()}, {}};
                    now.ds_dq << x / r, y / r, 0,  //
                        -y / r2, x / r2, 0,        //
                        0, 0, 1;
                    return now;
                  }) {}

SphereFeature::SphereFeature(double radius_m, const Eigen::Matrix3d& R_FC)
    : BallFeature("SphereFeature (centre over radius): ", Eigen::Isometry3d(R_FC), MiddleRow::length,
                  [radius_m](const Eigen::Vector3d& q) -> std::optional<Coordinates> {
                    return Coordinates{q / radius_m, Eigen::Matrix3d::Identity() / radius_m};
                  }) {}

}  // namespace ballservo
