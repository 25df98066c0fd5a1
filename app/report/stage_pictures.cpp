#include "app/report/stage_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "app/report/overlay.hpp"

namespace ballservo {
namespace {

using Candidate = DetectionStages::Candidate;

const cv::Scalar white(255, 255, 255), yellow(60, 220, 255), magenta(220, 60, 255), cyan(255, 220, 40);

cv::Mat class_picture(const cv::Mat& classes, const ColorTable& colors) {
  cv::Mat picture(classes.size(), CV_8UC3, cv::Scalar(24, 24, 24));
  for (std::size_t k = 1; k <= colors.classes.size(); ++k) {
    picture.setTo(class_display_color(colors, static_cast<ClassIndex>(k)), classes == static_cast<int>(k));
  }
  return picture;
}

cv::Mat darkened(const cv::Mat& bgr) { return bgr * 0.35; }

void paint_pixels(cv::Mat& picture, const std::vector<BoundaryPixel>& pixels, const cv::Vec3b& color) {
  for (const BoundaryPixel& pixel : pixels) picture.at<cv::Vec3b>(pixel.v_px, pixel.u_px) = color;
}

// The centre votes, a pixel a cell.
cv::Mat1w counts_of(const VoteHistogram& votes) {
  cv::Mat1w counts(votes.rows, votes.columns);
  std::copy_n(votes.counts.begin(), counts.total(), counts.begin());
  return counts;
}

// The histogram of the centre votes as an upright picture of its own, brightest where the votes are most.
cv::Mat histogram_picture(const Candidate& candidate) {
  cv::Mat levels;
  cv::divide(counts_of(candidate.votes), std::max(1, candidate.estimate.center_peak), levels, 1, CV_64F);
  cv::sqrt(levels, levels);
  levels.convertTo(levels, CV_8U, 255);
  cv::Mat picture;
  cv::applyColorMap(levels, picture, cv::COLORMAP_VIRIDIS);
  const double zoom = std::max(1.0, std::floor(480.0 / std::max(picture.cols, picture.rows)));
  cv::resize(picture, picture, {}, zoom, zoom, cv::INTER_NEAREST);
  return picture;
}

std::string histogram_title(const char* what, const Candidate& candidate) {
  return fmt::format("{}: {} votes, peak {}, Q_c {:.3f}", what, candidate.estimate.votes,
                     candidate.estimate.center_peak, candidate.estimate.quality());
}

/// At each circle that is no ball the number of the reason; the reasons stand in the lower left corner.
class ReasonNotes {
 public:
  explicit ReasonNotes(cv::Mat& picture) : picture_(picture), scale_(label_scale(picture.cols)) {}

  void add(const std::string& reason, const Eigen::Vector2d& top_px) {
    if (reason.empty() || !top_px.allFinite()) return;
    const auto known = std::find(reasons_.begin(), reasons_.end(), reason);
    circles_.emplace_back(known - reasons_.begin() + 1, top_px.cwiseMax(-1e5).cwiseMin(1e5).cast<int>());
    if (known == reasons_.end()) reasons_.push_back(reason);
  }
  /// No text covers another.
  void draw() const {
    std::vector<cv::Rect> texts;
    for (std::size_t k = reasons_.size(); k > 0; --k)
      draw_text_apart(picture_, fmt::format("{}: {}", k, reasons_[k - 1]), {0, picture_.rows}, scale_, texts);
    for (const auto& [number, at] : circles_)
      draw_text_apart(picture_, std::to_string(number), {at.x(), at.y()}, scale_, texts);
  }

