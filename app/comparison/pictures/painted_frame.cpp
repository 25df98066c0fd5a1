// A picture painted without the simulator's renderer, in layers of linear light: a background of gradients,
// waves and shapes; the ball, traced with 64 rays a pixel through the camera's own model, with a soft
// terminator and perhaps highlight, marbling or half shade; an occluder; then blur, response, noise.

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "app/comparison/pictures/painters.hpp"

namespace ballservo {
namespace {

using Color = cv::Vec3f;  // linear light: blue, green, red

// Blue is the first channel here.
BallChannels channels_of(const ComparisonCondition& condition) {
  return BallChannels(2 - own_channel(condition.ball_color));
}

Color linear_ball_color(const BallChannels& channels) {
  Color color;
  color[channels.other_1] = 0.07f;
  color[channels.own] = 0.6f;
  color[channels.other_2] = 0.09f;
  return color;
}

double soft_step(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Any colour but the ball's.
Color muted_color(const BallChannels& channels, RandomEngine& engine) {
  Color color;
  for (int c = 0; c < 3; ++c) color[c] = static_cast<float>(uniform(engine, 0.08, 0.6));
  float& own = color[channels.own];
  own = std::min(own, 1.3f * std::max(color[channels.other_1], color[channels.other_2]));
  return color;
}

Color near_color(const BallChannels& channels, RandomEngine& engine) {
  Color color = linear_ball_color(channels) * static_cast<float>(uniform(engine, 0.5, 1.2));
  color[channels.other_1] *= static_cast<float>(uniform(engine, 0.8, 2.2));
  color[channels.other_2] *= static_cast<float>(uniform(engine, 0.8, 2.2));
  return color;
}

// Colours that change over the picture: a ramp between two, and waves upon it.
class ColorField {
 public:
  ColorField(const Color& a, const Color& b, double scale_px, double waviness, RandomEngine& engine)
      : a_(a), b_(b), waviness_(waviness) {
    const double turn = uniform(engine, 0, 2 * M_PI);
    ramp_ = unit_vector(turn) / scale_px;
    phase_ = uniform01(engine);
    for (Wave& wave : waves_) {
      const double direction = uniform(engine, 0, 2 * M_PI),
                   length_px = scale_px * uniform(engine, 0.08, 0.5);
      wave.k = unit_vector(direction) * (2 * M_PI / length_px);
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

// A colour and a darker one of it.
ColorField uneven(const Color& color, RandomEngine& engine) {
  const double waviness = uniform(engine, 0, 0.4), scale_px = uniform(engine, 40, 300);
  const Color darker = color * static_cast<float>(uniform(engine, 0.4, 1.0));
  return ColorField(color, darker, scale_px, waviness, engine);
}

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
  const int reach_px = static_cast<int>(shape.half_px.norm()) + 4;
  const cv::Rect box = square_around(shape.center_px, reach_px) & cv::Rect({0, 0}, picture.size());
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
  cv::Mat1b outside(size);
  outside.forEach(
      [&](std::uint8_t& pixel, const int* at) { pixel = shape.distance_px(at[1], at[0]) > 0.5 ? 255 : 0; });
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
struct BallPaint {
  PaintedLook look;
  Color color;
  struct {
    Eigen::Vector3d to_lamp;
    double lamp = 0, ambient = 0, terminator = 0;
  } light;
  struct {
    Eigen::Vector3d side;
    double width = 0, place = 0;
  } shadow;
  struct {
    Eigen::Vector3d half_vector;
    double strength = 0, shininess = 0;
  } gloss;
  std::array<Eigen::Vector3d, 3> veins;
};

BallPaint draw_paint(const ComparisonCondition& condition, const Eigen::Vector3d& to_camera,
                     RandomEngine& engine) {
  const Eigen::Matrix<double, 3, 2> across = perpendicular_basis(to_camera);
  const auto around = [&](double from_camera_rad) -> Eigen::Vector3d {
    return std::cos(from_camera_rad) * to_camera +
           std::sin(from_camera_rad) * (across * unit_vector(uniform(engine, 0, 2 * M_PI)));
  };
  BallPaint paint;
  paint.look = condition.look;
  paint.color = linear_ball_color(channels_of(condition));
  paint.light.to_lamp = around(uniform(engine, 0.1, 1.5));
  paint.gloss.half_vector = (paint.light.to_lamp + to_camera).normalized();
  paint.shadow.side = around(M_PI / 2);
  paint.light.lamp = uniform(engine, 0.5, 0.8);
  paint.light.ambient = uniform(engine, 0.3, 0.5);
  paint.light.terminator = uniform(engine, 0.05, 0.3);
  paint.shadow.width = uniform(engine, 0.1, 0.5);
  paint.shadow.place = uniform(engine, -0.3, 0.3);
  paint.gloss.strength = uniform(engine, 0.3, 0.9);
  paint.gloss.shininess = uniform(engine, 20, 200);
  for (Eigen::Vector3d& vein : paint.veins)
    vein = Eigen::Vector3d(uniform(engine, -9, 9), uniform(engine, -9, 9), uniform(engine, -9, 9));
  return paint;
}

Color color_at(const BallPaint& paint, const Eigen::Vector3d& normal) {
  const double facing = normal.dot(paint.light.to_lamp);
  double light = 0.5 * (facing + std::hypot(facing, paint.light.terminator));
  if (paint.look.half_shade)
    light *= soft_step((normal.dot(paint.shadow.side) - paint.shadow.place) / paint.shadow.width + 0.5);
  double albedo = 1;
  if (paint.look.marbled) {
    double vein = 0;
    for (const Eigen::Vector3d& k : paint.veins)
      vein += std::sin(k.dot(normal) + 2 * std::sin(k.z() * normal.x() - k.x() * normal.y()));
    albedo = 0.75 + 0.25 * std::tanh(1.5 * vein);
  }
  const double sky = paint.light.ambient * (0.8 - 0.2 * normal.y());  // brighter above
  Color color = paint.color * static_cast<float>(albedo * (paint.light.lamp * light + sky));
  if (paint.look.highlight && facing > 0) {
    const double along = std::max(0.0, normal.dot(paint.gloss.half_vector));
    const double glint = paint.gloss.strength * paint.light.lamp * std::pow(along, paint.gloss.shininess);
    color += Color::all(static_cast<float>(glint));
  }
  return color;
}

// Rays through 64 places of every pixel near the ball. No two places of a pixel share a row or column of
// sixty-fourths.
void paint_ball(cv::Mat& picture, const ComparisonCondition& condition, const BallTruth& ball,
                const BallPaint& surface) {
  constexpr int side = 8;
  const OutlineEllipse& outline = *ball.outline;
  const Eigen::Vector3d& p_CB = ball.p_CB;
  const double radius_m = condition.radius_m();
  const int reach_px = static_cast<int>(1.15 * outline.radius_px) + 5;
  const cv::Rect box = square_around(outline.center_px, reach_px) & cv::Rect({0, 0}, picture.size());
  for (int v = box.y; v < box.y + box.height; ++v) {
    for (int u = box.x; u < box.x + box.width; ++u) {
      Color sum(0, 0, 0);
      int hits = 0;
      for (int k = 0; k < side * side; ++k) {
        const int i = k % side, j = k / side;
        const double du = (i + (j + 0.5) / side) / side - 0.5, dv = (j + (i + 0.5) / side) / side - 0.5;
        const auto ray = condition.camera.unproject({u + du, v + dv});
        if (!ray) continue;
        const double along = ray->dot(p_CB),
                     depth2 = radius_m * radius_m - (p_CB.squaredNorm() - along * along);
        if (depth2 <= 0 || along <= 0) continue;
        const Eigen::Vector3d normal = (*ray * (along - std::sqrt(depth2)) - p_CB) / radius_m;
        sum += color_at(surface, normal);
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
  picture.forEach<Color>([&](Color& pixel, const int* at) {
    const double d2 = (Eigen::Vector2d(at[1], at[0]) - center).cwiseQuotient(size).squaredNorm();
    if (d2 < 30) pixel *= static_cast<float>(1 - depth * std::exp(-0.5 * d2));
  });
}

// The response of the camera, with noise; where the bound holds, the picture without noise, too.
void expose_painting(const cv::Mat& light, const ComparisonCondition& condition, RandomEngine& engine,
                     RenderedFrame& frame) {
  const SensorOptions& sensor = condition.sensor;
  const bool has_bound = condition.has_ball && sensor.gamma == 1;
  cv::Mat blurred;
  if (sensor.blur_px > 0)
    cv::GaussianBlur(light, blurred, {}, sensor.blur_px);
  else
    blurred = light;
  frame.bgr.create(light.size(), CV_8UC3);
  if (has_bound) frame.clean_bgr.create(light.size(), CV_32FC3);
  for (int v = 0; v < light.rows; ++v) {
    for (int u = 0; u < light.cols; ++u) {
      for (int c = 0; c < 3; ++c) {
        const double level = std::clamp<double>(blurred.at<Color>(v, u)[c], 0.0, 1.0);
        const double grey = 255 * (sensor.gamma == 1 ? level : std::pow(level, 1 / sensor.gamma));
        if (has_bound) frame.clean_bgr.at<Color>(v, u)[c] = static_cast<float>(grey);
        frame.bgr.at<cv::Vec3b>(v, u)[c] =
            cv::saturate_cast<uchar>(grey + sensor.read_noise * standard_normal(engine));
      }
    }
  }
}

// Things of nearly the ball's colour, clear of the ball: boxes, flat ovals, parts of discs.
void paint_near_things(cv::Mat& picture, const ComparisonCondition& condition,
                       const std::optional<OutlineEllipse>& ball, RandomEngine& engine) {
  const int count = condition.has_ball ? static_cast<int>(condition.same_color) : 8;
  for (int k = 0, attempts = 0; k < count && attempts < 100; ++attempts) {
    PaintedShape shape = random_shape(picture.size(), 15, 110, engine);
    if (ball && (shape.center_px - ball->center_px).norm() < 1.15 * ball->radius_px + shape.half_px.norm())
      continue;
    shape.round = uniform01(engine) < 0.5;
    if (shape.round && uniform01(engine) < 0.5) {
      shape.half_px.y() = shape.half_px.x() * uniform(engine, 0.85, 1.15);
      shape.cut = hiding_edge_distance(uniform(engine, 0.55, 0.8));
    } else if (shape.round) {
      shape.half_px.y() = shape.half_px.x() * uniform(engine, 0.3, 0.75);
    }
    paint(picture, shape, uneven(near_color(channels_of(condition), engine), engine));
    ++k;
  }
}

// A card with a straight edge before the ball.
PaintedShape paint_occluder(cv::Mat& picture, const ComparisonCondition& condition,
                            const OutlineEllipse& ball, RandomEngine& engine) {
  const double turn = uniform(engine, 0, 2 * M_PI), half_px = 3 * ball.radius_px;
  const double shift_px = hiding_edge_distance(condition.occlusion) * ball.radius_px + half_px;
  PaintedShape card;
  card.center_px = ball.center_px + shift_px * unit_vector(turn);
  card.half_px = {half_px, half_px};
  card.turn_rad = turn;
  paint(picture, card, uneven(muted_color(channels_of(condition), engine), engine));
  return card;
}

}  // namespace

RenderedFrame painted_frame(const ComparisonCondition& condition, RandomEngine& engine) {
  const BallChannels channels = channels_of(condition);
  const cv::Size size(condition.camera.size().width_px, condition.camera.size().height_px);
  RenderedFrame frame;
  cv::Mat picture(size, CV_32FC3);
  const double waviness = uniform(engine, 0, 0.4), scale_px = uniform(engine, 200, 700);
  const Color one = muted_color(channels, engine), other = muted_color(channels, engine);
  const ColorField background(other, one, scale_px, waviness, engine);
  picture.forEach<Color>([&](Color& pixel, const int* at) { pixel = background.at(at[1], at[0]); });
  BallTruth& ball = frame.truth;
  if (condition.has_ball) {
    ball.p_CB = draw_ball_place(condition, engine);
    ball.outline = project_sphere(condition.camera, ball.p_CB, condition.radius_m());
    ball.visible_fraction = 1 - condition.occlusion;
  }
  for (int k = 0; k < 40; ++k) {
    PaintedShape shape = random_shape(size, 15, 150, engine);
    shape.round = uniform01(engine) < 0.4;
    paint(picture, shape, uneven(muted_color(channels, engine), engine));
  }
  paint_near_things(picture, condition, ball.outline, engine);
  if (ball.outline) {
    if (condition.look.contact_shadow) paint_contact_shadow(picture, *ball.outline, engine);
    paint_ball(picture, condition, ball, draw_paint(condition, -ball.p_CB.normalized(), engine));
    if (condition.occlusion > 0)
      frame.unhidden = pixels_outside(paint_occluder(picture, condition, *ball.outline, engine), size);
  }
  expose_painting(picture, condition, engine, frame);
  return frame;
}

}  // namespace ballservo
