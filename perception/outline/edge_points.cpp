#include "perception/outline/edge_points.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "calibration/base/statistics.hpp"
#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

// An arc segment's place is never believed better than this: the model has no texture and no shadows.
constexpr double sigma_floor_px = 0.01;
// Of the ring, to each side of the assumed outline; the former around small balls.
constexpr double least_half_width_px = 2.5, most_half_width_px = 5;
// Of the outline that makes one edge point. A large ball has arc segments of the latter length with gaps
// between them: more pixels would tell little more.
constexpr double segment_length_px = 6, max_segment_length_px = 9;
constexpr int min_segments = 16, max_segments = 48;
// Grey levels between inside and outside. In the dark less will do: a part of the brighter side's level.
constexpr double bright_contrast = 10, contrast_share = 0.13;
// How far from the assumed outline an edge may lie: px, or, of a large ball, a part of its radius.
constexpr double max_offset_px = 3, max_offset_radii = 0.07;
// What is surely inside or outside for the colours to be compared: clear of the blur.
constexpr float clear_of_edge_px = 1.5f;
// Between levels that near to each other no edge can be placed, however dark it is.
constexpr double least_contrast = 4;
// The same where colours are coarse.
constexpr float coarse_clear_px = 2;
// What halving the colours' resolution and interpolating adds to their blur, and how well an edge that they
// alone show is placed at best.
constexpr double coarse_chroma_blur_px = 0.75, coarse_chroma_sigma_px = 0.4;
// What coding leaves of noise is alike in neighbouring pixels: edges err by so much more than the residuals
// say. Where luma is surer than that, chroma adds nothing.
constexpr double coded_noise = 1.7, clear_luma_sigma_px = 0.25;
// Half resolution moves the colours' edge by less: where luma puts it elsewhere, it is another edge.
constexpr double luma_and_colors_agree_px = 1;
// Averaging over two pixels and interpolating widens a blur by up to 0.9 px^2 in each halved direction;
// shading says as much as the noise (sigma), and a blur that is not well known more. An edge is asked only
// where it is clear in luma and in colour.
constexpr double coarse_chroma_px2 = 0.5, blur_noise_px2 = 0.35, clear_contrast = 20;
// Of the camera's response a texture may seem to say much: one segment counts no more than this. And what the
// profile leaves beyond a camera's noise (grey levels^2) is structure, whose pixels err together: the
// evidence counts by as much less (half and twice that tell the same pictures).
constexpr double most_of_a_segment = 4, clearly_the_balls = 0.5, noise_variance = 3;

int to_pixel(double position, int last) {
  return static_cast<int>(std::clamp(position, 0.0, static_cast<double>(last)));
}

Eigen::Vector3f grey_levels(const cv::Vec3b& bgr) { return Eigen::Vector3f(bgr[0], bgr[1], bgr[2]); }
Eigen::Vector3f grey_levels(const Eigen::Array3f& light, const CameraResponse& response) {
  return light.unaryExpr(
      [&](float of) { return static_cast<float>(response.shown(static_cast<double>(of)).level); });
}
Eigen::Vector3f on_curve(const std::array<float, 256>& of_level, const cv::Vec3b& bgr) {
  return Eigen::Vector3f(of_level[bgr[0]], of_level[bgr[1]], of_level[bgr[2]]);
}

struct Interval {
  double low, high;
};

// The x with |slope x + offset| <= limit.
Interval where_within(double slope, double offset, double limit) {
  constexpr double everything = 1e6;
  if (std::abs(slope) * everything <= limit)
    return std::abs(offset) <= limit ? Interval{-everything, everything} : Interval{everything, -everything};
  const double a = (-limit - offset) / slope, b = (limit - offset) / slope;
  return {std::min(a, b), std::max(a, b)};
}

// Of four pixels beside each other: how far their rays lie from the cone's axis towards a station and along
// the outline, and their distances from the outline.
struct FourDistances {
  Eigen::Array4f radial, tangential, distance_px;
};

