#include "app/comparison/pictures/plan_pictures.hpp"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "app/comparison/estimators/peer_tuning.hpp"
#include "app/comparison/estimators/position_bound.hpp"
#include "app/comparison/pictures/painters.hpp"
#include "app/io/interrupt.hpp"
#include "calibration/base/random.hpp"
#include "calibration/teaching/learn_colors.hpp"

namespace ballservo {
namespace {

constexpr int teaching_frames = 3, tuning_frames = 3;
constexpr double teaching_radius_px = 60;

// The ball as it is under the usual light, in the camera's response, large and whole.
ComparisonCondition teaching_of(const ComparisonCondition& condition) {
  ComparisonCondition teaching = usual_scene("teaching_" + condition.ball_color, condition.ball_color);
  teaching.ball_pattern = condition.ball_pattern;
  teaching.diameter_m = condition.diameter_m;
  teaching.depth_m = condition.radius_m() * teaching.camera.focal_px() / teaching_radius_px;
  teaching.sensor.gain = condition.sensor.gain;
  teaching.sensor.gamma = condition.sensor.gamma;
  return teaching;
}

// What a room's or a painted ball's colour is: its own channel well above the others. A camera's response
// brings the channels nearer to each other. How well colours can be learnt is not asked of these pictures.
std::shared_ptr<const ColorTable> dominant_color(const ComparisonCondition& condition) {
  const BallChannels channels(own_channel(condition.ball_color));
  const int tenths = condition.sensor.gamma > 1 ? 13 : 19;
  auto table = std::make_shared<ColorTable>();
  table->classes.emplace_back();
  table->classes.back().name = condition.ball_color;
  for (int entry = 0; entry < ColorTable::entries; ++entry) {
    const std::array<int, 3> rgb{entry >> 12, (entry >> 6) & 63, entry & 63};
    const int own = rgb[static_cast<std::size_t>(channels.own)];
    const int other = std::max(rgb[static_cast<std::size_t>(channels.other_1)],
                               rgb[static_cast<std::size_t>(channels.other_2)]);
    if (own > 7 && 10 * own > tenths * other) table->table[static_cast<std::size_t>(entry)] = 1;
  }
  return table;
}

// As OpenCV counts it, of a colour word's reflectance.
int hue_of_word(const std::string& color) {
  const Rgb rgb = *color_from_word(color);
  cv::Mat pixel(1, 1, CV_32FC3, cv::Scalar(rgb[2], rgb[1], rgb[0])), hsv;
  cv::cvtColor(pixel, hsv, cv::COLOR_BGR2HSV);
  return static_cast<int>(std::lround(hsv.at<cv::Vec3f>(0, 0)[0] / 2)) % 180;
}

// The camera that the methods are told: off by a draw from its covariance.
Camera misjudged(const ComparisonCondition& condition, RandomEngine& engine) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(*condition.covariance);
  Eigen::VectorXd draw(eigen.eigenvalues().size());
  for (double& value : draw) value = standard_normal(engine);
  const Eigen::VectorXd root = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
  const CameraParameters& truth = condition.camera.parameters();
  const Eigen::VectorXd off = condition.calibration_sigmas * (eigen.eigenvectors() * root.cwiseProduct(draw));
  return Camera(with_parameter_vector(truth, parameter_vector(truth) + off));
}

FrameTruth truth_of(const ComparisonCondition& condition, const RenderedFrame& rendered, int frame) {
  FrameTruth truth;
  truth.frame = frame;
  if (!condition.has_ball) {
    truth.has_ball = false;
    return truth;
  }
  truth.outline = rendered.truth.outline;
  truth.p_CB = rendered.truth.p_CB;
  truth.visible_fraction = rendered.truth.visible_fraction;
  if (rendered.clean_bgr.empty() || condition.calibration_sigmas > 0) return truth;
  const auto bound = position_bound({condition.camera, rendered.truth.p_CB, condition.radius_m(),
                                     condition.sensor.blur_px, condition.sensor.read_noise,
                                     condition.sensor.shot_noise, rendered.clean_bgr, rendered.unhidden});
  if (bound) {
    truth.bound_m = std::sqrt(bound->trace());
    truth.bound_depth_m = std::sqrt((*bound)(2, 2));
  }
  return truth;
}

}  // namespace

nlohmann::json camera_identity(const Camera& camera) {
  const CameraParameters& p = camera.parameters();
  const Eigen::VectorXd vector = parameter_vector(p);
  return {{"model", lens_model_name(p.model)},
          {"size", {p.size.width_px, p.size.height_px}},
          {"parameters", std::vector<double>(vector.begin(), vector.end())}};
}

ComparisonCondition usual_scene(const std::string& name, const std::string& ball_color) {
  ComparisonCondition condition;
  condition.name = name;
  condition.ball_color = ball_color;
  condition.sensor.blur_px = 0.7;
  condition.sensor.read_noise = 2;
  return condition;
}

std::shared_ptr<const ColorTable> learn_rendered(const std::vector<ComparisonCondition>& balls, int frames,
                                                 std::uint64_t seed) {
  std::vector<ColorPicture> pictures;
  std::vector<ClassRequest> requests;
  for (const ComparisonCondition& ball : balls) {
    ClassRequest& request = requests.emplace_back();
    request.name = ball.ball_color;
    for (int k = 0; k < frames; ++k) {
      request.pictures.push_back(pictures.size());
      pictures.push_back({ball.name, render_comparison_frame(ball, seed, k).bgr});
    }
  }
  return std::make_shared<const ColorTable>(learn_classes(pictures, requests).table);
}

