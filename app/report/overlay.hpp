// What was found, drawn into the picture it was found in.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calibration/camera/camera.hpp"
#include "calibration/color/color_table.hpp"
#include "perception/ball_observation.hpp"

namespace ballservo {

/// The mean colour (BGR) of a class's cells in the table: what to draw the class in.
cv::Scalar class_display_color(const ColorTable& colors, ClassIndex color_class);

/// A closed or open line through points given to a fraction of a pixel, antialiased.
void draw_polyline(cv::Mat& bgr, const std::vector<Eigen::Vector2d>& points_px, bool closed,
                   const cv::Scalar& color, int thickness = 1);

/// The area within such a line, and a circle or, `thickness` cv::FILLED, a disc.
void fill_polygon(cv::Mat& bgr, const std::vector<Eigen::Vector2d>& points_px, const cv::Scalar& color);
void draw_circle(cv::Mat& bgr, const Eigen::Vector2d& center_px, double radius_px, const cv::Scalar& color,
                 int thickness = 1);
/// A place in the fixed-point coordinates that OpenCV draws by, and their fraction's bits.
inline constexpr int subpixel_bits = 5;
cv::Point subpixel(const Eigen::Vector2d& p);
/// A small cross.
void draw_cross(cv::Mat& bgr, const Eigen::Vector2d& center_px, const cv::Scalar& color);
/// White text with a black rim, to be read on anything; `at` is its lower left corner, `size` OpenCV's scale.
void draw_text(cv::Mat& bgr, const std::string& text, const cv::Point& at, double size);
/// The same about `at`, moved up or down to the nearest place in the picture where it covers none of
/// `others`, which it then joins.
void draw_text_apart(cv::Mat& bgr, const std::string& text, const cv::Point& at, double size,
                     std::vector<cv::Rect>& others);
/// The scale of labels in a picture of that width.
double label_scale(int width_px);

/// The ball's outline, its centre as a cross, and a label beside it.
void draw_ball(cv::Mat& bgr, const Camera& camera, const BallObservation& ball, const std::string& label,
               const cv::Scalar& color);

}  // namespace ballservo