// Distances from the outline near one station. In floats, but of the rays' small differences from the
// station's ray: exact to 1e-5 px however long the lens is.
struct OutlineDistance {
  float sine, cosine;  // of the cone's angle
  Eigen::Vector3d ray;
  Eigen::Vector3f axis, outward, along;
  float px_per_rad, slope_before, slope_after;  // between the stations the scale changes linearly

  /// Of four rays in a row.
  FourDistances operator()(const Eigen::Vector3d* rays) const {
    Eigen::Array4f x, y, z;
    for (int i = 0; i < 4; ++i) {
      x[i] = static_cast<float>(rays[i].x() - ray.x());
      y[i] = static_cast<float>(rays[i].y() - ray.y());
      z[i] = static_cast<float>(rays[i].z() - ray.z());
    }
    const auto part = [&](const Eigen::Vector3f& e) -> Eigen::Array4f {
      return e.x() * x + e.y() * y + e.z() * z;
    };
    FourDistances four;
    four.radial = sine + part(outward);
    four.tangential = part(along);
    // sin(angle from the axis - alpha), and the angle itself where it counts: near the outline.
    const Eigen::Array4f across = (four.radial.square() + four.tangential.square()).sqrt();
    const Eigen::Array4f outside = across * cosine - (cosine + part(axis)) * sine;
    const Eigen::Array4f turn = four.tangential / four.radial;  // its tangent is as good
    four.distance_px = (outside + outside.cube() * (1.0f / 6)) *
                       (px_per_rad + turn.min(0.0f) * slope_before + turn.max(0.0f) * slope_after);
    return four;
  }
};

}  // namespace

EdgeOffsets edge_offsets(const OutlineEdges& edges, const ConeFit& fit) {
  EdgeOffsets offsets(edges.segments);
  offsets.values.fill(std::numeric_limits<float>::quiet_NaN());
  for (const EdgePoint& edge : edges.points) {
    offsets[offsets.sector_at(edge.angle_rad)] =
        static_cast<float>(angle_outside(fit, edge.ray) * edge.px_per_rad);
  }
  return offsets;
}

EdgeMeter::Station EdgeMeter::station_at(const Camera& camera, const TangentCone& cone,
                                         const Eigen::Matrix<double, 3, 2>& basis, double angle) {
  Station station;
  station.outward = basis * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const Eigen::Vector3d along = basis * Eigen::Vector2d(-std::sin(angle), std::cos(angle));
  const double sine = std::sin(cone.alpha_rad), cosine = std::cos(cone.alpha_rad);
  const Eigen::Vector3d ray = cone.axis * cosine + station.outward * sine;
  const auto pixel = camera.project(ray);
  const auto jacobian = camera.project_jacobian(ray);
  if (!pixel || !jacobian) return station;
  const Eigen::Vector2d tangent = *jacobian * along;
  const Eigen::Vector2d opening = *jacobian * (station.outward * cosine - cone.axis * sine);
  const double length = tangent.norm();
  if (!(length > 0)) return station;
  // The part of the motion that is perpendicular to the outline.
  station.px_per_rad = std::abs(opening.x() * tangent.y() - opening.y() * tangent.x()) / length;
  station.pixel_px = *pixel;
  station.normal = Eigen::Vector2d(tangent.y(), -tangent.x()) / length;
  station.visible = station.px_per_rad > 0 && std::isfinite(station.px_per_rad);
  return station;
}

