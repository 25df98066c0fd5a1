#include "tests/bench/painted_frame.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ballservo::bench {
namespace {

using Color = cv::Vec3f;  // linear light: blue, green, red
const Color ball_color(0.07f, 0.6f, 0.09f);

double soft_step(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

Color muted_color(RandomEngine& engine) {
  Color color;
  for (int c = 0; c < 3; ++c) color[c] = static_cast<float>(uniform(engine, 0.08, 0.6));
  color[1] = std::min(color[1], 1.3f * std::max(color[0], color[2]));  // not the ball's
  return color;
}

Color near_color(RandomEngine& engine) {
  Color color = ball_color * static_cast<float>(uniform(engine, 0.5, 1.2));
  color[0] *= static_cast<float>(uniform(engine, 0.8, 2.2));
  color[2] *= static_cast<float>(uniform(engine, 0.8, 2.2));
  return color;
}

// Colours that change over the picture: a ramp between two, and waves upon it.
class ColorField {
 public:
  ColorField(const Color& a, const Color& b, double scale_px, double waviness, RandomEngine& engine)
      : a_(a), b_(b), waviness_(waviness) {
    const double turn = uniform(engine, 0, 2 * M_PI);
    ramp_ = Eigen::Vector2d(std::cos(turn), std::sin(turn)) / scale_px;
    phase_ = uniform01(engine);
    for (Wave& wave : waves_) {
      const double direction = uniform(engine, 0, 2 * M_PI),
                   length_px = scale_px * uniform(engine, 0.08, 0.5);
      wave.k = Eigen::Vector2d(std::cos(direction), std::sin(direction)) * (2 * M_PI / length_px);
      wave.phase = uniform(engine, 0, 2 * M_PI);
    }
  }
  Color at(double u, double v) const {
    const Eigen::Vector2d p(u, v);
    double share = 0.5 - 0.5 * std::cos(M_PI * (p.dot(ramp_) + phase_));
    double wave = 0;
    for (const Wave& w : waves_) wave += std::sin(p.dot(w.k) + w.phase);
    share = std::clamp(share + waviness_ * wave / static_cast<double>(waves_.size()), 0.0, 1.0);
    return a_ * static_cast<float>(1 - share) + b_ * static_cast<float>(share);
  }

 private:
  struct Wave {
    Eigen::Vector2d k{0, 0};
    double phase = 0;
  };
  Color a_, b_;
  double waviness_, phase_ = 0;
  Eigen::Vector2d ramp_{0, 0};
  std::array<Wave, 4> waves_;
};

// A rectangle, ellipse or part of one, by its signed distance (px, negative inside).
struct PaintedShape {
  Eigen::Vector2d center_px{0, 0}, half_px{10, 10};
  double turn_rad = 0;
  bool round = false;
  double cut = 2;  // of a round one, only what lies below this fraction of its half height

  double distance_px(double u, double v) const {
    const double c = std::cos(turn_rad), s = std::sin(turn_rad), du = u - center_px.x(),
                 dv = v - center_px.y();
    const Eigen::Vector2d p(c * du + s * dv, -s * du + c * dv);
    if (!round) {
      const Eigen::Vector2d q = p.cwiseAbs() - half_px;
      return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
    }
    // First-order distance of an ellipse.
    const Eigen::Vector2d unit = p.cwiseQuotient(half_px);
    const double level = unit.norm();
    const double slope = unit.cwiseQuotient(half_px).norm() / std::max(level, 1e-9);
    return std::max((level - 1) / std::max(slope, 1e-9), p.y() - cut * half_px.y());
  }
};

void paint(cv::Mat& picture, const PaintedShape& shape, const ColorField& colors) {
  const double reach = shape.half_px.norm() + 2;
  const cv::Rect box =
      cv::Rect(static_cast<int>(shape.center_px.x() - reach), static_cast<int>(shape.center_px.y() - reach),
               static_cast<int>(2 * reach) + 2, static_cast<int>(2 * reach) + 2) &
      cv::Rect({0, 0}, picture.size());
  for (int v = box.y; v < box.y + box.height; ++v) {
    for (int u = box.x; u < box.x + box.width; ++u) {
      const auto share = static_cast<float>(std::clamp(0.5 - shape.distance_px(u, v), 0.0, 1.0));
      if (share <= 0) continue;
      Color& pixel = picture.at<Color>(v, u);
      pixel = pixel * (1 - share) + colors.at(u, v) * share;
    }
  }
}

cv::Mat pixels_outside(const PaintedShape& shape, const cv::Size& size) {
  cv::Mat outside(size, CV_8UC1);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u)
      outside.at<std::uint8_t>(v, u) = shape.distance_px(u, v) > 0.5 ? 255 : 0;
  }
  return outside;
}

PaintedShape random_shape(const cv::Size& size, double low_px, double high_px, RandomEngine& engine) {
  PaintedShape shape;
  shape.center_px = {uniform(engine, 0, size.width), uniform(engine, 0, size.height)};
  shape.half_px = {0.5 * uniform(engine, low_px, high_px), 0.5 * uniform(engine, low_px, high_px)};
  shape.turn_rad = uniform(engine, 0, M_PI);
  return shape;
}

