#include "calibration/teaching/round_regions.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <tuple>

#include "calibration/base/fault.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "calibration/teaching/chroma_components.hpp"

namespace ballservo {
namespace {

// Boundary inliers x fill that is asked for: from the sure radius on, at the least radius, and of a ball
// smeared by motion.
constexpr double min_fit_ratio = 0.4, small_fit_ratio = 0.75, min_smeared_fit_ratio = 0.3;
constexpr double min_chroma = 6;  // of the modes' (u*, v*), from the picture's own grey
// Of a ball's mean (u*, v*), from that of what is around it: a region with less is a patch of its
// surroundings.
constexpr double min_contrast = 5;
constexpr double min_hue_agreement =
    0.85;  // of its colours: their (u*, v*) summed, over their lengths summed
constexpr double pi = 3.14159265358979323846;
constexpr double least_smear = 1.15, most_smear = 2.5;  // ratio of the axes
constexpr double most_of_box =
    0.92;  // of its rectangle: a disc drawn out to twice its width fills 0.89, a bar 1
constexpr double least_ellipse_fill = 0.85;  // below it the region is no ellipse
constexpr double nearly_as_round = 0.7;      // of fit ratios
constexpr double smeared_weight = 0.8;       // what an ellipse is worth beside a circle

/// A region's mask and where it lies; what both tests of roundness look at.
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
    for (int x = 1; x + 1 < mask.cols; ++x) {
      if (!mask.at<std::uint8_t>(y, x)) continue;
      const bool inner = mask.at<std::uint8_t>(y, x - 1) && mask.at<std::uint8_t>(y, x + 1) &&
                         mask.at<std::uint8_t>(y - 1, x) && mask.at<std::uint8_t>(y + 1, x);
      const int px = region.origin.x + x, py = region.origin.y + y;
      if (inner || px == 0 || py == 0 || px == region.picture.width - 1 || py == region.picture.height - 1)
        continue;
      result.push_back({{static_cast<float>(px), static_cast<float>(py)}, {0, 0}});
    }
  }
  return result;
}

/// The fraction of the boundary near the circle. Off the optical axis a ball's outline is an ellipse, so that
/// the tolerance has a part that grows with the radius: a fixed one would take the largest balls for
/// something else.
double inlier_fraction_of(const std::vector<BoundaryPoint>& boundary, const CircleEstimate& circle) {
  const double tolerance = std::max(1.5, 0.06 * circle.radius_px);
  const auto inliers = std::count_if(boundary.begin(), boundary.end(), [&](const BoundaryPoint& p) {
    return std::abs((p.position_px.cast<double>() - circle.center_px).norm() - circle.radius_px) <= tolerance;
  });
  return static_cast<double>(inliers) / static_cast<double>(boundary.size());
}

/// How well disc and region cover each other; 0 when much of the disc lies outside the picture.
double fill_of(const Placed& region, const CircleEstimate& circle) {
  const double radius = circle.radius_px + 0.5;  // boundary pixels' centres lie half a pixel inside the edge
  const Eigen::Vector2d at = circle.center_px;
  const cv::Mat& mask = region.mask;
  // A circle far larger than its region is none; asking first also bounds the loop below.
  if (!(radius <= mask.cols + mask.rows)) return 0;
  long disc = 0, common = 0, off_picture = 0;
  for (int y = static_cast<int>(std::floor(at.y() - radius)); y <= std::ceil(at.y() + radius); ++y) {
    for (int x = static_cast<int>(std::floor(at.x() - radius)); x <= std::ceil(at.x() + radius); ++x) {
      if ((Eigen::Vector2d(x, y) - at).squaredNorm() > radius * radius) continue;
      if (x < 0 || y < 0 || x >= region.picture.width || y >= region.picture.height) {
        ++off_picture;
        continue;
      }
      ++disc;
      const int mx = x - region.origin.x, my = y - region.origin.y;
      if (mx >= 0 && my >= 0 && mx < mask.cols && my < mask.rows && mask.at<std::uint8_t>(my, mx)) ++common;
    }
  }
  if (disc == 0 || off_picture * 4 > disc) return 0;
  return static_cast<double>(common) / static_cast<double>(disc + cv::countNonZero(mask) - common);
}