// The pixels of the ring near one station, with their distances from the outline.
void EdgeMeter::gather(const cv::Mat& bgr, const RayTable& rays, const TangentCone& outline,
                       std::size_t segment) {
  pixels_.clear();
  const double half_turn_rad = ring_.half_turn_rad, half_width_px = ring_.half_width_px;
  const std::size_t count = stations_.size();
  const Station& station = stations_[segment];
  const Station &before = stations_[(segment + count - 1) % count], &after = stations_[(segment + 1) % count];
  if (!station.visible || !before.visible || !after.visible) return;
  const Eigen::Vector3d along = outline.axis.cross(station.outward);
  const double sine = std::sin(outline.alpha_rad), cosine = std::cos(outline.alpha_rad);
  const double step_rad = 2 * M_PI / static_cast<double>(count);
  const float widest = static_cast<float>(std::tan(half_turn_rad)),
              half_width = static_cast<float>(half_width_px);
  const OutlineDistance distances{static_cast<float>(sine),
                                  static_cast<float>(cosine),
                                  outline.axis * cosine + station.outward * sine,
                                  outline.axis.cast<float>(),
                                  station.outward.cast<float>(),
                                  along.cast<float>(),
                                  static_cast<float>(station.px_per_rad),
                                  static_cast<float>((station.px_per_rad - before.px_per_rad) / step_rad),
                                  static_cast<float>((after.px_per_rad - station.px_per_rad) / step_rad)};
  // The box of the segment: half_width across the outline, and along it half its length.
  const double half_length_px = half_turn_rad * sine * station.px_per_rad;
  const Eigen::Vector2d& c = station.pixel_px;
  const Eigen::Vector2d reach = half_width_px * station.normal.cwiseAbs() +
                                half_length_px * station.normal.reverse().cwiseAbs() + Eigen::Vector2d(1, 1);
  if (((c + reach).array() < 0).any() || c.x() - reach.x() > bgr.cols || c.y() - reach.y() > bgr.rows) return;
  const int top = to_pixel(c.y() - reach.y(), bgr.rows - 1),
            bottom = to_pixel(c.y() + reach.y() + 1, bgr.rows - 1);
  constexpr int rows_ahead = 2;  // as long as memory takes
  // Its sides slant: in each row only what lies between them, with room for the lens and the outline's bend.
  const double room_px = 0.3 + 0.5 * half_length_px * half_length_px / (sine * station.px_per_rad);
  for (int v = top; v <= bottom; ++v) {
    const cv::Vec3b* row = bgr.ptr<cv::Vec3b>(v);
    const double down = v - c.y();
    const Interval across_it =
        where_within(station.normal.x(), station.normal.y() * down, half_width_px + room_px);
    const Interval along_it =
        where_within(-station.normal.y(), station.normal.x() * down, half_length_px + room_px);
    const double from = std::max(across_it.low, along_it.low), to = std::min(across_it.high, along_it.high);
    if (from > to) continue;
    const int left = to_pixel(std::ceil(c.x() + from), bgr.cols - 1),
              right = to_pixel(c.x() + to, bgr.cols - 1);
    if (v + rows_ahead <= bottom) rays.prefetch(left, right, v + rows_ahead);
    for (int u = left; u <= right;) {
      const Eigen::Vector3d* const rays_here = rays.pixel_ray(u, v);
      if (!rays_here) {
        ++u;
        continue;
      }
      const FourDistances four = distances(rays_here);
      const int pixels = std::min(4, right - u + 1);
      for (int i = 0; i < pixels; ++i, ++u) {
        const float radial = four.radial[i], tangential = four.tangential[i];
        // On a border between two segments a pixel belongs to the earlier one.
        if (radial > 0 && tangential <= widest * radial && tangential > -widest * radial &&
            std::abs(four.distance_px[i]) <= half_width)
          pixels_.push_back({four.distance_px[i], row[u]});
      }
    }
  }
}

