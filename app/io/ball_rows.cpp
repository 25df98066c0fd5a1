#include "app/io/ball_rows.hpp"

#include "calibration/base/csv_table.hpp"

namespace ballservo {

std::string ball_rows_header() {
  return "source,frame,time_s,track_id,class,state,quality,cx_px,cy_px,r_px,x_m,y_m,z_m,sxx_m2,sxy_m2,sxz_m2,"
         "syy_m2,syz_m2,szz_m2\n";
}

std::string ball_row(const BallRowLabel& label, const BallObservation& ball) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  const auto& outline = ball.outline;
  const Eigen::Vector3d p = ball.position ? ball.position->p_C : Eigen::Vector3d::Constant(unknown);
  const Eigen::Matrix3d s = ball.position ? ball.position->covariance_m2 : Eigen::Matrix3d::Constant(unknown);
  return csv_row(label.source, label.frame, label.time_s, label.track_id, label.color_class, label.state,
                 ball.quality, outline.center_px.x(), outline.center_px.y(), outline.radius_px, p.x(), p.y(),
                 p.z(), s(0, 0), s(0, 1), s(0, 2), s(1, 1), s(1, 2), s(2, 2));
}

}  // namespace ballservo