/// The region as a ball, if it passes the circle test.
std::optional<RoundRegion> circle_test(const Placed& placed, double scale, CircleVoter& voter,
                                       const RegionSearchOptions& search) {
  const auto boundary = boundary_of(placed);
  if (boundary.size() < 8) return std::nullopt;
  if (search.before_each_test) search.before_each_test();
  RandomEngine engine = random_stream(search.seed, "region_circle", boundary.size());
  const auto circle = voter.estimate(boundary, engine);
  if (!circle || !(circle->radius_px >= search.min_radius_px)) return std::nullopt;
  // A few pixels of anything are round.
  const double smallness = std::clamp(
      (search.sure_radius_px - circle->radius_px) / (search.sure_radius_px - search.min_radius_px), 0.0, 1.0);
  const double least_fit = min_fit_ratio + smallness * (small_fit_ratio - min_fit_ratio);
  RoundRegion region;
  region.inlier_fraction = inlier_fraction_of(boundary, *circle);
  region.fill = fill_of(placed, *circle);
  region.fit_ratio = region.fill * region.inlier_fraction;
  if (!(region.fit_ratio >= least_fit)) return std::nullopt;
  region.center_px = (circle->center_px + Eigen::Vector2d(0.5, 0.5)) / scale - Eigen::Vector2d(0.5, 0.5);
  region.radius_px = (circle->radius_px + 0.5) / scale;
  region.mask = placed.mask;
  region.mask_origin = placed.origin;
  return region;
}

/// The region as a ball smeared by motion: an ellipse, which counts for less the longer it is.
std::optional<RoundRegion> ellipse_test(const Placed& placed, double scale,
                                        const RegionSearchOptions& search) {
  const cv::Moments m = cv::moments(placed.mask, true);
  const double least_radius = search.sure_radius_px;
  if (m.m00 < pi * least_radius * least_radius) return std::nullopt;
  const double xx = m.mu20 / m.m00, yy = m.mu02 / m.m00, xy = m.mu11 / m.m00;
  const double mean = (xx + yy) / 2, spread = std::hypot((xx - yy) / 2, xy);
  if (!(mean - spread > 0)) return std::nullopt;
  // A full ellipse of semi-axes a >= b has the variances a^2/4 and b^2/4.
  const double a = 2 * std::sqrt(mean + spread), b = 2 * std::sqrt(mean - spread);
  if (b < least_radius || a > most_smear * b) return std::nullopt;
  if (a < least_smear * b) return std::nullopt;  // the circle test has spoken
  std::vector<cv::Point> points;
  cv::findNonZero(placed.mask, points);
  const cv::Size2f box = cv::minAreaRect(points).size;
  if (m.m00 > most_of_box * (box.width + 1) * (box.height + 1)) return std::nullopt;
  const Eigen::Vector2d center(m.m10 / m.m00, m.m01 / m.m00);
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy), c = std::cos(angle), s = std::sin(angle);
  long common = 0, ellipse = 0;
  for (int y = -1; y <= placed.mask.rows; ++y) {
    for (int x = -1; x <= placed.mask.cols; ++x) {
      const double dx = x - center.x(), dy = y - center.y();
      const double along = (c * dx + s * dy) / a, across = (c * dy - s * dx) / b;
      if (along * along + across * across > 1) continue;
      const int px = placed.origin.x + x, py = placed.origin.y + y;
      if (px <= 0 || py <= 0 || px >= placed.picture.width - 1 || py >= placed.picture.height - 1)
        return std::nullopt;  // cut by the border: no telling what it is
      ++ellipse;
      const bool inside = x >= 0 && y >= 0 && x < placed.mask.cols && y < placed.mask.rows;
      if (inside && placed.mask.at<std::uint8_t>(y, x)) ++common;
    }
  }
  RoundRegion region;
  region.fill =
      static_cast<double>(common) / (static_cast<double>(ellipse) + m.m00 - static_cast<double>(common));
  if (region.fill < least_ellipse_fill) return std::nullopt;
  region.inlier_fraction = smeared_weight * b / a;
  region.fit_ratio = region.fill * region.inlier_fraction;
  if (region.fit_ratio < min_smeared_fit_ratio) return std::nullopt;
  region.smeared = true;
  region.center_px = (center + Eigen::Vector2d(placed.origin.x + 0.5, placed.origin.y + 0.5)) / scale -
                     Eigen::Vector2d(0.5, 0.5);
  region.radius_px = std::sqrt(a * b) / scale;
  region.mask = placed.mask;
  region.mask_origin = placed.origin;
  return region;
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

/// How far the region's mean chroma lies from that of a ring around it.
double contrast_of(const RoundRegion& region, const cv::Mat& modes, double scale) {
  const Eigen::Vector2d at =
      (region.center_px + Eigen::Vector2d(0.5, 0.5)) * scale - Eigen::Vector2d(0.5, 0.5);
  const double radius = region.radius_px * scale, inner = radius + 2, outer = 1.6 * radius + 3;
  cv::Vec2d inside(0, 0), around(0, 0);
  double inside_count = 0, around_count = 0;
  const int top = std::max(0, static_cast<int>(at.y() - outer)),
            left = std::max(0, static_cast<int>(at.x() - outer));
  for (int y = top; y <= std::min<double>(modes.rows - 1, at.y() + outer); ++y) {
    for (int x = left; x <= std::min<double>(modes.cols - 1, at.x() + outer); ++x) {
      const double distance = (Eigen::Vector2d(x, y) - at).norm();
      const int mx = x - region.mask_origin.x, my = y - region.mask_origin.y;
      const bool of_region = mx >= 0 && my >= 0 && mx < region.mask.cols && my < region.mask.rows &&
                             region.mask.at<std::uint8_t>(my, mx);
      if (distance <= radius && of_region) {
        inside += cv::Vec2d(modes.at<cv::Vec2f>(y, x));
        inside_count += 1;
      } else if (distance >= inner && distance <= outer) {
        around += cv::Vec2d(modes.at<cv::Vec2f>(y, x));
        around_count += 1;
      }
    }
  }
  if (inside_count == 0 || around_count == 0) return 0;
  return cv::norm(inside / inside_count - around / around_count);
}

