#include "calibration/teaching/color_groups.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/color/color_names.hpp"
#include "calibration/teaching/class_table.hpp"

namespace ballservo {
namespace {

// Balls are of one colour when their hues overlap so far, or their mean hues differ by what the eye hardly
// tells apart, and their saturations differ by no more than this factor.
constexpr double min_hue_overlap = 0.45, close_hues_deg = 5, max_saturation_ratio = 2;
// Of a region's pixels, so many must have a colour (a black disc has none), and their mean (a, b) such a
// length (black with a tint has less).
constexpr double min_colored_fraction = 0.1, min_mean_chroma = 7;
// A ball of a colour counts if it is not smaller than the best one by more: specks of its colour are round
// too.
constexpr double max_radius_ratio = 5;
constexpr std::size_t max_groups = 8;    // the most likely come first; what follows is clutter
constexpr std::size_t min_samples = 50;  // fewer say nothing about a distribution

/// Fills in every group's share, by the table that all of them together would give: a red ball is no evidence
/// against orange.
void find_round_shares(std::vector<ColorGroup>& groups, CellCounts elsewhere) {
  std::vector<ClassEvidence> evidence;
  for (const ColorGroup& group : groups) {
    evidence.push_back({group.samples.cells(), group.chroma});
    for (const ColorSamples::Pixel& pixel : group.samples.pixels) {
      std::uint32_t& count = elsewhere[pixel.table_cell];
      if (count > 0) --count;
    }
  }
  const std::vector<ClassIndex> table = class_table(evidence, occupied(elsewhere));
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

double ColorGroup::largest_radius_px() const {
  double largest_px = 0;
  for (const BallCandidate& ball : balls) largest_px = std::max(largest_px, ball.region.radius_px);
  return largest_px;
}

double ColorGroup::log_odds() const {
  constexpr double weight = 2, least_share = 0.01, speck_radius_px = 12;  // specks are round by chance
  const CircleEvidence& best = balls.front().region.evidence;
  return best.log_odds() + weight * std::max(1.0, speck_radius_px / best.radius_px) *
                               std::log(std::max(least_share, round_share));
}

bool same_color(const ColorSamples& a, const ColorSamples& b) {
  const double low = std::min(a.saturation(), b.saturation()),
               high = std::max(a.saturation(), b.saturation());
  if (high > max_saturation_ratio * low) return false;
  return hue_distance_deg(a.hue_deg(), b.hue_deg()) <= close_hues_deg || hue_overlap(a, b) >= min_hue_overlap;
}

std::vector<BallCandidate> ball_candidates(const ColorPicture& picture, std::size_t index,
                                           const RoundRegions& found) {
  std::vector<BallCandidate> result;
  for (const RoundRegion& region : found.regions) {
    BallCandidate candidate{index, region, samples_inside(picture.bgr, region, found.scale)};
    if (candidate.samples.pixels.size() < min_samples) continue;
    if (candidate.samples.colored_fraction() < min_colored_fraction) continue;
    if (candidate.samples.mean_lab().tail<2>().norm() < min_mean_chroma) continue;
    result.push_back(std::move(candidate));
  }
  return result;
}

std::vector<ColorGroup> color_groups(std::vector<BallCandidate> candidates, const CellCounts& all_pixels) {
  const auto odds = [](const BallCandidate& ball) { return ball.region.evidence.log_odds(); };
  std::stable_sort(candidates.begin(), candidates.end(),
                   [&](const BallCandidate& a, const BallCandidate& b) { return odds(a) > odds(b); });
  std::vector<ColorGroup> groups;
  for (BallCandidate& candidate : candidates) {
    const auto home = std::find_if(groups.begin(), groups.end(), [&](const ColorGroup& group) {
      return same_color(candidate.samples, group.samples);
    });
    if (home == groups.end()) {
      if (groups.size() == max_groups) continue;
      groups.emplace_back();
      groups.back().samples = candidate.samples;
      groups.back().balls.push_back(std::move(candidate));
      continue;
    }
    const auto better = std::find_if(home->balls.begin(), home->balls.end(), [&](const BallCandidate& ball) {
      return ball.picture == candidate.picture;
    });
    const double least = better == home->balls.end() ? odds(home->balls.front()) - candidate_lead
                                                     : odds(*better) - equal_balls;
    if (odds(candidate) >= std::max(0.0, least) &&
        candidate.region.radius_px * max_radius_ratio >= home->balls.front().region.radius_px) {
      home->samples.add(candidate.samples);
      home->balls.push_back(std::move(candidate));
    }
  }
  for (ColorGroup& group : groups) {
    group.chroma = chroma_group(chroma_histogram(group.samples));
    group.word = color_word(group.samples.mean_lab());
  }
  find_round_shares(groups, all_pixels);
  sort_by_size(groups);
  return groups;
}

void sort_by_size(std::vector<ColorGroup>& groups) {
  std::stable_sort(groups.begin(), groups.end(), [](const ColorGroup& a, const ColorGroup& b) {
    return a.samples.pixels.size() > b.samples.pixels.size();
  });
}

}  // namespace ballservo
