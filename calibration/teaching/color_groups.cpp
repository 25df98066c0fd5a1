#include "calibration/teaching/color_groups.hpp"

#include <algorithm>

#include "calibration/base/fault.hpp"
#include "calibration/base/range_check.hpp"
#include "calibration/color/color_names.hpp"
#include "calibration/teaching/class_table.hpp"

namespace ballservo {
namespace {

constexpr std::size_t max_groups = 60;   // the best fits come first; what follows is clutter
constexpr std::size_t min_samples = 50;  // fewer say nothing about a distribution

/// Fills in every group's share, by the table that all of them together would give: a red ball is no evidence
/// against orange.
void find_round_shares(std::vector<ColorGroup>& groups, CellCounts elsewhere, const SampleOptions& samples) {
  std::vector<ClassEvidence> evidence;
  for (const ColorGroup& group : groups) {
    evidence.push_back({group.samples.cells(), group.chroma});
    for (const ColorSamples::Pixel& pixel : group.samples.pixels) {
      std::uint32_t& count = elsewhere[pixel.table_cell];
      if (count > 0) --count;
    }
  }
  const std::vector<ClassIndex> table = class_table(evidence, occupied(elsewhere), samples);
  std::vector<double> inside(groups.size() + 1, 0), outside(groups.size() + 1, 0);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    for (const ColorSamples::Pixel& pixel : groups[k].samples.pixels) {
      if (table[pixel.table_cell] == k + 1) inside[k + 1] += 1;
    }
  }
  for (std::size_t i = 0; i < elsewhere.size(); ++i) outside[table[i]] += elsewhere[i];
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const double all = inside[k + 1] + outside[k + 1];
    groups[k].round_share = all > 0 ? inside[k + 1] / all : 0;
  }
}

}  // namespace

void GroupOptions::validate() const {
  FaultList faults;
  check_range(faults, "colour groups: min_hue_overlap", min_hue_overlap, 0, 1);
  check_range(faults, "colour groups: close_hues_deg", close_hues_deg, 0, 180);
  check_range(faults, "colour groups: max_saturation_ratio", max_saturation_ratio, 1, 1e6);
  check_range(faults, "colour groups: min_colored_fraction", min_colored_fraction, 0, 1);
  check_range(faults, "colour groups: min_mean_chroma", min_mean_chroma, 0, 200);
  check_range(faults, "colour groups: min_relative_fit", min_relative_fit, 0, 1);
  check_range(faults, "colour groups: max_radius_ratio", max_radius_ratio, 1, 1e6);
  check_range(faults, "colour groups: max_speck_ratio", max_speck_ratio, 1, 1e6);
  check_range(faults, "colour groups: sure_radius_px", sure_radius_px, 0, 1e6);
  faults.throw_if_any();
}

double ColorGroup::largest_radius_px() const {
  double largest_px = 0;
  for (const BallCandidate& ball : balls) largest_px = std::max(largest_px, ball.region.radius_px);
  return largest_px;
}

bool same_color(const ColorSamples& a, const ColorSamples& b, const GroupOptions& options) {
  const double low = std::min(a.saturation(), b.saturation()),
               high = std::max(a.saturation(), b.saturation());
  if (high > options.max_saturation_ratio * low) return false;
  return hue_distance_deg(a.hue_deg(), b.hue_deg()) <= options.close_hues_deg ||
         hue_overlap(a, b) >= options.min_hue_overlap;
}

std::vector<BallCandidate> ball_candidates(const ColorPicture& picture, std::size_t index,
                                           const RoundRegions& found, const SampleOptions& samples,
                                           const GroupOptions& options) {
  std::vector<BallCandidate> result;
  for (const RoundRegion& region : found.regions) {
    BallCandidate candidate{index, region, samples_inside(picture.bgr, region, found.scale, samples)};
    if (candidate.samples.pixels.size() < min_samples) continue;
    if (candidate.samples.colored_fraction() < options.min_colored_fraction) continue;
    if (candidate.samples.mean_lab().tail<2>().norm() < options.min_mean_chroma) continue;
    result.push_back(std::move(candidate));
  }
  return result;
}

std::vector<ColorGroup> color_groups(std::vector<BallCandidate> candidates, const CellCounts& all_pixels,
                                     const SampleOptions& samples, const GroupOptions& options) {
  options.validate();
  // Specks are often rounder than balls: what stands out and is large enough to be sure of comes first.
  const auto stands_out = [](const BallCandidate& ball) { return ball.region.stands_out; };
  const auto sureness = [&](const BallCandidate& ball) {
    return (stands_out(ball) ? 2 : 0) + (ball.region.radius_px >= options.sure_radius_px ? 1 : 0);
  };
  std::stable_sort(candidates.begin(), candidates.end(), [&](const BallCandidate& a, const BallCandidate& b) {
    return sureness(a) != sureness(b) ? sureness(a) > sureness(b) : a.region.fit_ratio > b.region.fit_ratio;
  });
  std::vector<ColorGroup> groups;
  for (BallCandidate& candidate : candidates) {
    const auto home = std::find_if(groups.begin(), groups.end(), [&](const ColorGroup& group) {
      return same_color(candidate.samples, group.samples, options);
    });
    if (home == groups.end()) {
      groups.emplace_back();
      groups.back().samples = candidate.samples;
      groups.back().balls.push_back(std::move(candidate));
    } else if (stands_out(candidate) == stands_out(home->balls.front()) &&
               candidate.region.fit_ratio >= options.min_relative_fit * home->best_fit() &&
               candidate.region.radius_px * options.max_radius_ratio >=
                   home->balls.front().region.radius_px) {
      home->samples.add(candidate.samples);
      home->balls.push_back(std::move(candidate));
    }
  }
  if (groups.size() > max_groups) groups.resize(max_groups);
  for (ColorGroup& group : groups) {
    group.chroma = chroma_group(chroma_histogram(group.samples));
    group.word = color_word(group.samples.mean_lab());
  }
  find_round_shares(groups, all_pixels, samples);
  groups.erase(std::remove_if(groups.begin(), groups.end(),
                              [&](const ColorGroup& group) { return !stands_out(group.balls.front()); }),
               groups.end());
  std::stable_sort(groups.begin(), groups.end(), [](const ColorGroup& a, const ColorGroup& b) {
    return a.samples.pixels.size() > b.samples.pixels.size();
  });
  return groups;
}

}  // namespace ballservo
