#include "calibration/teaching/round_regions.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <tuple>

#include "calibration/base/fault.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "calibration/teaching/chroma_components.hpp"
#include "calibration/teaching/chroma_picture.hpp"

namespace ballservo {
namespace {

constexpr double min_inlier_fraction = 0.35;  // of a component's boundary, on the circle that it proposes
constexpr double least_log_odds = -8;         // a region below is no candidate
constexpr double min_chroma = 6;              // (u*, v*), from the picture's own grey
constexpr double min_hue_agreement =
    0.85;  // of its colours: their (u*, v*) summed, over their lengths summed
constexpr double pi = 3.14159265358979323846;
constexpr double least_smear = 1.15, most_smear = 2.5;  // ratio of the axes
constexpr double least_smeared_radius_px = 8;
constexpr double most_of_box =
    0.92;  // of its rectangle: a disc drawn out to twice its width fills 0.89, a bar 1
constexpr double least_ellipse_fill = 0.85;  // below it the region is no ellipse
constexpr double hardly_round = -4;  // log odds; only where nothing reaches it a smeared ball is looked for
// Outlines so near each other, in radii, are drawn to the same rim; those near a sure one's rim to that.
constexpr double same_place = 0.12, drawn_place = 0.4, sure_log_odds = 5;
constexpr double same_hue_rad = 0.1;

/// An outline that was looked at, and how far around it the answer holds.
struct Judged {
  Outline outline;
  double hue, reach;
};

/// A region's mask and where it lies; what proposes circles.
struct Placed {
  cv::Mat mask;      // with an empty margin of at least one pixel
  cv::Point origin;  // of the mask, in the working picture
  cv::Size picture;
};

/// The outer boundary, without the pixels where the picture's border cuts the region.
std::vector<BoundaryPoint> boundary_of(const Placed& region) {
  std::vector<BoundaryPoint> result;
  const cv::Mat& mask = region.mask;
  for (int y = 1; y + 1 < mask.rows; ++y) {
    const auto *row = mask.ptr<std::uint8_t>(y), *above = mask.ptr<std::uint8_t>(y - 1),
               *below = mask.ptr<std::uint8_t>(y + 1);
    for (int x = 1; x + 1 < mask.cols; ++x) {
      if (!row[x] || (row[x - 1] && row[x + 1] && above[x] && below[x])) continue;
      const int px = region.origin.x + x, py = region.origin.y + y;
      if (px == 0 || py == 0 || px == region.picture.width - 1 || py == region.picture.height - 1) continue;
      result.push_back({{static_cast<float>(px), static_cast<float>(py)}, {0, 0}});
    }
  }
  return result;
}

/// The fraction of the boundary near the circle.
double inlier_fraction_of(const std::vector<BoundaryPoint>& boundary, const CircleEstimate& circle) {
  const double tolerance = std::max(1.5, 0.06 * circle.radius_px);
  const auto inliers = std::count_if(boundary.begin(), boundary.end(), [&](const BoundaryPoint& p) {
    return std::abs((p.position_px.cast<double>() - circle.center_px).norm() - circle.radius_px) <= tolerance;
  });
  return static_cast<double>(inliers) / static_cast<double>(boundary.size());
}

/// The circle that the component's boundary votes for.
std::optional<Outline> circle_through(const Placed& placed, CircleVoter& voter,
                                      const RegionSearchOptions& search) {
  const auto boundary = boundary_of(placed);
  if (boundary.size() < 8) return std::nullopt;
  RandomEngine engine = random_stream(search.seed, "region_circle", boundary.size());
  const auto circle = voter.estimate(boundary, engine);
  if (!circle || circle->radius_px + 0.5 < search.min_radius_px ||
      inlier_fraction_of(boundary, *circle) < min_inlier_fraction)
    return std::nullopt;
  if (2 * circle->radius_px > std::min(placed.picture.width, placed.picture.height)) return std::nullopt;
  return Outline{circle->center_px, circle->radius_px + 0.5};
}

/// A component as an ellipse, and the part of both together that they have in common.
struct Ellipse {
  Outline outline;
  double fill = 0;
};

/// The ellipse of the component's moments, where it may be a ball smeared by motion.
std::optional<Ellipse> ellipse_of(const Placed& placed) {
  const cv::Moments m = cv::moments(placed.mask, true);
  if (m.m00 < pi * least_smeared_radius_px * least_smeared_radius_px) return std::nullopt;
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
  result.fill = static_cast<double>(common) / (pi * a * b + m.m00 - static_cast<double>(common));
  return result.fill >= least_ellipse_fill ? std::optional(result) : std::nullopt;
}

/// Whether a ball may hide in the region: rules out what is long, thin, or most of the picture, before
/// anything slow.
bool compact(const Placed& placed, int area) {
  const int width = placed.mask.cols - 2, height = placed.mask.rows - 2;
  return std::max(width, height) <= 2 * std::min(width, height) && area * 3 >= width * height &&
         area * 2 <= placed.picture.area();
}

/// The region without thin growths (a blurred rim along a finger, a bridge to a neighbour).
Placed opened(const Placed& placed, int area) {
  const double radius = std::max(1.0, 0.2 * std::sqrt(area / pi));
  Placed result = placed;
  cv::Mat distance;  // opening by a disc, in two distance transforms: their cost does not grow with the disc
  cv::distanceTransform(placed.mask, distance, cv::DIST_L2, 5);
  cv::distanceTransform(distance <= radius, distance, cv::DIST_L2, 5);
  result.mask = distance <= radius;
  cv::Mat labels, stats, centers;
  const int count = cv::connectedComponentsWithStats(result.mask, labels, stats, centers, 4);
  int largest = 0;
  for (int i = 1; i < count; ++i) {
    if (largest == 0 || stats.at<int>(i, cv::CC_STAT_AREA) > stats.at<int>(largest, cv::CC_STAT_AREA))
      largest = i;
  }
  result.mask = labels == largest;
  if (largest == 0) result.mask.setTo(0);
  return result;
}

/// How far the region's colours agree in hue: the length of the sum of its (u*, v*) over the sum of their
/// lengths, 1 for one hue in any lightness, near 0 for hues all around.
double hue_agreement(const Placed& region, const cv::Mat& chroma) {
  cv::Vec2d sum(0, 0);
  double lengths = 0;
  for (int y = 1; y + 1 < region.mask.rows; ++y) {
    for (int x = 1; x + 1 < region.mask.cols; ++x) {
      if (!region.mask.at<std::uint8_t>(y, x)) continue;
      const cv::Vec2d c = chroma.at<cv::Vec2f>(region.origin.y + y, region.origin.x + x);
      sum += c;
      lengths += cv::norm(c);
    }
  }
  return lengths > 0 ? cv::norm(sum) / lengths : 0;
}

/// Mean (L, a, b) under the mask.
Eigen::Vector3d mean_color(const cv::Mat3f& lab, const Placed& region) {
  const cv::Rect all({0, 0}, lab.size()), box = cv::Rect(region.origin, region.mask.size()) & all;
  const cv::Scalar mean = cv::mean(lab(box), region.mask(box - region.origin));
  return {mean[0], mean[1], mean[2]};
}

/// The pixels inside the outline that have the ball's hue.
void find_mask(const cv::Mat3f& lab, RoundRegion& region) {
  const BallEvidence& e = region.evidence;
  const double reach = e.radius_px * 2;
  const cv::Rect box = cv::Rect(cvFloor(e.center_px.x() - reach), cvFloor(e.center_px.y() - reach),
                                cvCeil(2 * reach) + 1, cvCeil(2 * reach) + 1) &
                       cv::Rect({0, 0}, lab.size());
  region.mask_origin = box.tl();
  region.mask = ball_pixels(lab(box), e.color);
}

}  // namespace

RoundRegions find_round_regions(const cv::Mat& bgr, const RegionSearchOptions& search) {
  if (bgr.empty() || bgr.type() != CV_8UC3)
    throw InputError("picture", "not 8-bit colour", "an 8-bit BGR picture");
  RoundRegions result;
  if (std::min(bgr.rows, bgr.cols) < 4) {
    result.chroma = cv::Mat::zeros(bgr.size(), CV_32FC2);
    return result;
  }
  const double pixels = static_cast<double>(bgr.total());
  cv::Mat working = bgr;
  if (pixels > search.max_working_pixels) {
    const double wanted = std::sqrt(search.max_working_pixels / pixels);
    cv::resize(bgr, working, {}, wanted, wanted, cv::INTER_AREA);
  }
  result.scale = static_cast<double>(working.cols) / bgr.cols;
  const cv::Mat raw = chroma_image(working);
  result.chroma = smoothed_chroma(raw);
  const cv::Mat3f lab = lab_image(working);
  cv::Mat3f smooth_lab;
  cv::medianBlur(lab, smooth_lab, 5);

  const double least_area = 0.4 * pi * search.min_radius_px * search.min_radius_px;
  const ComponentOptions components{chroma_radius(raw), min_chroma, least_area};
  std::set<std::tuple<int, int, int, int, int>> seen;
  std::vector<RoundRegion> found;
  std::vector<Judged> judged;
  std::vector<std::pair<Ellipse, Placed>> ellipses;
  CircleVoter voter;
  const auto keep = [&](const BallEvidence& e, bool smeared) {
    const cv::Rect2d picture(-0.5, -0.5, lab.cols, lab.rows);
    if (e.log_odds() < least_log_odds || !picture.contains({e.center_px.x(), e.center_px.y()})) return;
    RoundRegion region;
    region.evidence = e;
    region.center_px = (e.center_px + Eigen::Vector2d(0.5, 0.5)) / result.scale - Eigen::Vector2d(0.5, 0.5);
    region.radius_px = e.radius_px / result.scale;
    region.smeared = smeared;
    found.push_back(std::move(region));
  };
  const auto judge = [&](const std::optional<Outline>& outline, const Placed& placed) {
    if (!outline) return;
    const Eigen::Vector3d color = mean_color(lab, placed);
    const double hue = std::atan2(color.z(), color.y());
    const bool known = std::any_of(judged.begin(), judged.end(), [&](const Judged& other) {
      const double apart = (other.outline.center_px - outline->center_px).norm() / other.outline.radius_px;
      return std::abs(std::remainder(hue - other.hue, 2 * pi)) < same_hue_rad && apart < other.reach &&
             std::abs(outline->radius_px / other.outline.radius_px - 1) < other.reach;
    });
    // A fist around a ball is round as well.
    if (known || hue_agreement(placed, result.chroma) < min_hue_agreement) return;
    const BallEvidence e = ball_evidence(lab, *outline, color);
    judged.push_back({*outline, hue, same_place});
    if (e.log_odds() > sure_log_odds) judged.push_back({{e.center_px, e.radius_px}, hue, drawn_place});
    keep(e, false);
  };
  for_each_segmentation(result.chroma, smooth_lab, components, [&](const std::vector<int>& labels) {
    for (const Component& c : components_of(labels, working.cols, working.rows)) {
      if (c.area < least_area || !seen.insert({c.area, c.left, c.top, c.right, c.bottom}).second) continue;
      if (search.before_each_test) search.before_each_test();
      const Placed whole{filled_mask(labels, working.cols, c), {c.left - 1, c.top - 1}, working.size()};
      judge(circle_through(whole, voter, search), whole);
      if (!compact(whole, c.area)) continue;
      const Placed smooth = opened(whole, c.area);
      judge(circle_through(smooth, voter, search), smooth);
      if (const auto ellipse = ellipse_of(smooth)) ellipses.emplace_back(*ellipse, smooth);
    }
  });
  const bool nothing_round = std::none_of(found.begin(), found.end(), [](const RoundRegion& region) {
    return region.evidence.log_odds() >= hardly_round;
  });
  if (nothing_round) {
    for (const auto& [ellipse, placed] : ellipses) {
      if (hue_agreement(placed, result.chroma) < min_hue_agreement) continue;
      BallEvidence e = ball_evidence(lab, ellipse.outline, mean_color(lab, placed));
      e.center_px = ellipse.outline.center_px;
      e.radius_px = ellipse.outline.radius_px;
      e.contour = 3 * (ellipse.fill - 0.6);  // the rim itself is smeared
      keep(e, true);
    }
  }
  std::stable_sort(found.begin(), found.end(), [](const RoundRegion& a, const RoundRegion& b) {
    return a.evidence.log_odds() > b.evidence.log_odds();
  });
  for (RoundRegion& region : found) {
    const bool taken =
        std::any_of(result.regions.begin(), result.regions.end(), [&](const RoundRegion& other) {
          return (other.center_px - region.center_px).norm() < 0.7 * (other.radius_px + region.radius_px);
        });
    if (taken) continue;
    find_mask(smooth_lab, region);
    result.regions.push_back(std::move(region));
  }
  return result;
}

}  // namespace ballservo
