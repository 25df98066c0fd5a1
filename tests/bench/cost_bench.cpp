// What a frame costs against its pixels, its balls, and the things of nearly their colour in it: ours and the
// peers', as multiples of reading the frame once.
//
//   build/release/tests/bench/cost_bench -o out/cost         the table, cost.csv and cost.svg
//
// Processor time of one thread, medians over frames that no cache holds.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/core/utility.hpp>
#include <optional>

#include "app/commands/command.hpp"
#include "app/comparison/estimators/opencv_peers.hpp"
#include "app/report/svg_grid.hpp"
#include "app/report/svg_plot.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/statistics.hpp"
#include "perception/detector.hpp"
#include "perception/segmentation/classification.hpp"
#include "tests/bench/bench_frames.hpp"
#include "tests/bench/memory_read.hpp"

namespace ballservo::bench {
namespace {

constexpr std::size_t cold_bytes = 256u << 20;  // beyond any cache of a core
constexpr int scenes = 12;

struct Sweep {
  std::string name, label;
  bool log = false;
  std::vector<double> values;
};

const std::vector<Sweep>& sweeps() {
  static const std::vector<Sweep> all{
      {"megapixels", "pixels (10^6)", true, {0.0768, 0.3072, 0.6994, 0.9216, 2.0736}},
      {"balls", "balls in the picture", false, {0, 1, 2, 4, 8, 12}},
      {"boxes", "boxes of nearly the ball's colour besides", false, {0, 4, 8, 16, 32}}};
  return all;
}

ImageSize size_of(double megapixels) {
  for (const ImageSize size : {ImageSize{320, 240}, ImageSize{640, 480}, ImageSize{1024, 683},
                               ImageSize{1280, 720}, ImageSize{1920, 1080}}) {
    if (std::abs(size.width_px * size.height_px * 1e-6 - megapixels) < 1e-3) return size;
  }
  throw std::logic_error("a size of the sweep");
}

BenchSet frames_of(const Sweep& sweep, double value) {
  if (sweep.name == "megapixels") {
    const ImageSize size = size_of(value);
    return make_frames(size, 857.0 * size.width_px / 640, scenes);
  }
  BenchCrowd crowd;
  (sweep.name == "balls" ? crowd.balls : crowd.more_boxes) = static_cast<int>(value);
  return make_frames({640, 480}, 857, scenes, crowd);
}

using Work = std::function<void(const cv::Mat& bgr)>;

double processor_us() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

double median_us(const std::vector<cv::Mat>& frames, int times, const Work& work) {
  std::vector<double> us;
  for (int k = -2; k < times; ++k) {  // two to warm up
    const double start_us = processor_us();
    work(frames[static_cast<std::size_t>(k + 2) % frames.size()]);
    if (k >= 0) us.push_back(processor_us() - start_us);
  }
  return median(us);
}

// What `detect` does before it looks for circles.
class Segmenter {
 public:
  explicit Segmenter(const BenchSet& set) : colors_(set.colors) {}
  void segment(const cv::Mat& bgr) {
    classify(bgr, colors_, classes_);
    morphology_.open(classes_, opened_);
    morphology_.close(opened_, closed_);
    regions_.update(closed_, bgr.size());
  }

