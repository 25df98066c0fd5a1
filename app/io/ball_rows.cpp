#include "app/io/ball_rows.hpp"

#include <fmt/format.h>

#include <array>

#include "calibration/base/numbers.hpp"

namespace ballservo {

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string ball_rows_header() {
  return "source,frame,time_s,track_id,class,state,quality,cx_px,cy_px,r_px,x_m,y_m,z_m,sxx_m2,sxy_m2,sxz_m2,"
         "syy_m2,syz_m2,"
         "szz_m2\n";
}

std::string ball_row(const BallRowLabel& label, const BallObservation& ball) {
  std::string row = fmt::format(
      "{},{},{},{},{},{},{},{},{},{}", csv_cell(label.source), label.frame, number_text(label.time_s),
      label.track_id ? std::to_string(*label.track_id) : "", csv_cell(label.color_class), label.state,
      number_text(ball.quality), number_text(ball.outline.center_px.x()),
      number_text(ball.outline.center_px.y()), number_text(ball.outline.radius_px));
  std::array<std::string, 9> position;
  if (ball.position) {
    const Eigen::Vector3d& p = ball.position->p_C;
    const Eigen::Matrix3d& s = ball.position->covariance_m2;
    const std::array<double, 9> numbers{p.x(),   p.y(),   p.z(),   s(0, 0), s(0, 1),
                                        s(0, 2), s(1, 1), s(1, 2), s(2, 2)};
    for (std::size_t i = 0; i < numbers.size(); ++i) position[i] = number_text(numbers[i]);
  }
  for (const std::string& cell : position) row += ',' + cell;
  return row + '\n';
}

}  // namespace ballservo