// The step's place to half a pixel: where the mean falls most between two pixels inside and two outside.
double EdgeMeter::coarse_offset(double reach_px) const {
  // Sums over bins of half a pixel from -8 to 8 px: sum[i] is of all the bins before i.
  constexpr int bins = 32;
  std::array<float, bins + 1> sum{};
  std::array<int, bins + 1> count{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(samples_.count); ++i) {
    const auto bin =
        static_cast<std::size_t>(std::clamp(2 * (samples_.distance_px[i] + 8), 0.0f, bins - 1.0f));
    sum[bin + 1] += samples_.intensity[i];
    ++count[bin + 1];
  }
  for (std::size_t i = 0; i < bins; ++i) sum[i + 1] += sum[i], count[i + 1] += count[i];
  double best_score = -1, best = 0;
  const int reach = std::min(static_cast<int>(2 * reach_px), bins / 2 - 4);
  for (int shift = -reach; shift <= reach; ++shift) {
    const auto at = static_cast<std::size_t>(bins / 2 + shift);
    const int inside = count[at] - count[at - 4], outside = count[at + 4] - count[at];
    if (inside < 2 || outside < 2) continue;
    const double fall = static_cast<double>((sum[at] - sum[at - 4]) / static_cast<float>(inside) -
                                            (sum[at + 4] - sum[at]) / static_cast<float>(outside));
    const double score = fall * (1 - 0.05 * std::abs(shift));
    if (score > best_score) best_score = score, best = 0.5 * shift;
  }
  return best;
}

// The mean of what `of` makes of the gathered pixels so far inside and outside an edge; nothing where there
// are hardly any.
template <class Values, class Of>
std::optional<BothSides<Values>> EdgeMeter::means_beside(double edge_px, float clear_px, const Of& of) const {
  BothSides<Values> means{Values::Zero(), Values::Zero()};
  int inside = 0, outside = 0;
  for (const RingColor& pixel : pixels_) {
    const float outside_px = pixel.distance_px - static_cast<float>(edge_px);
    if (outside_px < -clear_px) means.inside += of(pixel.bgr), ++inside;
    if (outside_px > clear_px) means.outside += of(pixel.bgr), ++outside;
  }
  if (inside < 3 || outside < 3) return std::nullopt;
  means.inside /= static_cast<float>(inside);
  means.outside /= static_cast<float>(outside);
  return means;
}

// The gathered pixels' intensities: along the line in colour space from what is outside to what is inside,
// in units of the light that has the grey levels' scale in this segment, so that noise and contrast stay
// those of grey levels. Returns the least contrast that an edge must have; nothing where inside and outside
// do not differ so much.
std::optional<double> EdgeMeter::take_samples(const CameraResponse& response) {
  using Seen = Eigen::Matrix<float, 7, 1>;  // light, its slope and the brightest channel's grey level
  const auto means = means_beside<Seen>(0, clear_of_edge_px, [&](const cv::Vec3b& bgr) {
    Seen seen;
    for (int c = 0; c < 3; ++c) seen[c] = response.light[bgr[c]], seen[3 + c] = response.slope[bgr[c]];
    seen[6] = std::max({bgr[0], bgr[1], bgr[2]});
    return seen;
  });
  if (!means) return std::nullopt;
  const Eigen::Vector3f slope_inside = means->inside.segment<3>(3),
                        slope_outside = means->outside.segment<3>(3);
  const Eigen::Vector3f scale = (0.5f * (slope_inside + slope_outside)).cwiseInverse();
  const Eigen::Vector3f difference = (means->inside.head<3>() - means->outside.head<3>()).cwiseProduct(scale);
  const float contrast = difference.norm();
  const int level = static_cast<int>(std::max(means->inside(6), means->outside(6)));
  const double min_contrast = std::min(bright_contrast, std::max(least_contrast, contrast_share * level));
  if (!(static_cast<double>(contrast) >= min_contrast)) return std::nullopt;
  const Eigen::Vector3f direction = (difference / contrast).cwiseProduct(scale);
  samples_.count = 0;
  for (const RingColor& pixel : pixels_) {
    // The noise at the colour that is expected there: the pixel's own holds noise itself.
    const float mixed = std::clamp(0.5f - 0.5f * pixel.distance_px, 0.0f, 1.0f);
    const Eigen::Vector3f noise =
        direction.cwiseProduct(slope_outside + mixed * (slope_inside - slope_outside));
    samples_.add(pixel.distance_px, direction.dot(on_curve(response.light, pixel.bgr)), 1 / noise.norm());
  }
  return min_contrast;
}