// The ball's surface in its light.
class BallPaint {
 public:
  BallPaint(const PaintedLook& look, const Eigen::Vector3d& to_camera, RandomEngine& engine) : look_(look) {
    const Eigen::Matrix<double, 3, 2> across = perpendicular_basis(to_camera);
    const auto around = [&](double from_camera_rad) -> Eigen::Vector3d {
      const double azimuth = uniform(engine, 0, 2 * M_PI);
      return std::cos(from_camera_rad) * to_camera +
             std::sin(from_camera_rad) * (across * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth)));
    };
    to_lamp_ = around(uniform(engine, 0.1, 1.5));
    half_vector_ = (to_lamp_ + to_camera).normalized();
    shadow_side_ = around(M_PI / 2);
    sky_ = {0, -1, 0};
    lamp_ = uniform(engine, 0.5, 0.8);
    ambient_ = uniform(engine, 0.3, 0.5);
    terminator_ = uniform(engine, 0.05, 0.3);
    shadow_width_ = uniform(engine, 0.1, 0.5);
    shadow_place_ = uniform(engine, -0.3, 0.3);
    gloss_ = uniform(engine, 0.3, 0.9);
    shininess_ = uniform(engine, 20, 200);
    for (Eigen::Vector3d& vein : veins_)
      vein = Eigen::Vector3d(uniform(engine, -9, 9), uniform(engine, -9, 9), uniform(engine, -9, 9));
  }
  Color at(const Eigen::Vector3d& normal) const {
    const double facing = normal.dot(to_lamp_);
    double light = 0.5 * (facing + std::hypot(facing, terminator_));
    if (look_.half_shade)
      light *= soft_step((normal.dot(shadow_side_) - shadow_place_) / shadow_width_ + 0.5);
    double albedo = 1;
    if (look_.marbled) {
      double vein = 0;
      for (const Eigen::Vector3d& k : veins_)
        vein += std::sin(k.dot(normal) + 2 * std::sin(k.z() * normal.x() - k.x() * normal.y()));
      albedo = 0.75 + 0.25 * std::tanh(1.5 * vein);
    }
    const double sky = ambient_ * (0.8 + 0.2 * normal.dot(sky_));
    Color color = ball_color * static_cast<float>(albedo * (lamp_ * light + sky));
    if (look_.highlight) {
      const double glint = gloss_ * lamp_ * std::pow(std::max(0.0, normal.dot(half_vector_)), shininess_);
      color += Color::all(static_cast<float>(facing > 0 ? glint : 0));
    }
    return color;
  }

 private:
  PaintedLook look_;
  Eigen::Vector3d to_lamp_, half_vector_, shadow_side_, sky_;
  double lamp_, ambient_, terminator_, shadow_width_, shadow_place_, gloss_, shininess_;
  std::array<Eigen::Vector3d, 3> veins_;
};

// Rays through 64 places of every pixel near the ball. No two places of a pixel share a row or column of
// sixty-fourths.
void paint_ball(cv::Mat& picture, const Camera& camera, const Eigen::Vector3d& p_CB,
                const OutlineEllipse& outline, const BallPaint& surface) {
  constexpr int side = 8;
  const double reach = 1.15 * outline.radius_px + 3,
               radius2 = accuracy_ball_radius_m * accuracy_ball_radius_m;
  const cv::Rect box = cv::Rect(static_cast<int>(outline.center_px.x() - reach),
                                static_cast<int>(outline.center_px.y() - reach),
                                static_cast<int>(2 * reach) + 2, static_cast<int>(2 * reach) + 2) &
                       cv::Rect({0, 0}, picture.size());
  for (int v = box.y; v < box.y + box.height; ++v) {
    for (int u = box.x; u < box.x + box.width; ++u) {
      Color sum(0, 0, 0);
      int hits = 0;
      for (int k = 0; k < side * side; ++k) {
        const int i = k % side, j = k / side;
        const double du = (i + (j + 0.5) / side) / side - 0.5, dv = (j + (i + 0.5) / side) / side - 0.5;
        const auto ray = camera.unproject({u + du, v + dv});
        if (!ray) continue;
        const double along = ray->dot(p_CB), depth2 = radius2 - (p_CB.squaredNorm() - along * along);
        if (depth2 <= 0 || along <= 0) continue;
        const Eigen::Vector3d normal = (*ray * (along - std::sqrt(depth2)) - p_CB) / accuracy_ball_radius_m;
        sum += surface.at(normal);
        ++hits;
      }
      if (hits == 0) continue;
      Color& pixel = picture.at<Color>(v, u);
      pixel = pixel * (1 - static_cast<float>(hits) / (side * side)) + sum * (1.0f / (side * side));
    }
  }
}

