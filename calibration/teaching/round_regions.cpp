#include "calibration/teaching/round_regions.hpp"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "calibration/base/fault.hpp"
#include "calibration/teaching/chroma_picture.hpp"
#include "calibration/teaching/circle_seeds.hpp"

namespace ballservo {
namespace {

constexpr double least_region_log_odds = -8;            // a region below is no candidate
constexpr double least_chroma = 4;                      // (a, b); a disc of less has no colour to learn
constexpr double least_smear = 1.15, most_smear = 2.5;  // ratio of the axes
constexpr double least_smeared_radius_px = 8;
constexpr double most_of_box =
    0.92;  // of its rectangle: a disc drawn out to twice its width fills 0.89, a bar 1
constexpr double least_ellipse_fill = 0.85;  // below it the region is no ellipse
constexpr double hardly_round = -4;  // log odds; only where nothing reaches it a smeared ball is looked for
// Outlines so near each other, in radii, are drawn to the same rim; those near a sure one's rim to that.
constexpr double same_place = 0.12, drawn_place = 0.4, sure_outline_log_odds = 15;
constexpr double same_hue_rad = 0.3;
constexpr std::size_t asked_at_once = 16;

/// An outline that was looked at, and how far around it the answer holds.
struct Judged {
  Outline outline;
  double hue, reach;
};

/// Is this circle a ball of this colour?
struct Question {
  Outline seed;
  Eigen::Vector3d color;
  double hue;
};

/// A region's mask and where it lies.
struct Placed {
  cv::Mat mask;      // with an empty margin of at least one pixel
  cv::Point origin;  // of the mask, in the working picture
};

/// The fullest hues of the disc, at most two: the mean (L, a, b) of what has them. Hidden in part, a ball may
/// show less than what hides it.
std::vector<Eigen::Vector3d> disc_colors(const cv::Mat3f& lab, const Outline& disc) {
  constexpr int bins = 36, reach = 3;
  constexpr double inner = 0.75, also_full = 0.4;
  struct Sum {
    double chroma = 0, count = 0;
    Eigen::Vector3d lab{0, 0, 0};
  };
  std::array<Sum, bins> hues;
  const double radius = inner * disc.radius_px, step = std::max(1.0, radius / 12);
  for (double y = -radius; y <= radius; y += step) {
    for (double x = -radius; x <= radius; x += step) {
      const int u = cvRound(disc.center_px.x() + x), v = cvRound(disc.center_px.y() + y);
      if (x * x + y * y > radius * radius || u < 0 || v < 0 || u >= lab.cols || v >= lab.rows) continue;
      const cv::Vec3f& c = lab(v, u);
      const double turn = (std::atan2(c[2], c[1]) / (2 * M_PI) + 0.5) * bins;
      Sum& sum = hues[static_cast<std::size_t>(turn) % bins];
      sum.chroma += std::hypot(c[1], c[2]);
      sum.count += 1;
      sum.lab += Eigen::Vector3d(c[0], c[1], c[2]);
    }
  }
  std::vector<Eigen::Vector3d> result;
  double fullest = 0;
  for (int round = 0; round < 2; ++round) {
    std::array<Sum, bins> around;
    for (int i = 0; i < bins; ++i) {
      for (int d = -reach; d <= reach; ++d) {
        const Sum& hue = hues[static_cast<std::size_t>(i + d + bins) % bins];
        around[static_cast<std::size_t>(i)].chroma += hue.chroma * (reach + 1 - std::abs(d));
        around[static_cast<std::size_t>(i)].count += hue.count;
        around[static_cast<std::size_t>(i)].lab += hue.lab;
      }
    }
    const auto best = std::max_element(around.begin(), around.end(),
                                       [](const Sum& a, const Sum& b) { return a.chroma < b.chroma; });
    if (!(best->count > 0) || best->chroma < also_full * fullest) break;
    fullest = std::max(fullest, best->chroma);
    result.emplace_back(best->lab / best->count);
    for (int d = -reach; d <= reach; ++d)
      hues[static_cast<std::size_t>(best - around.begin() + d + bins) % bins] = {};
  }
  return result;
}

/// What has the colour and hangs together with the middle of the disc; nothing where it goes on out of sight.
Placed region_around(const cv::Mat3f& lab, const Outline& disc, const Eigen::Vector3d& color) {
  constexpr double reach = 3;  // radii
  const int x = cvRound(disc.center_px.x()), y = cvRound(disc.center_px.y()),
            half = cvCeil(reach * disc.radius_px);
  const cv::Rect box =
      cv::Rect(x - half, y - half, 2 * half + 1, 2 * half + 1) & cv::Rect({0, 0}, lab.size());
  Placed region{{}, box.tl() - cv::Point(1, 1)};
  cv::copyMakeBorder(ball_pixels(lab(box), color), region.mask, 1, 1, 1, 1, cv::BORDER_CONSTANT,
                     cv::Scalar(0));
  const cv::Point middle = cv::Point(x, y) - region.origin;
  if (!cv::Rect({0, 0}, region.mask.size()).contains(middle) || !region.mask.at<std::uint8_t>(middle)) {
    region.mask.setTo(0);
    return region;
  }
  cv::floodFill(region.mask, middle, cv::Scalar(128), nullptr, {}, {}, 4);
  region.mask = region.mask == 128;
  const cv::Rect found = cv::boundingRect(region.mask), whole(2, 2, box.width - 2, box.height - 2);
  if ((found & whole) != found) region.mask.setTo(0);
  return region;
}

/// A component as an ellipse, and the part of both together that they have in common.
struct Ellipse {
  Outline outline;
  double fill = 0;
};

/// The ellipse of the component's moments, where it may be a ball smeared by motion.
std::optional<Ellipse> ellipse_of(const Placed& placed) {
  const cv::Moments m = cv::moments(placed.mask, true);
  if (m.m00 < M_PI * least_smeared_radius_px * least_smeared_radius_px) return std::nullopt;
  const double xx = m.mu20 / m.m00, yy = m.mu02 / m.m00, xy = m.mu11 / m.m00;
  const double mean = (xx + yy) / 2, spread = std::hypot((xx - yy) / 2, xy);
  if (!(mean - spread > 0)) return std::nullopt;
  // A full ellipse of semi-axes a >= b has the variances a^2/4 and b^2/4.
  const double a = 2 * std::sqrt(mean + spread), b = 2 * std::sqrt(mean - spread);
  if (b < least_smeared_radius_px || a > most_smear * b || a < least_smear * b) return std::nullopt;
  std::vector<cv::Point> points;
  cv::findNonZero(placed.mask, points);
  const cv::Size2f box = cv::minAreaRect(points).size;
  if (m.m00 > most_of_box * (box.width + 1) * (box.height + 1)) return std::nullopt;
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy), radius = std::sqrt(a * b);
  const Eigen::Vector2d center(m.m10 / m.m00, m.m01 / m.m00);
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(angle).toRotationMatrix();
  Ellipse result{{center + Eigen::Vector2d(placed.origin.x, placed.origin.y), radius,
                  turn * Eigen::Vector2d(a / radius, b / radius).asDiagonal() * turn.transpose()},
                 0};
  const Eigen::Matrix2d to_unit = result.outline.shape.inverse() / radius;
  const auto common = std::count_if(points.begin(), points.end(), [&](const cv::Point& p) {
    return (to_unit * (Eigen::Vector2d(p.x, p.y) - center)).squaredNorm() <= 1;
  });
  result.fill = static_cast<double>(common) / (M_PI * a * b + m.m00 - static_cast<double>(common));
  return result.fill >= least_ellipse_fill ? std::optional(result) : std::nullopt;
}

/// The pixels inside the outline that have the ball's hue.
void find_mask(const cv::Mat3f& lab, RoundRegion& region) {
  const CircleEvidence& e = region.evidence;
  const double reach = e.radius_px * 2;
  const cv::Rect box = cv::Rect(cvFloor(e.center_px.x() - reach), cvFloor(e.center_px.y() - reach),
                                cvCeil(2 * reach) + 1, cvCeil(2 * reach) + 1) &
                       cv::Rect({0, 0}, lab.size());
  region.mask_origin = box.tl();
  region.mask = ball_pixels(lab(box), e.color);
}

/// The most likely ball first.
void sort_by_likelihood(std::vector<RoundRegion>& regions) {
  std::stable_sort(regions.begin(), regions.end(), [](const RoundRegion& a, const RoundRegion& b) {
    return a.evidence.log_odds() > b.evidence.log_odds();
  });
}

/// What has many of its colour and size is a part of their pattern: a wall's tiles, a fabric's dots.
void count_alike(std::vector<RoundRegion>& regions) {
  constexpr double same_size = 1.3, same_color = 15, most_balls = 10;  // Lab
  constexpr double weight = 2;
  for (RoundRegion& region : regions) {
    const auto alike = std::count_if(regions.begin(), regions.end(), [&](const RoundRegion& other) {
      return std::abs(std::log(other.radius_px / region.radius_px)) < std::log(same_size) &&
             (other.evidence.color - region.evidence.color).norm() < same_color;
    });
    region.evidence.pattern = weight * std::max(0.0, std::log(static_cast<double>(alike) / most_balls));
  }
  sort_by_likelihood(regions);
}

}  // namespace