std::optional<EdgeProfileFit> EdgeMeter::fit_segment(const CameraResponse& response) {
  const auto min_contrast = take_samples(response);
  if (!min_contrast) return std::nullopt;
  EdgeProfileOptions profile;
  profile.min_contrast = *min_contrast;
  profile.radius_px = ring_.radius_px;
  profile.max_offset_px = std::max(max_offset_px, max_offset_radii * ring_.radius_px);
  const double reach_px = std::min(max_offset_px, ring_.half_width_px - 2);
  const auto by_colors = fit_edge_profile(samples_, coarse_offset(reach_px), profile);
  if (!by_colors || !response.coarse_chroma) return by_colors;
  EdgeProfileFit fit = fit_coded_edge(response, *by_colors, profile);
  fit.blur_px = by_colors->blur_px;  // channels of less contrast say less of it
  return fit;
}

// The edge again where colours are coarse: by luma and, unless that leaves no doubt, by chroma, too.
EdgeProfileFit EdgeMeter::fit_coded_edge(const CameraResponse& response, const EdgeProfileFit& by_colors,
                                         const EdgeProfileOptions& options) {
  const auto doubted = [](EdgeProfileFit fit) {
    fit.sigma_px = std::hypot(fit.sigma_px, coarse_chroma_sigma_px);
    return fit;
  };
  const auto colors = colors_beside(by_colors.offset_px, response);
  if (!colors) return doubted(by_colors);  // a small ball
  auto by_luma = fit_coded({luma_of}, *colors, response, by_colors, options);
  if (by_luma && !(std::abs(by_luma->offset_px - by_colors.offset_px) < luma_and_colors_agree_px))
    by_luma.reset();
  if (by_luma) by_luma->sigma_px *= coded_noise;
  if (by_luma && by_luma->sigma_px < clear_luma_sigma_px) return *by_luma;
  auto by_chroma = fit_coded(chroma_between(*colors, response), *colors, response, by_colors, options);
  if (!by_chroma) return by_luma.value_or(doubted(by_colors));
  by_chroma = doubted(*by_chroma);
  if (!by_luma) return *by_chroma;
  // Their mean; where they contradict each other it is not believed better than they agree.
  const double luma_px2 = std::pow(by_luma->sigma_px, 2), chroma_px2 = std::pow(by_chroma->sigma_px, 2),
               apart_px = by_chroma->offset_px - by_luma->offset_px, sum_px2 = luma_px2 + chroma_px2;
  EdgeProfileFit fit = *by_luma;
  fit.offset_px += luma_px2 / sum_px2 * apart_px;
  fit.sigma_px = std::sqrt(luma_px2 * chroma_px2 / sum_px2 * std::max(1.0, apart_px * apart_px / sum_px2));
  return fit;
}

// The line in the plane of chroma along which both sides differ most.
CodedChannel EdgeMeter::chroma_between(const EdgeColors& colors, const CameraResponse& response) {
  Eigen::Vector3f apart = grey_levels(colors.inside, response) - grey_levels(colors.outside, response);
  apart.array() -= luma_of.dot(apart);
  apart.normalize();
  return {apart - apart.sum() * luma_of, coarse_chroma_blur_px};
}

// The light on both sides of an edge, clear of what coarse colours blur.
std::optional<EdgeColors> EdgeMeter::colors_beside(double edge_px, const CameraResponse& response) const {
  const float clear_px = std::min(coarse_clear_px, static_cast<float>(ring_.half_width_px) - 1);
  return means_beside<Eigen::Array3f>(edge_px, clear_px, [&](const cv::Vec3b& bgr) -> Eigen::Array3f {
    return on_curve(response.light, bgr);
  });
}

