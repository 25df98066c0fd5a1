#include "app/comparison/paper_measurements.hpp"

#include <algorithm>
#include <cstring>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "app/comparison/estimators/stopwatch.hpp"
#include "app/comparison/pictures/plan_pictures.hpp"
#include "app/comparison/pictures/rendered_frame.hpp"
#include "app/comparison/resampling.hpp"
#include "calibration/base/statistics.hpp"
#include "calibration/camera/ray_table.hpp"
#include "perception/detector.hpp"
#include "perception/segmentation/classification.hpp"
#include "perception/segmentation/morphology.hpp"
#include "perception/segmentation/regions.hpp"

namespace ballservo {
namespace {

constexpr int measured_frames = 16, timed_frames = 12, colors_frames = 4;
constexpr int least_region_px = 100;

// The paper's stages of one picture up to the regions.
class Stages {
 public:
  explicit Stages(std::shared_ptr<const ColorTable> colors) : colors_(std::move(colors)) {}

  void run(const cv::Mat& bgr) {
    classify(bgr, colors_, classified_);
    morphology_.open(classified_, opened_);
    morphology_.close(opened_, closed_);
    regions_.update(closed_, bgr.size());
  }
  /// What a region of the colour that is large enough shows on its boundary; `use` is told its number too.
  template <class Use>
  void for_each_region(Use use) {
    for (std::size_t r = 0; r < regions_.regions().size(); ++r) {
      const Region& region = regions_.regions()[r];
      if (region.color_class == no_class || region.absorbed_by >= 0 || region.pixels < least_region_px)
        continue;
      std::vector<BoundaryPoint> points;
      regions_.boundary(static_cast<int>(r), pixels_);
      for (const BoundaryPixel& pixel : pixels_)
        points.push_back({Eigen::Vector2f(pixel.u_px, pixel.v_px), {0, 0}});
      use(r, region, points);
    }
  }

