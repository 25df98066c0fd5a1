#include "tests/bench/accuracy_condition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tests/bench/painted_frame.hpp"
#include "tests/bench/rendered_frame.hpp"

namespace ballservo::bench {
namespace {

constexpr double deg = 0.017453292519943295;

std::vector<AccuracyCondition> table_conditions() {
  std::vector<AccuracyCondition> list;
  const auto add = [&](const char* name, const char* words) -> AccuracyCondition& {
    list.emplace_back();
    list.back().name = name;
    list.back().words = words;
    return list.back();
  };
  add("base", "60 px across at 1 m, noise 2, blur 0.7 px, lamps from all sides, clutter, 4 distractors");
  add("occluded_30", "30 % of the outline's area behind a card, disc or post").hidden = 0.3;
  add("occluded_60", "60 % of it").hidden = 0.6;
  add("at_2m", "30 px across").depth_m = 2;
  add("blur_1_5", "blur 1.5 px").blur_px = 1.5;
  add("sigma_10", "noise 10 grey levels").noise = 10;
  AccuracyCondition& axis = add("axis_28", "28 degrees off the axis, f 500");
  axis.off_axis_rad = 28 * deg;
  axis.focal_px = 500;
  add("touching_bar", "a bar of the ball's colour touches it").neighbour = Neighbour::touching_bar;
  add("border_cut", "half of it outside the picture").neighbour = Neighbour::picture_border;
  add("ball_8_px", "8 px across").depth_m = 7.5;
  add("ball_large", "300 px across").depth_m = 0.205;
  add("clutter", "no ball: near-colour boxes, cut or turned discs, cylinders, ramps").neighbour =
      Neighbour::no_ball;

  const auto paint = [&](const char* name, const char* words) -> AccuracyCondition& {
    AccuracyCondition& condition = add(name, words);
    condition.painted = true;
    return condition;
  };
  paint("paint_base", "painted: gradients, soft light");
  paint("paint_half_shade", "painted: a soft shadow over half of the ball").look.half_shade = true;
  paint("paint_highlight", "painted: a glossy ball").look.highlight = true;
  paint("paint_marbled", "painted: a marbled ball").look.marbled = true;
  paint("paint_contact", "painted: a soft contact shadow under it").look.contact_shadow = true;
  AccuracyCondition& all = paint("paint_all", "painted: all of these, half-way off the axis, f 500");
  all.look = {true, true, true, true};
  all.off_axis_rad = 14 * deg;
  all.focal_px = 500;
  paint("paint_2m", "painted, 30 px across").depth_m = 2;
  AccuracyCondition& occluded = paint("paint_occluded_30", "painted, 30 % hidden, highlight, contact shadow");
  occluded.hidden = 0.3;
  occluded.look = {false, true, false, true};
  paint("paint_gamma", "painted, a camera of gamma 2.2").gamma = 2.2;
  paint("paint_clutter", "painted, without a ball").neighbour = Neighbour::no_ball;
  return list;
}

void add_sweeps(std::vector<AccuracyCondition>& list) {
  const auto add = [&](const char* sweep, double value) -> AccuracyCondition& {
    list.emplace_back();
    list.back().sweep = sweep;
    list.back().sweep_value = value;
    list.back().name = fmt::format("{}_{:g}", sweep, value);
    return list.back();
  };
  for (const double z : {0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 4.0}) add("distance_m", z).depth_m = z;
  for (const double h : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7}) add("hidden", h).hidden = h;
  for (const double b : {0.4, 0.7, 1.0, 1.5, 2.0, 3.0}) add("blur_px", b).blur_px = b;
  for (const double n : {0.5, 1.0, 2.0, 5.0, 10.0, 20.0}) add("noise", n).noise = n;
  for (const double a : {0.0, 7.0, 14.0, 21.0, 28.0}) {
    AccuracyCondition& condition = add("angle_deg", a);
    condition.off_axis_rad = a * deg;
    condition.focal_px = 500;
  }
}

bool inside_picture(const Camera& camera, const Eigen::Vector3d& p_CB) {
  constexpr double margin_px = 12;
  const auto outline = project_outline(camera, p_CB, accuracy_ball_radius_m, 32);
  return !outline.empty() && std::all_of(outline.begin(), outline.end(), [&](const Eigen::Vector2d& p) {
    return p.x() > margin_px && p.y() > margin_px && p.x() < camera.size().width_px - 1 - margin_px &&
           p.y() < camera.size().height_px - 1 - margin_px;
  });
}

// A pixel of the border, and a ball whose centre lies near it.
Eigen::Vector3d border_place(const Camera& camera, double depth_m, RandomEngine& engine) {
  const double radius_px = accuracy_ball_radius_m / depth_m * camera.focal_px();
  const double beyond_px = uniform(engine, -0.1, 0.1) * radius_px;
  const double width = camera.size().width_px, height = camera.size().height_px;
  const double u = uniform(engine, 0.15, 0.85) * width, v = uniform(engine, 0.15, 0.85) * height;
  const std::array<Eigen::Vector2d, 4> places{
      Eigen::Vector2d(-beyond_px, v), Eigen::Vector2d(width - 1 + beyond_px, v),
      Eigen::Vector2d(u, -beyond_px), Eigen::Vector2d(u, height - 1 + beyond_px)};
  const auto ray = camera.unproject(places[uniform_index(engine, 4)]);
  return *ray * (depth_m / ray->z());
}

}  // namespace