 private:
  ColorLookup colors_;
  ClassPictures classes_, opened_, closed_;
  ClassMorphology morphology_;
  RegionMap regions_;
};

constexpr std::array<const char*, 5> methods{"read", "segment", "detect", "hsv_contour", "hough_gradient"};
using Costs = std::array<double, methods.size()>;  // us

Costs costs_of(const BenchSet& set) {
  std::vector<cv::Mat> cycled;
  const std::size_t bytes = set.frames.front().bgr.total() * 3;
  for (std::size_t i = 0; i * bytes < cold_bytes; ++i) cycled.push_back(set.frames[i % scenes].bgr.clone());
  const int often = std::min(400, static_cast<int>(cycled.size()));
  DetectorOptions options;
  options.radii = {{ball_radius_m, 0}};
  Detector detector(set.rays, set.colors, options);
  Segmenter segmenter(set);
  HsvContour hsv(0);
  HoughGradient hough(set.frames.front().truth.radius_px);
  return {median_us(
              cycled, often,
              [&](const cv::Mat& bgr) { benchmark::DoNotOptimize(sum_of_bytes(bgr.data, bgr.total() * 3)); }),
          median_us(cycled, often, [&](const cv::Mat& bgr) { segmenter.segment(bgr); }),
          median_us(cycled, often, [&](const cv::Mat& bgr) { detector.detect(bgr); }),
          median_us(cycled, often / 4, [&](const cv::Mat& bgr) { hsv.find(bgr); }),
          median_us(cycled, scenes, [&](const cv::Mat& bgr) { hough.find(bgr); })};
}

Svg plot(const Sweep& sweep, const std::vector<Costs>& costs) {
  std::vector<PlotSeries> series;
  for (std::size_t m = 1; m < methods.size(); ++m) {
    PlotSeries curve;
    curve.name = methods[m];
    curve.style = SeriesStyle::line_and_points;
    for (std::size_t k = 0; k < costs.size(); ++k) {
      curve.x.push_back(sweep.values[k]);
      curve.y.push_back(costs[k][m] / costs[k][0]);
    }
    series.push_back(std::move(curve));
  }
  PlotOptions options;
  options.x = {sweep.label, sweep.log, {}, {}};
  options.y = {"cost / reading the frame", true, {}, {}};
  options.width_px = 460;
  return line_plot(series, options);
}

int run(const std::filesystem::path& output, Overwrite overwrite) {
  std::optional<OutputFolder> folder;
  if (!output.empty()) folder.emplace(output, overwrite);
  std::string csv = "sweep,value,method,time_us,over_read\n";
  std::vector<Svg> plots;
  for (const Sweep& sweep : sweeps()) {
    fmt::print("{:<12}{:>10}", sweep.name, "read us");
    for (std::size_t m = 1; m < methods.size(); ++m) fmt::print("{:>16}", methods[m]);
    fmt::print("   (times read)\n");
    std::vector<Costs> all;
    for (const double value : sweep.values) {
      const Costs& costs = all.emplace_back(costs_of(frames_of(sweep, value)));
      fmt::print("{:<12}{:>10.0f}", value, costs[0]);
      for (std::size_t m = 0; m < methods.size(); ++m) {
        if (m > 0) fmt::print("{:>16.1f}", costs[m] / costs[0]);
        csv += fmt::format("{},{},{},{},{}\n", sweep.name, number_text(value), methods[m],
                           number_text(costs[m]), number_text(costs[m] / costs[0]));
      }
      fmt::print("\n");
      std::fflush(stdout);
    }
    plots.push_back(plot(sweep, all));
  }
  if (folder) {
    folder->write("cost.csv", csv);
    folder->write("cost.svg", svg_grid(plots, 3, "Cost against pixels, balls and distractors").standalone());
    folder->commit();
  }
  return exit_done;
}

}  // namespace
}  // namespace ballservo::bench

int main(int argc, char** argv) {
  using namespace ballservo;
  CLI::App program("What a frame costs, against its pixels, balls and distractors", "cost_bench");
  program.footer("Example: cost_bench -o out/cost\nprints a table and writes cost.csv and cost.svg.");
  std::filesystem::path output;
  bool force = false;
  program.add_option("-o,--output", output, "folder for the results");
  program.add_flag("--force", force, "replace outputs that exist");
  try {
    program.parse(argc, argv);
    cv::setNumThreads(1);
    return bench::run(output, force ? Overwrite::allow : Overwrite::refuse);
  } catch (const CLI::ParseError& error) {
    const int code = program.exit(error);
    return code == 0 ? exit_done : exit_bad_input;
  } catch (const InputError& error) {
    for (const Fault& fault : error.faults()) fmt::print(stderr, "cost_bench: error: {}\n", to_text(fault));
    return exit_bad_input;
  }
}