 private:
  ColorLookup colors_;
  ClassPictures classified_, opened_, closed_;
  ClassMorphology morphology_;
  RegionMap regions_;
  std::vector<BoundaryPixel> pixels_;
};

// Every byte once, eight at a time.
double read_us(const cv::Mat& bgr) {
  const Stopwatch reading;
  std::uint64_t sum = 0;
  for (int v = 0; v < bgr.rows; ++v) {
    const std::uint8_t* row = bgr.ptr(v);
    const auto bytes = static_cast<std::size_t>(bgr.cols) * bgr.elemSize();
    for (std::size_t at = 0; at + sizeof sum <= bytes; at += sizeof sum) {
      std::uint64_t word = 0;
      std::memcpy(&word, row + at, sizeof word);
      sum += word;
    }
  }
  volatile std::uint64_t used = sum;  // so that the work is done
  static_cast<void>(used);
  return reading.us();
}

bool holds(const cv::Rect& box, const OutlineEllipse& ball) {
  return box.contains(cv::Point(static_cast<int>(ball.center_px.x()), static_cast<int>(ball.center_px.y())));
}

struct Votes {
  std::vector<double> counts, quality_ball, quality_other, boundary_px, edge_px;
};

// Every region of the colour votes as the paper has it: random triples, until a cell has 16 votes.
void collect_votes(const ComparisonCondition& condition, const std::shared_ptr<const ColorTable>& colors,
                   std::uint64_t seed, Votes& votes) {
  Stages stages(colors);
  CircleVoter voter;
  for (int k = 0; k < measured_frames; ++k) {
    const RenderedFrame frame = render_comparison_frame(condition, seed, k);
    if (!frame.truth.outline) continue;
    stages.run(frame.bgr);
    double boundary = 0;
    stages.for_each_region(
        [&](std::size_t r, const Region& region, const std::vector<BoundaryPoint>& points) {
          boundary += static_cast<double>(points.size());
          RandomEngine engine = random_stream(seed, "paper claims", static_cast<std::uint64_t>(k) * 4096 + r);
          const auto circle = voter.estimate(points, engine);
          if (!circle) return;
          const bool is_ball = holds(region.box, *frame.truth.outline);
          (is_ball ? votes.quality_ball : votes.quality_other).push_back(circle->quality());
          if (is_ball) votes.counts.push_back(circle->votes);
        });
    cv::Mat grey, edges;
    cv::cvtColor(frame.bgr, grey, cv::COLOR_BGR2GRAY);
    cv::Canny(grey, edges, 50, 150);
    votes.boundary_px.push_back(boundary);
    votes.edge_px.push_back(cv::countNonZero(edges));
  }
}

std::shared_ptr<const ColorTable> learn(const std::vector<std::string>& words, std::uint64_t seed) {
  std::vector<ComparisonCondition> balls;
  for (const std::string& word : words) balls.push_back(usual_scene("claims_teaching", word));
  return learn_rendered(balls, 2, seed);
}

// How the pixels well inside balls of each colour are told, on pictures that were not learnt from.
void tell_classes(const std::vector<std::string>& words, std::uint64_t seed, nlohmann::json& m) {
  const std::shared_ptr<const ColorTable> colors = learn(words, seed);
  double all = 0, right = 0, wrong = 0;
  for (const std::string& word : words) {
    const auto own = colors->find(word);
    for (int k = 0; k < colors_frames; ++k) {
      const RenderedFrame frame = render_comparison_frame(usual_scene("claims_told", word), seed, k);
      if (!own || !frame.truth.outline) continue;
      const OutlineEllipse& ball = *frame.truth.outline;
      const int reach = static_cast<int>(0.8 * ball.radius_px);
      for (int v = -reach; v <= reach; ++v) {
        for (int u = -reach; u <= reach; ++u) {
          const cv::Point at(static_cast<int>(ball.center_px.x()) + u,
                             static_cast<int>(ball.center_px.y()) + v);
          if (u * u + v * v > reach * reach || !cv::Rect({0, 0}, frame.bgr.size()).contains(at)) continue;
          const cv::Vec3b& pixel = frame.bgr.at<cv::Vec3b>(at);
          const ClassIndex told = colors->classify(pixel[0], pixel[1], pixel[2]);
          ++all;
          right += told == *own ? 1 : 0;
          wrong += told != *own && told != no_class ? 1 : 0;
        }
      }
    }
  }
  m["class_counts"].push_back(words.size());
  m["class_right"].push_back(right / all);
  m["class_wrong"].push_back(wrong / all);
}

nlohmann::json times(const std::shared_ptr<const ColorTable>& colors, std::uint64_t seed) {
  ComparisonCondition condition = usual_scene("claims_times", "red");
  CameraParameters p = condition.camera.parameters();
  p.size = {1024, 683};
  p.cx_px = 511.5;
  p.cy_px = 341;
  condition.camera = Camera(p);
  DetectorOptions options;
  options.fit = BallFit::paper;
  options.radii = {{condition.radius_m(), 0}};
  Detector detector(std::make_shared<const RayTable>(condition.camera), colors, options);
  Stages stages(colors);
  CircleVoter voter;
  std::vector<double> read, segment, vote, detect;
  for (int k = 0; k < timed_frames; ++k) {
    const cv::Mat bgr = render_comparison_frame(condition, seed, k).bgr;
    read.push_back(read_us(bgr));
    const Stopwatch segmenting;
    stages.run(bgr);
    segment.push_back(segmenting.us());
    stages.for_each_region([&](std::size_t, const Region&, const std::vector<BoundaryPoint>& points) {
      RandomEngine engine = random_stream(seed, "paper times", static_cast<std::uint64_t>(k));
      const Stopwatch voting;
      voter.estimate(points, engine);
      vote.push_back(voting.us());
    });
    const Stopwatch detecting;
    detector.detect(bgr);
    detect.push_back(detecting.us());
  }
  return {{"read_us", median(read)},
          {"segment_us", median(segment)},
          {"vote_us", median(vote)},
          {"detect_us", median(detect)}};
}

}  // namespace

nlohmann::json measure_paper_claims(const ComparisonPlan& plan) {
  const std::shared_ptr<const ColorTable> red = learn({"red"}, plan.seed);
  Votes apart, touching;
  ComparisonCondition condition = usual_scene("claims_apart", "red");
  condition.same_color = 4;
  collect_votes(condition, red, plan.seed, apart);
  condition.name = "claims_touching";
  condition.touching = true;
  collect_votes(condition, red, plan.seed, touching);
  nlohmann::json m = {{"votes", median(apart.counts)},
                      {"votes_largest", quantile(apart.counts, 1)},
                      {"quality_ball", median(apart.quality_ball)},
                      {"quality_touching", median(touching.quality_ball)},
                      {"quality_other", median(apart.quality_other)},
                      {"boundary_px", median(apart.boundary_px)},
                      {"edge_px", median(apart.edge_px)},
                      {"timing", times(red, plan.seed)}};
  tell_classes({"red", "green"}, plan.seed, m);
  tell_classes({"red", "green", "blue", "yellow"}, plan.seed, m);
  tell_classes({"red", "orange", "yellow", "green", "cyan", "blue", "purple", "pink"}, plan.seed, m);
  return m;
}

}  // namespace ballservo