const std::vector<AccuracyCondition>& accuracy_conditions() {
  static const std::vector<AccuracyCondition> conditions = [] {
    std::vector<AccuracyCondition> list = table_conditions();
    add_sweeps(list);
    return list;
  }();
  return conditions;
}

Camera accuracy_camera(const AccuracyCondition& condition) {
  CameraParameters parameters;
  parameters.size = {640, 480};
  parameters.fx_px = parameters.fy_px = condition.focal_px;
  parameters.cx_px = 319.5;
  parameters.cy_px = 239.5;
  return Camera(parameters);
}

int accuracy_hue(const AccuracyCondition& condition) { return condition.painted ? 60 : 0; }

std::shared_ptr<const ColorTable> accuracy_colors(const AccuracyCondition& condition) {
  auto colors = std::make_shared<ColorTable>();
  colors->classes.push_back({});
  colors->classes.back().name = condition.painted ? "green" : "red";
  for (int r = 0; r < 64; ++r) {
    for (int g = 0; g < 64; ++g) {
      for (int b = 0; b < 64; ++b) {
        const int own = condition.painted ? g : r, other = std::max(condition.painted ? r : g, b);
        // A camera's response brings the channels nearer to each other.
        const bool colored = condition.gamma > 1 ? 10 * own > 13 * other : 10 * own > 19 * other;
        if (own > 7 && colored) colors->table[static_cast<std::size_t>((r << 12) | (g << 6) | b)] = 1;
      }
    }
  }
  return colors;
}

Eigen::Vector3d accuracy_place(const AccuracyCondition& condition, const Camera& camera,
                               RandomEngine& engine) {
  const double depth_m = condition.depth_m * uniform(engine, 0.98, 1.02);
  if (condition.neighbour == Neighbour::picture_border) return border_place(camera, depth_m, engine);
  for (int attempt = 0; attempt < 1000; ++attempt) {
    const double azimuth = uniform(engine, 0, 360 * deg);
    const Eigen::Vector2d direction(std::cos(azimuth), std::sin(azimuth));
    // About the wanted angle, or anywhere near the middle where none is wanted.
    const double lateral = condition.sweep == "angle_deg" || condition.off_axis_rad > 0
                               ? std::tan(condition.off_axis_rad) + uniform(engine, -0.004, 0.004)
                               : 0.2 * std::sqrt(uniform01(engine));
    const Eigen::Vector3d p_CB(depth_m * lateral * direction.x(), depth_m * lateral * direction.y(), depth_m);
    if (inside_picture(camera, p_CB)) return p_CB;
  }
  return {0, 0, depth_m};  // a ball so large that it is whole in the middle only
}

double hiding_edge_distance(double hidden_fraction) {
  // Area of a circular segment: (acos d - d sqrt(1 - d^2)) / pi.
  double low = -1, high = 1;
  for (int k = 0; k < 60; ++k) {
    const double d = (low + high) / 2;
    (std::acos(d) - d * std::sqrt(1 - d * d) > hidden_fraction * 180 * deg ? low : high) = d;
  }
  return (low + high) / 2;
}

AccuracyFrame make_accuracy_frame(const AccuracyCondition& condition, std::uint64_t seed, int index) {
  RandomEngine engine = random_stream(seed, "accuracy/" + condition.name, static_cast<std::uint64_t>(index));
  return condition.painted ? painted_frame(condition, engine) : rendered_frame(condition, engine);
}

}  // namespace ballservo::bench
