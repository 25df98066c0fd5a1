// The round regions of some pictures, grouped by colour: candidates for classes.
#pragma once

#include <memory>
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
  std::shared_ptr<const RoundRegions> searched{};  ///< in it, cleared, before; null: it is searched
};

/// A round coloured region with its samples.
struct BallCandidate {
  std::size_t picture = 0;  ///< in the list of pictures
  RoundRegion region;
  ColorSamples samples;
};

/// Candidates of one colour.
struct ColorGroup {
  std::vector<BallCandidate> balls;  ///< the most likely first
  ColorSamples samples;              ///< of all of them
  ChromaGroup chroma;
  double round_share = 0;  ///< of all pixels of this colour in the pictures: the part inside these circles
  std::string word;        ///< its basic colour word
  double largest_radius_px() const;
  /// Logarithm of the odds that its best candidate is a ball. A thing whose colour lies around it in the
  /// picture is rather a part of something else.
  double log_odds() const;
};

/// What is less likely than the best by more than that is no ball beside it.
inline constexpr double candidate_lead = 5;

/// Several balls in a picture are about as likely, to within this.
inline constexpr double equal_balls = 2;

/// Whether two sets of samples show the same colour.
bool same_color(const ColorSamples& a, const ColorSamples& b);

/// The candidates of one picture; regions without colour are left out.
std::vector<BallCandidate> ball_candidates(const ColorPicture& picture, std::size_t index,
                                           const RoundRegions& found);

/// Groups candidates, the one with the largest and roundest balls first. `all_pixels` counts every pixel of
/// the pictures that the candidates come from.
std::vector<ColorGroup> color_groups(std::vector<BallCandidate> candidates, const CellCounts& all_pixels);

/// The one with most pixels first.
void sort_by_size(std::vector<ColorGroup>& groups);

}  // namespace ballservo