// The edge again, by one channel of a coded picture alone; nothing where that differs too little. Leaves the
// channel in the samples.
std::optional<EdgeProfileFit> EdgeMeter::fit_coded(const CodedChannel& channel, const EdgeColors& colors,
                                                   const CameraResponse& response,
                                                   const EdgeProfileFit& start,
                                                   const EdgeProfileOptions& options) {
  const float contrast = channel.of_grey.dot(grey_levels(colors.inside, response)) -
                         channel.of_grey.dot(grey_levels(colors.outside, response));
  if (!(static_cast<double>(std::abs(contrast)) >= least_contrast)) return std::nullopt;
  samples_.count = 0;
  const std::size_t stride = channel.blur_px > 0 ? 2 : 1;  // neighbours of a coarse channel tell the same
  for (std::size_t i = 0; i < pixels_.size(); i += stride)
    samples_.add(pixels_[i].distance_px, channel.of_grey.dot(grey_levels(pixels_[i].bgr)));
  return fit_coded_profile(samples_, colors, response, channel, start, options);
}

// The ring around the outline, in segments of the outline's length; false where none is in the picture.
bool EdgeMeter::place_ring(cv::Size size, const Camera& camera, const TangentCone& outline) {
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(outline.axis);
  ring_ = {};
  const Station first = station_at(camera, outline, basis, 0);
  if (!first.visible) return false;
  ring_.radius_px = std::sin(outline.alpha_rad) * first.px_per_rad;
  ring_.segments = std::clamp(static_cast<int>(2 * M_PI * ring_.radius_px / segment_length_px), min_segments,
                              max_segments);
  stations_.clear();
  for (int i = 0; i < ring_.segments; ++i) {
    stations_.push_back(station_at(camera, outline, basis, 2 * M_PI * (i + 0.5) / ring_.segments));
    const Eigen::Vector2d& p = stations_.back().pixel_px;
    if (stations_.back().visible && p.minCoeff() >= 1 && p.x() <= size.width - 2 && p.y() <= size.height - 2)
      ++ring_.segments_in_picture;
  }
  // The ring must leave a core for the level inside, also of a small ball.
  ring_.half_width_px = std::clamp(0.6 * ring_.radius_px, least_half_width_px, most_half_width_px);
  // A small ball's segments overlap, for each needs pixels enough; what they share counts once.
  const double least_length_px = segment_length_px * std::max(1.0, 6 / ring_.radius_px);
  ring_.half_turn_rad = std::min(std::max(M_PI / ring_.segments, 0.5 * least_length_px / ring_.radius_px),
                                 0.5 * max_segment_length_px / ring_.radius_px);
  return ring_.segments_in_picture > 0;
}

// Are the colours of the gathered edge blurred more than its luma? 0 where it is not clear in both. In grey
// levels: where both were blurred alike their curve is the same.
double EdgeMeter::coarse_chroma_evidence(const EdgeProfileFit& edge) {
  const auto chroma = [](const cv::Vec3b& bgr) {
    const Eigen::Vector3f grey = grey_levels(bgr);
    return Eigen::Array3f(grey.array() - luma_of.dot(grey));
  };
  const auto colors = means_beside<Eigen::Array3f>(edge.offset_px, coarse_clear_px, chroma);
  if (!colors) return 0;
  const Eigen::Vector3f direction = (colors->inside - colors->outside).matrix().normalized();
  EdgeProfileOptions options;
  options.min_contrast = clear_contrast;
  options.radius_px = ring_.radius_px;
  const auto profile_of = [&](const auto& level) {
    samples_.count = 0;
    for (const RingColor& pixel : pixels_) samples_.add(pixel.distance_px, level(pixel.bgr));
    return fit_edge_profile(samples_, edge.offset_px, options);
  };
  const auto of_luma = profile_of([](const cv::Vec3b& bgr) { return luma_of.dot(grey_levels(bgr)); });
  if (!of_luma) return 0;
  const auto of_chroma =
      profile_of([&](const cv::Vec3b& bgr) { return direction.dot(chroma(bgr).matrix()); });
  if (!of_chroma) return 0;
  // The variance of a blur's estimate is twice that of the place (Fisher information of a blurred step).
  const double luma_px2 = of_luma->blur_px * of_luma->blur_px,
               chroma_px2 = of_chroma->blur_px * of_chroma->blur_px,
               place_px2 = of_luma->sigma_px * of_luma->sigma_px;
  const double noise_px4 = blur_noise_px2 * blur_noise_px2 + 2 * (4 * luma_px2 * 2 * place_px2);
  return std::clamp((chroma_px2 - luma_px2 - 0.5 * coarse_chroma_px2) * coarse_chroma_px2 / noise_px4, -1.0,
                    1.0);
}