// The soft dark patch below a ball that lies on something.
void paint_contact_shadow(cv::Mat& picture, const OutlineEllipse& ball, RandomEngine& engine) {
  const double depth = uniform(engine, 0.4, 0.8);
  const Eigen::Vector2d center =
      ball.center_px +
      ball.radius_px * Eigen::Vector2d(uniform(engine, -0.4, 0.4), uniform(engine, 0.7, 0.95));
  const Eigen::Vector2d size =
      ball.radius_px * Eigen::Vector2d(uniform(engine, 0.7, 1.1), uniform(engine, 0.25, 0.5));
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u) {
      const double d2 = (Eigen::Vector2d(u, v) - center).cwiseQuotient(size).squaredNorm();
      if (d2 < 30) picture.at<Color>(v, u) *= static_cast<float>(1 - depth * std::exp(-0.5 * d2));
    }
  }
}

// With noise, and in `clean` without.
cv::Mat exposed(const cv::Mat& light, const AccuracyCondition& condition, RandomEngine& engine,
                cv::Mat& clean) {
  cv::Mat blurred;
  cv::GaussianBlur(light, blurred, {}, condition.blur_px);
  cv::Mat bgr(light.size(), CV_8UC3);
  clean.create(light.size(), CV_32FC3);
  for (int v = 0; v < light.rows; ++v) {
    for (int u = 0; u < light.cols; ++u) {
      for (int c = 0; c < 3; ++c) {
        const double level = std::clamp<double>(blurred.at<Color>(v, u)[c], 0.0, 1.0);
        const double grey = 255 * (condition.gamma == 1 ? level : std::pow(level, 1 / condition.gamma));
        clean.at<cv::Vec3f>(v, u)[c] = static_cast<float>(grey);
        bgr.at<cv::Vec3b>(v, u)[c] =
            cv::saturate_cast<uchar>(grey + condition.noise * standard_normal(engine));
      }
    }
  }
  return bgr;
}

}  // namespace

AccuracyFrame painted_frame(const AccuracyCondition& condition, RandomEngine& engine) {
  const Camera camera = accuracy_camera(condition);
  AccuracyFrame frame;
  const bool has_ball = condition.neighbour != Neighbour::no_ball;
  const cv::Size size(camera.size().width_px, camera.size().height_px);
  cv::Mat picture(size, CV_32FC3);
  const ColorField background(muted_color(engine), muted_color(engine), uniform(engine, 200, 700),
                              uniform(engine, 0, 0.4), engine);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) picture.at<Color>(v, u) = background.at(u, v);
  }
  const auto field = [&](const Color& color) {
    return ColorField(color, color * static_cast<float>(uniform(engine, 0.4, 1.0)), uniform(engine, 40, 300),
                      uniform(engine, 0, 0.4), engine);
  };
  if (has_ball) {
    frame.p_CB = accuracy_place(condition, camera, engine);
    frame.truth = project_sphere(camera, frame.p_CB, accuracy_ball_radius_m);
    frame.visible_fraction = 1 - condition.hidden;
  }
  for (int k = 0; k < 40; ++k) {
    PaintedShape shape = random_shape(size, 15, 150, engine);
    shape.round = uniform01(engine) < 0.4;
    paint(picture, shape, field(muted_color(engine)));
  }
  const int near_things = has_ball ? condition.distractors : 8;
  for (int k = 0, attempts = 0; k < near_things && attempts < 100; ++attempts) {
    PaintedShape shape = random_shape(size, 15, 110, engine);
    if (frame.truth && (shape.center_px - frame.truth->center_px).norm() <
                           1.15 * frame.truth->radius_px + shape.half_px.norm())
      continue;
    // Round ones are flat ovals, or parts of discs.
    shape.round = uniform01(engine) < 0.5;
    if (shape.round && uniform01(engine) < 0.5) {
      shape.half_px.y() = shape.half_px.x() * uniform(engine, 0.85, 1.15);
      shape.cut = hiding_edge_distance(uniform(engine, 0.55, 0.8));
    } else if (shape.round) {
      shape.half_px.y() = shape.half_px.x() * uniform(engine, 0.3, 0.75);
    }
    paint(picture, shape, field(near_color(engine)));
    ++k;
  }
  if (has_ball) {
    if (condition.look.contact_shadow) paint_contact_shadow(picture, *frame.truth, engine);
    paint_ball(picture, camera, frame.p_CB, *frame.truth,
               BallPaint(condition.look, -frame.p_CB.normalized(), engine));
    if (condition.hidden > 0) {
      const double turn = uniform(engine, 0, 2 * M_PI), half_px = 3 * frame.truth->radius_px;
      const double shift_px = hiding_edge_distance(condition.hidden) * frame.truth->radius_px + half_px;
      PaintedShape card;
      card.center_px = frame.truth->center_px + shift_px * Eigen::Vector2d(std::cos(turn), std::sin(turn));
      card.half_px = {half_px, half_px};
      card.turn_rad = turn;
      paint(picture, card, field(muted_color(engine)));
      frame.unhidden = pixels_outside(card, size);
    }
  }
  frame.bgr = exposed(picture, condition, engine, frame.clean_bgr);
  return frame;
}

}  // namespace ballservo::bench