/// How far the region's colours agree in hue: the length of the sum of its (u*, v*) over the sum of their
/// lengths, 1 for one hue in any lightness, near 0 for hues all around.
double hue_agreement(const RoundRegion& region, const cv::Mat& modes) {
  cv::Vec2d sum(0, 0);
  double lengths = 0;
  for (int y = 0; y < region.mask.rows; ++y) {
    for (int x = 0; x < region.mask.cols; ++x) {
      if (!region.mask.at<std::uint8_t>(y, x)) continue;
      const cv::Vec2d chroma = modes.at<cv::Vec2f>(region.mask_origin.y + y, region.mask_origin.x + x);
      sum += chroma;
      lengths += cv::norm(chroma);
    }
  }
  return lengths > 0 ? cv::norm(sum) / lengths : 0;
}

}  // namespace

RoundRegions find_round_regions(const cv::Mat& bgr, const RegionSearchOptions& search) {
  if (bgr.empty() || bgr.type() != CV_8UC3)
    throw InputError("picture", "not 8-bit colour", "an 8-bit BGR picture");
  RoundRegions result;
  const double pixels = static_cast<double>(bgr.total());
  cv::Mat working = bgr;
  if (pixels > search.max_working_pixels) {
    const double wanted = std::sqrt(search.max_working_pixels / pixels);
    cv::resize(bgr, working, {}, wanted, wanted, cv::INTER_AREA);
  }
  result.scale = static_cast<double>(working.cols) / bgr.cols;
  const cv::Mat chroma = chroma_image(working);
  const double radius = chroma_radius(chroma);
  result.modes = mean_shift_filter(chroma, radius);

  const double least_area = 0.5 * pi * search.min_radius_px * search.min_radius_px;
  const ComponentOptions components{radius, min_chroma, least_area};
  std::set<std::tuple<int, int, int, int, int>> seen;
  std::vector<RoundRegion> found;
  CircleVoter voter;
  // A fist around a ball is round as well.
  const auto keep_if_of_one_hue = [&](std::optional<RoundRegion> region) {
    if (!region || hue_agreement(*region, result.modes) < min_hue_agreement) return;
    region->contrast = contrast_of(*region, result.modes, result.scale);
    region->stands_out = region->contrast >= min_contrast;
    found.push_back(std::move(*region));
  };
  for_each_segmentation(result.modes, components, [&](const std::vector<int>& labels) {
    for (const Component& c : components_of(labels, working.cols, working.rows)) {
      if (c.area < least_area || !seen.insert({c.area, c.left, c.top, c.right, c.bottom}).second) continue;
      const Placed whole{filled_mask(labels, working.cols, c), {c.left - 1, c.top - 1}, working.size()};
      keep_if_of_one_hue(circle_test(whole, result.scale, voter, search));
      if (!compact(whole, c.area)) continue;
      const Placed smooth = opened(whole, c.area);
      auto region = circle_test(smooth, result.scale, voter, search);
      if (!region) region = ellipse_test(smooth, result.scale, search);
      keep_if_of_one_hue(std::move(region));
    }
  });
  // A place keeps its roundest region; among nearly equal ones the larger, which has more of the ball's
  // shade. What is hardly round keeps no place from a ball that lies before it.
  const auto score = [](const RoundRegion& r) { return r.fit_ratio * std::cbrt(r.radius_px); };
  std::stable_sort(found.begin(), found.end(), [&](const RoundRegion& a, const RoundRegion& b) {
    return a.stands_out != b.stands_out ? a.stands_out : score(a) > score(b);
  });
  for (RoundRegion& region : found) {
    const bool taken =
        std::any_of(result.regions.begin(), result.regions.end(), [&](const RoundRegion& other) {
          return other.fit_ratio >= nearly_as_round * region.fit_ratio &&
                 (other.center_px - region.center_px).norm() < 0.7 * (other.radius_px + region.radius_px);
        });
    if (taken) continue;
    result.regions.push_back(std::move(region));
  }
  return result;
}

}  // namespace ballservo
