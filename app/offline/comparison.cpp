#include "app/offline/comparison.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>

#include "app/offline/rendered_frame.hpp"
#include "calibration/color/learn_colors.hpp"
#include "perception/detector.hpp"
#include "perception/region_circle.hpp"

namespace ballservo {
namespace {

constexpr int teaching_frames = 3;
constexpr double teaching_radius_px = 60;

// Learns one colour word from pictures of a large whole ball in several lights.
std::shared_ptr<const ColorTable> learn_color(const ComparisonCondition& condition, std::uint64_t seed) {
  ComparisonCondition teaching = condition;
  teaching.name = "teaching_" + condition.ball_color;
  teaching.camera = ComparisonCondition{}.camera;
  teaching.depth_m = condition.radius_m() * teaching.camera.focal_px() / teaching_radius_px;
  teaching.off_axis_rad = 0;
  teaching.occlusion = 0;
  teaching.sensor = SensorOptions{};
  teaching.sensor.blur_px = 0.7;
  teaching.sensor.read_noise = 2;
  teaching.sensor.gain = condition.sensor.gain;
  teaching.sensor.gamma = condition.sensor.gamma;
  std::vector<ColorPicture> pictures;
  ClassRequest request;
  request.name = condition.ball_color;
  for (int k = 0; k < teaching_frames; ++k) {
    pictures.push_back({teaching.name, render_comparison_frame(teaching, seed, k).bgr});
    request.pictures.push_back(static_cast<std::size_t>(k));
  }
  return std::make_shared<const ColorTable>(
      learn_classes(pictures, {request}, region_circle_estimator(seed)).table);
}

// What all frames of a condition share.
struct ConditionSetup {
  std::shared_ptr<const RayTable> rays;
  std::shared_ptr<const ColorTable> colors;
  DetectorOptions options;
};

std::vector<ConditionSetup> set_up(const ComparisonPlan& plan) {
  // Colours look alike as long as exposure and response do.
  std::map<std::tuple<std::string, double, double>, std::shared_ptr<const ColorTable>> tables;
  std::vector<ConditionSetup> setups;
  for (const ComparisonCondition& condition : plan.conditions) {
    auto& table = tables[{condition.ball_color, condition.sensor.gain, condition.sensor.gamma}];
    if (!table) table = learn_color(condition, plan.seed);
    ConditionSetup setup;
    setup.rays = std::make_shared<const RayTable>(condition.camera);
    setup.colors = table;
    setup.options.radii = {{condition.radius_m(), 0}};
    setup.options.seed = plan.seed;
    setups.push_back(std::move(setup));
  }
  return setups;
}

}  // namespace

bool at_the_ball(const MethodFit& fit, const BallTruth& truth) {
  return truth.outline &&
         (fit.outline.center_px - truth.outline->center_px).norm() < 0.5 * truth.outline->radius_px;
}

Comparison run_comparison(const ComparisonPlan& plan, int threads,
                          const std::function<void(long done)>& progress) {
  const std::vector<ConditionSetup> setups = set_up(plan);
  Comparison comparison;
  comparison.methods = plan.methods;
  struct Job {
    std::size_t condition;
    int frame;
  };
  std::vector<Job> jobs;
  for (std::size_t c = 0; c < plan.conditions.size(); ++c) {
    comparison.conditions.push_back({plan.conditions[c].name, {}, {}});
    comparison.conditions[c].frames.resize(static_cast<std::size_t>(plan.conditions[c].frames));
    for (int frame = 0; frame < plan.conditions[c].frames; ++frame) jobs.push_back({c, frame});
  }

  std::mutex progress_mutex;
  long done = 0;
  const auto run_job = [&](const Job& job) {
    const ComparisonCondition& condition = plan.conditions[job.condition];
    const ConditionSetup& setup = setups[job.condition];
    RenderedFrame rendered = render_comparison_frame(condition, plan.seed, job.frame);
    Detector detector(setup.rays, setup.colors, setup.options);
    ConditionResult& result = comparison.conditions[job.condition];
    ComparisonFrame& frame = result.frames[static_cast<std::size_t>(job.frame)];
    frame.fits = run_methods(detector, rendered.bgr, 1, plan.methods);
    frame.truth = rendered.truth;
    if (job.frame == 0) result.example = rendered.bgr;
    const std::lock_guard<std::mutex> lock(progress_mutex);
    progress(++done);
  };
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, jobs.size(), 1), [&](const auto& range) {
      for (std::size_t k = range.begin(); k != range.end(); ++k) run_job(jobs[k]);
    });
  });
  return comparison;
}

}  // namespace ballservo
