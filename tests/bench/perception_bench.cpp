// What a frame costs, ours and the peers', side by side on the same frames, with what each finds and how
// well.
//
// warm: the same frame again and again. cold: frames cycled through more memory than the caches hold.
// read is a sum of the frame's bytes by the widest instructions that the processor has; classify the fastest
// of classify_portable, classify_avx2 and classify_avx512.
// adapt is what following the light adds to a tracked frame: warm in steady light, cold in a light that
// changes all the time. Names that end in balls:N or boxes:N have so many balls, or so many boxes of nearly
// their colour more. Counters: found (of the frames, see is_found), center_px and radius_px (median errors of
// those found).
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <tuple>

#include "app/comparison/estimators/opencv_peers.hpp"
#include "app/comparison/found.hpp"
#include "calibration/base/statistics.hpp"
#include "perception/detector.hpp"
#include "perception/segmentation/classification.hpp"
#include "perception/tracking/light_adaptation.hpp"
#include "perception/tracking/tracker.hpp"
#include "tests/bench/bench_frames.hpp"
#include "tests/bench/memory_read.hpp"

namespace ballservo::bench {
namespace {

constexpr std::size_t cold_bytes = 256u << 20;  // beyond any cache of a core
constexpr int scenes = 12;

// Every method answers with its best candidates; the nearest to the truth counts, for ours and the peers
// alike.
using Candidates = std::vector<OutlineEllipse>;
using Method = std::function<Candidates(const cv::Mat& bgr, double time_s)>;
using MakeMethod = std::function<Method(const BenchSet& set)>;

struct Frames {
  BenchSet set;
  std::vector<cv::Mat> cycled;  // copies that exceed the caches
};

const Frames& frames_of(ImageSize size, const BenchCrowd& crowd = {}) {
  static std::map<std::tuple<int, int, int, int>, Frames> made;
  auto& frames = made[{size.width_px, size.height_px, crowd.balls, crowd.more_boxes}];
  if (frames.set.frames.empty()) {
    frames.set = make_frames(size, 857.0 * size.width_px / 640, scenes, crowd);
    const std::size_t bytes =
        static_cast<std::size_t>(size.width_px) * static_cast<std::size_t>(size.height_px) * 3;
    for (std::size_t i = 0; i * bytes < cold_bytes; ++i)
      frames.cycled.push_back(frames.set.frames[i % scenes].bgr.clone());
  }
  return frames;
}

Detector make_detector(const BenchSet& set, BallFit fit) {
  DetectorOptions options;
  options.fit = fit;
  options.radii = {{ball_radius_m, 0}};
  return Detector(set.rays, set.colors, options);
}

Candidates outlines(const std::vector<BallObservation>& balls) {
  Candidates candidates;
  for (const BallObservation& ball : balls) candidates.push_back(ball.outline);
  return candidates;
}

MakeMethod detect(BallFit fit) {
  return [fit](const BenchSet& set) -> Method {
    auto detector = std::make_shared<Detector>(make_detector(set, fit));
    return [detector](const cv::Mat& bgr, double) { return outlines(detector->detect(bgr)); };
  };
}

Method track(const BenchSet& set) {
  auto tracker = std::make_shared<Tracker>(make_detector(set, BallFit::sphere));
  return [tracker](const cv::Mat& bgr, double time_s) {
    Candidates candidates;
    for (const Track& followed : tracker->update(bgr, time_s)) candidates.push_back(followed.ball.outline);
    return candidates;
  };
}

Method read(const BenchSet&) {
  return [](const cv::Mat& bgr, double) {
    std::uint64_t sum = 0;
    for (int v = 0; v < bgr.rows; ++v)
      sum += sum_of_bytes(bgr.ptr(v), 3 * static_cast<std::size_t>(bgr.cols));
    benchmark::DoNotOptimize(sum);
    return Candidates{};
  };
}

Method copy(const BenchSet&) {
  auto target = std::make_shared<std::vector<std::uint8_t>>();
  return [target](const cv::Mat& bgr, double) {
    target->resize(bgr.total() * 3);
    std::memcpy(target->data(), bgr.data, target->size());
    benchmark::ClobberMemory();
    return Candidates{};
  };
}

/// As if this were another processor, 0: as it is.
struct Processor {
  explicit Processor(std::int64_t target) { hwy::SetSupportedTargetsForTest(target); }
  ~Processor() { hwy::SetSupportedTargetsForTest(0); }
};

MakeMethod classify_on(std::int64_t target) {
  return [target](const BenchSet& set) -> Method {
    return [processor = std::make_shared<Processor>(target), colors = ColorLookup(set.colors),
            classes = ClassPictures()](const cv::Mat& bgr, double) mutable {
      classify(bgr, colors, classes);
      return Candidates{};
    };
  };
}

Method segment(const BenchSet& set) {
  struct State {
    ColorLookup colors;
    ClassPictures classes, opened, closed;
    ClassMorphology morphology;
    RegionMap regions;
  };
  return [state = std::make_shared<State>(
              State{ColorLookup(set.colors), {}, {}, {}, ClassMorphology(), RegionMap()})](const cv::Mat& bgr,
                                                                                           double) {
    classify(bgr, state->colors, state->classes);
    state->morphology.open(state->classes, state->opened);
    state->morphology.close(state->opened, state->closed);
    state->regions.update(state->closed, bgr.size());
    return Candidates{};
  };
}

// OpenCV's circles, told the radius to within a half.
Method hough_gradient(const BenchSet& set) {
  return [peer = std::make_shared<HoughGradient>(set.frames[0].truth.radius_px)](const cv::Mat& bgr, double) {
    return peer->find(bgr);
  };
}

Method hsv_contour(const BenchSet&) {
  return [peer = std::make_shared<HsvContour>(0)](const cv::Mat& bgr, double) { return peer->find(bgr); };
}

void report_accuracy(benchmark::State& state, const BenchSet& set, const MakeMethod& make) {
  std::vector<double> center_px, radius_px;
  double found = 0;
  for (const BenchFrame& frame : set.frames) {
    const Method method = make(set);
    double best_px = std::numeric_limits<double>::infinity(), larger_px = 0;
    for (const OutlineEllipse& candidate : method(frame.bgr, 0)) {
      const double apart_px = (candidate.center_px - frame.truth.center_px).norm();
      if (!is_found(candidate, frame.truth) || apart_px >= best_px) continue;
      best_px = apart_px;
      larger_px = std::abs(candidate.radius_px - frame.truth.radius_px);
    }
    if (!std::isfinite(best_px)) continue;
    ++found;
    center_px.push_back(best_px);
    radius_px.push_back(larger_px);
  }
  state.counters["found"] = found;
  state.counters["frames"] = static_cast<double>(set.frames.size());
  state.counters["center_px"] = median(center_px);
  state.counters["radius_px"] = median(radius_px);
}

void run(benchmark::State& state, const Frames& frames, bool cold, const MakeMethod& make, bool finds) {
  const Method method = make(frames.set);
  method(frames.set.frames[0].bgr, 0);  // its buffers get their size
  std::size_t next = 0;
  double time_s = 1.0 / 30;
  for (auto _ : state) {
    const cv::Mat& bgr = cold ? frames.cycled[next++ % frames.cycled.size()] : frames.set.frames[0].bgr;
    benchmark::DoNotOptimize(method(bgr, time_s));
    time_s += 1.0 / 30;
  }
  if (finds && !cold) report_accuracy(state, frames.set, make);
}

// A tracker for every scene, in which the ball stands still: they take turns. Warm: the first alone.
void run_track(benchmark::State& state, const Frames& frames, bool cold) {
  struct Follower {
    Method update;
    double time_s = 0;
    void meet(const cv::Mat& bgr) { benchmark::DoNotOptimize(update(bgr, time_s += 1.0 / 30)); }
  };
  std::vector<Follower> followers;
  for (const BenchFrame& frame : frames.set.frames) {
    followers.push_back({track(frames.set)});
    for (int i = 0; i < 5; ++i) followers.back().meet(frame.bgr);
  }
  std::size_t next = 0;
  for (auto _ : state) {
    const std::size_t picture = cold ? next++ % frames.cycled.size() : 0;
    followers[picture % followers.size()].meet(frames.cycled[picture]);
  }
}

void run_adapt(benchmark::State& state, ImageSize size, bool cold) {
  const Frames& frames = frames_of(size);
  const BenchFrame& frame = frames.set.frames[0];
  static std::map<int, std::vector<cv::Mat>> copies;
  std::vector<cv::Mat>& dimmed = copies[size.width_px];
  const std::size_t count = frames.cycled.size();
  for (std::size_t i = dimmed.size(); i < count; ++i) {
    const double turn = 6.283185307179586 * static_cast<double>(i) / static_cast<double>(count);
    dimmed.push_back(frame.bgr * std::exp(0.3 * std::cos(turn) - 0.3));
  }
  LightAdaptation adaptation;
  BallObservation ball;
  ball.outline = frame.truth;
  ball.quality = ball.support.fill = 1;
  BallLight memory;
  double time_s = 0;
  std::size_t next = 0;
  for (auto _ : state) {
    const cv::Mat& bgr = cold ? dimmed[next++ % count] : frame.bgr;
    adaptation.begin(bgr);
    adaptation.learn(bgr, ball, memory);
    adaptation.finish(time_s += 1.0 / 30);
  }
}

// The same in pictures with more in them.
void register_crowds() {
  const std::vector<std::pair<std::string, MakeMethod>> methods{{"read", read},
                                                                {"segment", segment},
                                                                {"detect", detect(BallFit::sphere)},
                                                                {"hough_gradient", hough_gradient},
                                                                {"hsv_contour", hsv_contour}};
  const auto add = [&](const std::string& words, const BenchCrowd& crowd) {
    for (const auto& [name, make] : methods) {
      benchmark::RegisterBenchmark((name + "/640x480/cold/" + words).c_str(), [crowd, make = make](
                                                                                  benchmark::State& state) {
        run(state, frames_of({640, 480}, crowd), true, make, false);
      })->Unit(benchmark::kMicrosecond);
    }
    benchmark::RegisterBenchmark(("track/640x480/cold/" + words).c_str(), [crowd](benchmark::State& state) {
      run_track(state, frames_of({640, 480}, crowd), true);
    })->Unit(benchmark::kMicrosecond);
  };
  for (const int balls : {0, 1, 2, 4, 8, 12}) add(fmt::format("balls:{}", balls), {balls, 0});
  for (const int boxes : {0, 4, 8, 16, 32}) add(fmt::format("boxes:{}", boxes), {1, boxes});
}

void register_all() {
  std::vector<std::pair<std::string, std::pair<MakeMethod, bool>>> methods{
      {"read", {read, false}},
      {"memcpy", {copy, false}},
      {"classify", {classify_on(0), false}},
      {"segment", {segment, false}},
      {"detect", {detect(BallFit::sphere), true}},
      {"detect_paper", {detect(BallFit::paper), true}},
      {"hough_gradient", {hough_gradient, true}},
      {"hsv_contour", {hsv_contour, true}},
  };
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets())
    methods.push_back({fmt::format("classify_{}", hwy::TargetName(target)), {classify_on(target), false}});
  for (const ImageSize size : {ImageSize{320, 240}, ImageSize{640, 480}, ImageSize{1024, 683},
                               ImageSize{1280, 960}, ImageSize{1920, 1080}}) {
    for (const bool cold : {false, true}) {
      const std::string suffix =
          fmt::format("/{}x{}/{}", size.width_px, size.height_px, cold ? "cold" : "warm");
      for (const auto& [name, method] : methods) {
        benchmark::RegisterBenchmark((name + suffix).c_str(), [size, cold,
                                                               method = method](benchmark::State& state) {
          run(state, frames_of(size), cold, method.first, method.second);
        })->Unit(benchmark::kMicrosecond);
      }
      benchmark::RegisterBenchmark(("track" + suffix).c_str(), [size, cold](benchmark::State& state) {
        run_track(state, frames_of(size), cold);
      })->Unit(benchmark::kMicrosecond);
      benchmark::RegisterBenchmark(("adapt" + suffix).c_str(), [size, cold](benchmark::State& state) {
        run_adapt(state, size, cold);
      })->Unit(benchmark::kMicrosecond);
    }
  }
}

}  // namespace
}  // namespace ballservo::bench

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  ballservo::bench::register_all();
  ballservo::bench::register_crowds();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