 private:
  cv::Mat& picture_;
  double scale_;
  std::vector<std::string> reasons_;
  std::vector<std::pair<std::ptrdiff_t, Eigen::Vector2i>> circles_;
};

}  // namespace

std::vector<std::pair<std::string, cv::Mat>> stage_pictures(const cv::Mat& bgr, const DetectionStages& stages,
                                                            const Detector& detector) {
  const ColorTable& colors = detector.colors();
  std::vector<std::pair<std::string, cv::Mat>> pictures;
  pictures.emplace_back("source", bgr.clone());
  pictures.emplace_back("classified", class_picture(stages.classified, colors));
  pictures.emplace_back("opened", class_picture(stages.opened, colors));
  pictures.emplace_back("closed", class_picture(stages.closed, colors));

  // Outlines in their class's colour; the votes for their centres over them, where the votes fell.
  cv::Mat outlines = darkened(bgr), first = darkened(bgr), ring = darkened(bgr), estimate = bgr.clone(),
          refined = bgr.clone();
  ReasonNotes notes(estimate);
  const Camera& camera = detector.rays().camera();
  for (const Candidate& candidate : stages.candidates) {
    const cv::Scalar color = class_display_color(colors, candidate.color_class);
    paint_pixels(outlines, candidate.outline,
                 cv::Vec3b(static_cast<std::uint8_t>(color[0]), static_cast<std::uint8_t>(color[1]),
                           static_cast<std::uint8_t>(color[2])));
    const VoteHistogram& votes = candidate.votes;
    const cv::Mat1w counts = counts_of(votes);
    std::vector<cv::Point> cells;
    cv::findNonZero(counts, cells);
    for (const cv::Point& cell : cells) {
      const Eigen::Vector2d p = votes.origin_px + votes.cell_px * Eigen::Vector2d(cell.x, cell.y);
      const auto pixel = camera.project({p.x(), p.y(), camera.focal_px()});
      if (!pixel) continue;
      const int u = static_cast<int>(std::lround(pixel->x())), v = static_cast<int>(std::lround(pixel->y()));
      if (u < 0 || v < 0 || u >= outlines.cols || v >= outlines.rows) continue;
      cv::Vec3b& at = outlines.at<cv::Vec3b>(v, u);
      for (int c = 0; c < 3; ++c) at[c] = cv::saturate_cast<std::uint8_t>(at[c] + 40 + 30 * counts(cell));
    }
    for (const Eigen::Vector2d& p : candidate.ring_px)
      cv::circle(ring, {static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y()))}, 0, cyan,
                 -1);
    draw_polyline(estimate, candidate.estimate_outline_px, true,
                  candidate.accepted ? yellow : cv::Scalar(128, 128, 128));
    if (candidate.accepted) {
      draw_polyline(refined, candidate.refined_outline_px, true, magenta);
    } else if (const CircleEstimate& circle = candidate.estimate;
               const auto center_px =
                   camera.project({circle.center_px.x(), circle.center_px.y(), camera.focal_px()})) {
      notes.add(candidate.reason, *center_px - Eigen::Vector2d(0, circle.radius_px));
    }
  }
  notes.draw();
  if (!stages.candidates.empty()) {
    const auto best = std::find_if(stages.candidates.begin(), stages.candidates.end(),
                                   [](const Candidate& c) { return c.accepted; });
    const Candidate& shown = best != stages.candidates.end() ? *best : stages.candidates.front();
    paint_pixels(first, shown.outline, {255, 255, 255});
    paint_pixels(first, shown.removed, {60, 60, 255});
    draw_polyline(first, shown.estimate_outline_px, true, yellow);
  }
  pictures.emplace_back("outlines and centre votes", outlines);
  pictures.emplace_back("first circle (yellow) and what it removes (red)", first);
  pictures.emplace_back("ring pixels and edge points used", ring);
  pictures.emplace_back("estimate by votes (grey: rejected, and why)", estimate);
  pictures.emplace_back("refined", refined);

  if (!stages.candidates.empty()) {
    const auto by_quality = [](const Candidate& a, const Candidate& b) {
      return a.estimate.quality() < b.estimate.quality();
    };
    const auto [least, most] =
        std::minmax_element(stages.candidates.begin(), stages.candidates.end(), by_quality);
    pictures.emplace_back(histogram_title("centre votes of the roundest region", *most),
                          histogram_picture(*most));
    if (least != most)
      pictures.emplace_back(histogram_title("centre votes of the least round", *least),
                            histogram_picture(*least));
  }
  return pictures;
}

}  // namespace ballservo