ResponseEvidence EdgeMeter::evidence(const cv::Mat& bgr, const RayTable& rays, const TangentCone& outline,
                                     const std::vector<EdgePoint>& points) {
  ResponseEvidence evidence;
  if (!place_ring(bgr.size(), rays.camera(), outline)) return evidence;
  const CameraResponse &srgb = CameraResponse::srgb(), &linear = CameraResponse::linear();
  for (const EdgePoint& point : points) {
    if (point.weight < clearly_the_balls) continue;
    gather(bgr, rays, outline, static_cast<std::size_t>(point.angle_rad / (2 * M_PI) * ring_.segments));
    const auto by_srgb = fit_segment(srgb), by_linear = fit_segment(linear);
    if (!by_srgb || !by_linear) continue;
    const auto values = 3 * static_cast<double>(pixels_.size());
    const double rounding = values / 12;  // of whole grey levels
    const double left_by_srgb = squares_left(pixels_, *by_srgb, srgb) + rounding,
                 left_by_linear = squares_left(pixels_, *by_linear, linear) + rounding;
    const double independent =
        values * std::min(1.0, noise_variance * values / std::min(left_by_srgb, left_by_linear));
    evidence.srgb += std::clamp(0.5 * independent * std::log(left_by_linear / left_by_srgb),
                                -most_of_a_segment, most_of_a_segment);
    evidence.coarse_chroma += coarse_chroma_evidence(*by_srgb);
  }
  return evidence;
}

void EdgeMeter::measure(const cv::Mat& bgr, const RayTable& rays, const TangentCone& outline,
                        const CameraResponse& response, OutlineEdges& edges) {
  CV_Assert(bgr.type() == CV_8UC3 && bgr.cols == rays.size().width_px && bgr.rows == rays.size().height_px);
  edges.points.clear();
  edges.blur_px = 0;
  const bool in_picture = place_ring(bgr.size(), rays.camera(), outline);
  edges.segments = ring_.segments;
  edges.segments_in_picture = ring_.segments_in_picture;
  if (!in_picture) return;
  const double overlap = std::max(1.0, ring_.half_turn_rad * ring_.segments / M_PI);
  blurs_.clear();
  for (std::size_t i = 0; i < stations_.size(); ++i) {
    gather(bgr, rays, outline, i);
    const auto fit = fit_segment(response);
    if (!fit) continue;
    const Station& station = stations_[i];
    // A blurred disc's half level lies s^2 / 2r inside its edge: the mean curvature's share of diffusion.
    const double distance_px = fit->offset_px + fit->blur_px * fit->blur_px / (2 * ring_.radius_px);
    const double edge_rad = outline.alpha_rad + distance_px / station.px_per_rad;
    EdgePoint point;
    point.ray = outline.axis * std::cos(edge_rad) + station.outward * std::sin(edge_rad);
    point.px_per_rad = station.px_per_rad;
    point.sigma_px = std::hypot(fit->sigma_px * std::sqrt(overlap), sigma_floor_px);
    point.angle_rad = 2 * M_PI * (static_cast<double>(i) + 0.5) / ring_.segments;
    edges.points.push_back(point);
    blurs_.push_back(fit->blur_px);
  }
  if (!blurs_.empty()) edges.blur_px = upper_median(blurs_);
}

}  // namespace ballservo
