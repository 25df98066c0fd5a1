// The round regions of some pictures, grouped by colour: candidates for classes.
#pragma once

#include <string>
#include <vector>

#include "calibration/teaching/chroma_group.hpp"
#include "calibration/teaching/color_samples.hpp"
#include "calibration/teaching/round_regions.hpp"

namespace ballservo {

/// A picture to learn from: CV_8UC3, BGR, and what to call it.
struct ColorPicture {
  std::string source;
  cv::Mat bgr;
};

/// A round coloured region with its samples.
struct BallCandidate {
  std::size_t picture = 0;  ///< in the list of pictures
  RoundRegion region;
  ColorSamples samples;
};

/// Candidates of one colour.
struct ColorGroup {
  std::vector<BallCandidate> balls;  ///< the best fit first
  ColorSamples samples;              ///< of all of them
  ChromaGroup chroma;
  double round_share = 0;  ///< of all pixels of this colour in the pictures: the part inside these circles
  std::string word;        ///< its basic colour word
  double largest_radius_px() const;
  double best_fit() const { return balls.empty() ? 0 : balls.front().region.fit_ratio; }
  /// How much speaks for a ball: squared roundness of the best one x share, 0 to 1.
  double evidence() const { return best_fit() * best_fit() * round_share; }
};

/// What turns regions into groups.
struct GroupOptions {
  /// Balls are of one colour when their hues overlap at least that much (0 to 1), or their mean hues differ
  /// at most ...
  double min_hue_overlap = 0.45;
  double close_hues_deg = 5;        ///< ... by that: what the eye hardly tells apart; 0 to 180
  double max_saturation_ratio = 2;  ///< and whose saturations differ at most by this factor, 1 or more
  double min_colored_fraction =
      0.3;  ///< of a region's pixels, that must have a colour (a black disc has none), 0 to 1
  double min_mean_chroma = 7;     ///< of those, sqrt(a^2 + b^2) of their mean (a, b) (black with a tint)
  double min_relative_fit = 0.7;  ///< of the best ball's fit ratio, that others need to count, 0 to 1
  /// A ball of a colour counts if it is not smaller than the best one by more than that factor, 1 or more:
  /// specks of a ball's colour are round too.
  double max_radius_ratio = 5;
  double sure_radius_px = 8;  ///< balls from this size on are looked at first
  /// A colour of smaller round things than that counts if none is larger by more than this factor, 1 or more.
  double max_speck_ratio = 2;

  /// Throws InputError with every value out of range.
  void validate() const;
};

/// Whether two sets of samples show the same colour.
bool same_color(const ColorSamples& a, const ColorSamples& b, const GroupOptions& options);

/// The candidates of one picture; regions without colour are left out.
std::vector<BallCandidate> ball_candidates(const ColorPicture& picture, std::size_t index,
                                           const RoundRegions& found, const SampleOptions& samples,
                                           const GroupOptions& options);

/// Groups candidates, the one with the largest and roundest balls first. `all_pixels` counts every pixel of
/// the pictures that the candidates come from.
std::vector<ColorGroup> color_groups(std::vector<BallCandidate> candidates, const CellCounts& all_pixels,
                                     const SampleOptions& samples, const GroupOptions& options);

}  // namespace ballservo
