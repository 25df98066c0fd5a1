#include "servo/features/ball_feature.hpp"

#include <visp3/visual_features/vpFeatureException.h>

#include <iostream>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

namespace {

constexpr unsigned int rows = 3, middle = 1;

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

BallFeature::BallFeature(const Eigen::Isometry3d& X_FC, MiddleRow middle_row)
    : X_FC_(X_FC), middle_row_(middle_row) {
  BallFeature::init();
}

void BallFeature::init() {
  dim_s = rows;
  s.resize(rows);
  L_.setZero();
}

bool BallFeature::defined_at(const Eigen::Vector3d& p_CB) const {
  return p_CB.allFinite() && defined(X_FC_ * p_CB);
}

void BallFeature::buildFrom(const Eigen::Vector3d& p_CB) {
  if (!defined_at(p_CB)) {
    throw vpFeatureException(vpFeatureException::badInitializationError, "%s is not defined there", name());
  }
  Eigen::Matrix3d derivative;
  const Eigen::Vector3d value = coordinates(X_FC_ * p_CB, derivative);
  for (unsigned int row = 0; row < rows; ++row) s[row] = value[row];
  const Eigen::Matrix3d by_p = derivative * X_FC_.linear();
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
    throw vpFeatureException(vpFeatureException::sizeMismatchError, "%s: s* has another dimension", name());
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

void BallFeature::print(unsigned int select) const { get_s(select).t().print(std::cout, 10, name()); }

Eigen::Matrix3d ahead_left_up() {
  Eigen::Matrix3d R_FC;
  R_FC << 0, 0, 1,  //
      -1, 0, 0,     //
      0, -1, 0;
  return R_FC;
}

}  // namespace ballservo
