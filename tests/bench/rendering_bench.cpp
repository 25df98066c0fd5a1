// What a frame of a scenario costs to render, beside reading it once from memory.
//
// rendering_bench [options of Google Benchmark] SCENARIO...: the camera comes nearer to the target from frame
// to frame. `radiance` is the light on the pixels, `expose` what optics and sensor make of it, `render` both.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <vector>

#include "app/scenario/scenario.hpp"
#include "servo/simulation/rendering/camera_renderer.hpp"
#include "tests/bench/memory_read.hpp"

namespace ballservo::bench {
namespace {

constexpr std::size_t read_bytes = 256u << 20;  // beyond any cache of a core
constexpr int frames = 60;

class Journey {
 public:
  explicit Journey(const Scenario& scenario)
      : renderer_(scenario.camera.camera, scenario.world, scenario.camera.sensor) {
    const auto& ball = scenario.world.balls.at(static_cast<std::size_t>(scenario.target));
    const Eigen::Vector2d start(scenario.robot.pose.x_m, scenario.robot.pose.y_m);
    const Eigen::Vector2d way = ball.p_WB(0).head<2>() - start;
    for (int k = 0; k < frames; ++k) {
      const Eigen::Vector2d place = start + std::max(0.0, 1 - 0.8 / way.norm()) * k / frames * way;
      views_.push_back({scenario.X_WC({place.x(), place.y(), std::atan2(way.y(), way.x())}), 0});
    }
  }

  void radiance(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(renderer_.radiance({next()}));
  }
  void expose(benchmark::State& state) {
    const cv::Mat light = renderer_.radiance({next()});
    for (auto _ : state) benchmark::DoNotOptimize(ballservo::expose(light, renderer_.sensor(), 1, frame_++));
  }
  void render(benchmark::State& state) {
    for (auto _ : state) {
      const CameraView& view = next();
      benchmark::DoNotOptimize(renderer_.render({view}, 1, frame_));
    }
  }
  void read(benchmark::State& state) {
    const cv::Mat picture = renderer_.render({next()}, 1, frame_);
    const std::size_t bytes = picture.total() * picture.elemSize();
    std::vector<cv::Mat> cycled;
    for (std::size_t i = 0; i * bytes < read_bytes; ++i) cycled.push_back(picture.clone());
    for (auto _ : state) benchmark::DoNotOptimize(sum_of_bytes(cycled[frame_++ % cycled.size()].data, bytes));
  }

 private:
  const CameraView& next() { return views_[frame_++ % views_.size()]; }

  CameraRenderer renderer_;
  std::vector<CameraView> views_;
  std::size_t frame_ = 0;
};

void register_scenario(const std::filesystem::path& file) {
  const auto journey = std::make_shared<Journey>(load_scenario(file, {}, 0));
  const auto add = [&](const char* name, void (Journey::*measure)(benchmark::State&)) {
    benchmark::RegisterBenchmark(
        fmt::format("{}/{}", name, file.stem().string()).c_str(),
        [journey, measure](benchmark::State& state) { (journey.get()->*measure)(state); })
        ->Unit(benchmark::kMicrosecond);
  };
  add("read", &Journey::read);
  add("radiance", &Journey::radiance);
  add("expose", &Journey::expose);
  add("render", &Journey::render);
}

}  // namespace
}  // namespace ballservo::bench

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  benchmark::Initialize(&argc, argv);
  for (int i = 1; i < argc; ++i) ballservo::bench::register_scenario(argv[i]);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