PlanPictures::PlanPictures(const ComparisonPlan& plan) : plan_(plan), setups_(plan.conditions.size()) {
  for (const FitMethod* method : plan.methods) {
    peers_asked_ |= method->is_peer && method->fit;
    detectors_asked_ |= method->detect && !method->is_peer;
  }
  for (const ComparisonCondition& condition : plan.conditions) {
    ConditionInfo info;
    info.name = condition.name;
    info.words = in_words(condition);
    info.frames = condition.frames;
    if (const auto number = find_number(condition, condition.swept)) {
      info.swept_key = condition.swept;
      info.swept_label = number->label;
      info.swept_value = number->value;
      info.swept_log = number->log;
    }
    infos_.push_back(info);
  }
}

void PlanPictures::prepare(const std::vector<char>& needed) {
  // Colours look alike as long as finish and response do.
  std::map<std::tuple<bool, std::string, Pattern, double, double>, std::shared_ptr<const ColorTable>> tables;
  std::map<nlohmann::json, std::shared_ptr<const RayTable>> cameras;
  for (std::size_t c = 0; c < setups_.size(); ++c) {
    if (!needed[c]) continue;
    throw_if_interrupted();
    const ComparisonCondition& condition = plan_.conditions[c];
    const bool lab = condition.painter == Painter::lab;
    auto& table = tables[{lab, condition.ball_color, condition.ball_pattern, condition.sensor.gain,
                          condition.sensor.gamma}];
    if (!table)
      table = lab ? learn_rendered({teaching_of(condition)}, teaching_frames, plan_.seed)
                  : dominant_color(condition);
    DetectorSetup& detector = setups_[c].detector;
    detector.colors = table;
    setups_[c].hue = lab ? hue_of_word(condition.ball_color) : 60 * own_channel(condition.ball_color);
    auto& rays = cameras[camera_identity(condition.camera)];
    if (!rays) rays = std::make_shared<const RayTable>(condition.camera);
    detector.rays = rays;
    detector.options.radii = {{condition.radius_m(), 0}};
    detector.options.seed = plan_.seed;
  }
  if (!peers_asked_ && !detectors_asked_) return;
  tbb::parallel_for(std::size_t{0}, setups_.size(), [&](std::size_t c) {
    if (!needed[c]) return;
    const ComparisonCondition& condition = plan_.conditions[c];
    std::vector<TuningPicture> pictures;
    for (int k = 0; k < tuning_frames; ++k) {
      throw_if_interrupted();
      // Frames of another seed: never those that are measured.
      RenderedFrame rendered = render_comparison_frame(condition, plan_.seed ^ 0x70656572736574ull, k);
      FrameTruth truth;
      truth.frame = k;
      truth.outline = rendered.truth.outline;
      pictures.push_back({rendered.bgr, truth, task(c, truth)});
    }
    if (peers_asked_) setups_[c].peers = tuned_peers(pictures, plan_.methods);
    if (detectors_asked_) {
      for (const TuningPicture& shown : pictures) setups_[c].detector.seen_before.push_back(shown.bgr);
    }
  });
}

// What is drawn here comes from (seed, the condition's name, frame) alone.
MethodTask PlanPictures::task(std::size_t index, const FrameTruth& truth) const {
  const ComparisonCondition& condition = plan_.conditions[index];
  RandomEngine engine =
      random_stream(plan_.seed, "task/" + condition.name, static_cast<std::uint64_t>(truth.frame));
  MethodTask task;
  task.loss = plan_.loss;
  task.peers = setups_[index].peers;
  task.hue = setups_[index].hue;
  task.expected_radius_px = condition.radius_m() / condition.depth_m * condition.camera.focal_px();
  if (!truth.outline) return task;
  const double radius_px = truth.outline->radius_px;
  task.expected_radius_px = radius_px;
  // A user clicks somewhere near the middle of what is seen of the ball.
  task.click_px = truth.outline->center_px +
                  0.15 * radius_px * Eigen::Vector2d(standard_normal(engine), standard_normal(engine));
  if (condition.start)
    task.start = displaced_start(condition.camera, *truth.outline, condition.start->center_px,
                                 condition.start->radius_px, engine);
  return task;
}

ComparisonPicture PlanPictures::picture(std::size_t index, int frame) const {
  const ComparisonCondition& condition = plan_.conditions[index];
  const RenderedFrame rendered = render_comparison_frame(condition, plan_.seed, frame);
  ComparisonPicture picture;
  picture.truth = truth_of(condition, rendered, frame);
  picture.bgr = rendered.bgr;
  picture.detector = setups_[index].detector;
  if (condition.calibration_sigmas > 0) {
    RandomEngine engine =
        random_stream(plan_.seed, "calibration/" + condition.name, static_cast<std::uint64_t>(frame));
    picture.detector.rays = std::make_shared<const RayTable>(misjudged(condition, engine));
  }
  picture.task = task(index, picture.truth);
  return picture;
}

std::string PlanPictures::peer_words(std::size_t condition) const {
  if (!peers_asked_ || !setups_[condition].detector.rays) return "";
  return "the best of a small grid on three other frames: " + in_words(setups_[condition].peers);
}

}  // namespace ballservo
