// Runs every stage of the perception on fixed frames, for instruction_counts.sh, and names them in the order
// in which it does: what is counted happens in one call of counted_stage() each, after a warm-up. No chance
// and no clock in it, and no threads.
#include <array>
#include <cstdio>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calibration/base/random.hpp"
#include "perception/detector.hpp"
#include "perception/segmentation/classification.hpp"
#include "perception/tracking/tracker.hpp"

extern "C" [[gnu::noipa]] void counted_stage(const std::function<void()>& stage) { stage(); }

namespace ballservo {
namespace {

constexpr int width = 320, height = 240, counted = 2;

std::shared_ptr<const ColorTable> red_table() {
  auto colors = std::make_shared<ColorTable>();
  colors->classes.resize(1);
  for (int i = 0; i < ColorTable::entries; ++i) {
    const int b = i & 63, g = (i >> 6) & 63, r = i >> 12;
    colors->table[static_cast<std::size_t>(i)] = r > 7 && 10 * r > 19 * g && 10 * r > 19 * b;
  }
  return colors;
}

void paint(cv::Mat& bgr, int u, int v, double part, const std::array<double, 3>& color) {
  if (u < 0 || v < 0 || u >= width || v >= height) return;
  std::uint8_t* const p = bgr.ptr(v) + 3 * u;
  for (std::size_t c = 0; c < 3; ++c) p[c] = static_cast<std::uint8_t>(p[c] + part * (color[c] - p[c]));
}

// A disc whose pixels are covered as far as 16 samples of each are.
void paint_disc(cv::Mat& bgr, double cx_px, double cy_px, double radius_px,
                const std::array<double, 3>& color) {
  for (int v = static_cast<int>(cy_px - radius_px) - 1; v <= cy_px + radius_px + 1; ++v) {
    for (int u = static_cast<int>(cx_px - radius_px) - 1; u <= cx_px + radius_px + 1; ++u) {
      int covered = 0;
      for (int i = 0; i < 16; ++i) {
        const double du = u + (i % 4 - 1.5) / 4 - cx_px, dv = v + (i / 4 - 1.5) / 4 - cy_px;
        covered += du * du + dv * dv <= radius_px * radius_px;
      }
      paint(bgr, u, v, covered / 16.0, color);
    }
  }
}

// Balls that move a little from frame to frame, before rectangles, some of nearly their colour, and noise.
cv::Mat frame(int index, int balls) {
  cv::Mat bgr(height, width, CV_8UC3, cv::Scalar(120, 125, 130));
  RandomEngine engine = random_stream(1, "counted_stages");
  for (int i = 0; i < 24; ++i) {
    std::array<double, 3> color;
    for (double& channel : color) channel = uniform(engine, 40, 200);
    if (i % 6 == 0) color = {40, 45, 180};
    const int u = static_cast<int>(uniform_index(engine, width)),
              v = static_cast<int>(uniform_index(engine, height));
    const int columns = 8 + static_cast<int>(uniform_index(engine, 50)),
              rows = 8 + static_cast<int>(uniform_index(engine, 50));
    for (int k = 0; k < columns * rows; ++k) paint(bgr, u + k % columns, v + k / columns, 1, color);
  }
  constexpr std::array<std::array<int, 2>, 5> places{
      {{150, 118}, {75, 60}, {245, 60}, {75, 180}, {245, 180}}};
  for (int ball = 0; ball < balls; ++ball) {
    const auto& [u, v] = places.at(static_cast<std::size_t>(ball));
    paint_disc(bgr, u + 0.8 * index, v + 0.3 * index, 26, {35, 30, 205});
  }
  for (int i = 0; i < 3 * width * height; ++i)
    bgr.data[i] = static_cast<std::uint8_t>(bgr.data[i] + static_cast<int>(uniform_index(engine, 7)) - 3);
  return bgr;
}

Detector make_detector() {
  CameraParameters camera;
  camera.size = {width, height};
  camera.fx_px = camera.fy_px = 400;
  camera.cx_px = 0.5 * (width - 1);
  camera.cy_px = 0.5 * (height - 1);
  DetectorOptions options;
  options.radii = {{0.035, 0}};
  return Detector(std::make_shared<const RayTable>(Camera(camera)), red_table(), options);
}

using Stage = std::function<void(const cv::Mat& bgr, int index)>;

Stage classify_stage() {
  return [colors = std::make_shared<ColorLookup>(red_table()), classes = std::make_shared<ClassPictures>()](
             const cv::Mat& bgr, int) { classify(bgr, *colors, *classes); };
}

Stage segment_stage() {
  struct State {
    ColorLookup colors{red_table()};
    ClassPictures classes, opened, closed;
    ClassMorphology morphology;
    RegionMap regions;
  };
  return [state = std::make_shared<State>()](const cv::Mat& bgr, int) {
    classify(bgr, state->colors, state->classes);
    state->morphology.open(state->classes, state->opened);
    state->morphology.close(state->opened, state->closed);
    state->regions.update(state->closed, bgr.size());
  };
}

Stage detect_stage() {
  return [detector = std::make_shared<Detector>(make_detector())](const cv::Mat& bgr, int) {
    detector->detect(bgr);
  };
}

Stage track_stage() {
  return [tracker = std::make_shared<Tracker>(make_detector())](const cv::Mat& bgr, int index) {
    tracker->update(bgr, index / 30.0);
  };
}

struct CountedStage {
  const char* name;
  Stage (*make)();
  int balls = 1;    // in each frame
  int warm_up = 3;  // frames before: a tracker's ball is believed then
};
const CountedStage stages[] = {
    {"classify", classify_stage},  {"segment", segment_stage},       {"detect", detect_stage},
    {"track", track_stage, 1, 12}, {"detect_many", detect_stage, 5}, {"track_none", track_stage, 0},
};

void run() {
  for (const auto& [name, make, balls, warm_up] : stages) {
    std::vector<cv::Mat> frames;
    for (int i = 0; i < warm_up + counted; ++i) frames.push_back(frame(i, balls));
    const Stage stage = make();
    const auto look = [&](int first, int end) {
      for (int i = first; i < end; ++i) stage(frames[static_cast<std::size_t>(i)], i);
    };
    look(0, warm_up);
    counted_stage([&] { look(warm_up, warm_up + counted); });
    std::printf("%s\n", name);
  }
}

}  // namespace
}  // namespace ballservo

int main() {
  cv::setNumThreads(1);
  ballservo::run();
  return 0;
}