RoundRegions find_round_regions(const cv::Mat& bgr, const RegionSearchOptions& search) {
  if (bgr.empty() || bgr.type() != CV_8UC3)
    throw InputError("picture", "not 8-bit colour", "an 8-bit BGR picture");
  RoundRegions result;
  cv::Mat& working = result.working = bgr;
  if (std::min(bgr.rows, bgr.cols) < 4) return result;
  const double pixels = static_cast<double>(bgr.total());
  if (pixels > search.max_working_pixels) {
    const double wanted = std::sqrt(search.max_working_pixels / pixels);
    cv::resize(bgr, working, {}, wanted, wanted, cv::INTER_AREA);
  }
  result.scale = static_cast<double>(working.cols) / bgr.cols;
  const cv::Mat3f lab = lab_image(working);
  cv::Mat3f smooth_lab;
  cv::medianBlur(lab, smooth_lab, 5);

  const std::vector<Outline> seeds = circle_seeds(lab, search.min_radius_px);
  std::vector<RoundRegion> found;
  std::vector<Judged> judged;
  const auto keep = [&](const CircleEvidence& e, bool smeared) {
    const cv::Rect2d picture(-0.5, -0.5, lab.cols, lab.rows);
    if (e.log_odds() < least_region_log_odds || !picture.contains({e.center_px.x(), e.center_px.y()})) return;
    RoundRegion region;
    region.evidence = e;
    region.center_px = (e.center_px + Eigen::Vector2d(0.5, 0.5)) / result.scale - Eigen::Vector2d(0.5, 0.5);
    region.radius_px = e.radius_px / result.scale;
    region.smeared = smeared;
    found.push_back(std::move(region));
  };
  std::vector<Question> questions;
  for (const Outline& seed : seeds) {
    for (const Eigen::Vector3d& color : disc_colors(lab, seed)) {
      if (color.tail<2>().norm() >= least_chroma)
        questions.push_back({seed, color, std::atan2(color.z(), color.y())});
    }
  }
  const auto is_known = [&](const Question& question) {
    const Outline& seed = question.seed;
    return std::any_of(judged.begin(), judged.end(), [&](const Judged& other) {
      const double apart = (other.outline.center_px - seed.center_px).norm() / other.outline.radius_px;
      return std::abs(std::remainder(question.hue - other.hue, 2 * M_PI)) < same_hue_rad &&
             apart < other.reach && std::abs(seed.radius_px / other.outline.radius_px - 1) < other.reach;
    });
  };
  // Some are asked side by side; then each is taken in its turn, or left out if the turns before answer it.
  std::array<CircleEvidence, asked_at_once> answers;
  for (std::size_t first = 0; first < questions.size(); first += asked_at_once) {
    const std::size_t count = std::min(asked_at_once, questions.size() - first);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      const Question& question = questions[first + i];
      if (!is_known(question)) answers[i] = circle_evidence(lab, question.seed, question.color);
    });
    for (std::size_t i = 0; i < count; ++i) {
      if (search.before_each_test) search.before_each_test();
      const Question& question = questions[first + i];
      if (is_known(question)) continue;
      const CircleEvidence& e = answers[i];
      judged.push_back({question.seed, question.hue, same_place});
      if (e.log_odds() > sure_outline_log_odds)
        judged.push_back({{e.center_px, e.radius_px}, question.hue, drawn_place});
      keep(e, false);
    }
  }
  const bool nothing_round = std::none_of(found.begin(), found.end(), [](const RoundRegion& region) {
    return region.evidence.log_odds() >= hardly_round;
  });
  if (nothing_round) {
    for (const Judged& at : judged) {
      const auto colors = disc_colors(smooth_lab, at.outline);
      if (colors.empty()) continue;
      const auto ellipse = ellipse_of(region_around(smooth_lab, at.outline, colors.front()));
      if (!ellipse) continue;
      CircleEvidence e = circle_evidence(lab, ellipse->outline, colors.front());
      e.center_px = ellipse->outline.center_px;
      e.radius_px = ellipse->outline.radius_px;
      e.contour = 3 * (ellipse->fill - 0.6);  // the rim itself is smeared
      keep(e, true);
    }
  }
  sort_by_likelihood(found);
  for (RoundRegion& region : found) {
    const bool taken =
        std::any_of(result.regions.begin(), result.regions.end(), [&](const RoundRegion& other) {
          return (other.center_px - region.center_px).norm() < 0.7 * (other.radius_px + region.radius_px);
        });
    if (taken) continue;
    find_mask(smooth_lab, region);
    result.regions.push_back(std::move(region));
  }
  count_alike(result.regions);
  return result;
}

}  // namespace ballservo
