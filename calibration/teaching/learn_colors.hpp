// Colour calibration from pictures of balls, whole (paper, "Calibrage", 2).
#pragma once

#include <Eigen/Core>
#include <map>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration/color/color_table.hpp"
#include "calibration/teaching/color_groups.hpp"

namespace ballservo {

/// Less of a colour's pixels in round regions is worth a doubt.
inline constexpr double min_round_share = 0.5;

/// A ball that the user points at.
struct PointedBall {
  Eigen::Vector2d center_px{0, 0};
  double radius_px = 0;
};

/// One class to learn, from which of the pictures.
struct ClassRequest {
  std::string name;
  std::vector<std::size_t> pictures;  ///< indices; at least one
  std::optional<PointedBall> at;      ///< in the first of them
};

/// A ball that was learnt from.
struct LearntCircle {
  std::size_t picture = 0;
  int frame = 0;  ///< of a video; 0 for a still
  Eigen::Vector2d center_px{0, 0};
  double radius_px = 0;
  double fit_ratio = 1;  ///< 1 for one that the user pointed at
};

/// Those of every class, by its name.
using LearntCircles = std::map<std::string, std::vector<LearntCircle>>;

/// A picture as the search saw it.
struct SearchedPicture {
  cv::Mat bgr;
  double scale = 1;  ///< its pixels per pixel of the picture
};

struct LearntColors {
  ColorTable table;
  LearntCircles circles;
  std::vector<std::string> doubts;        ///< what speaks against a class's being a ball's, in words
  std::vector<SearchedPicture> pictures;  ///< in the order of the pictures
};

/// Adds a class with the group's samples and circles, which are of a picture or, with `of_video`, of a frame.
void add_class(LearntColors& colors, const std::string& name, const ColorGroup& group, bool of_video = false);

/// Every colour whose regions are round becomes a class, named by its colour word; where several share a word
/// the largest keeps it plain, the others are red_2, red_3 and so on. `background`: pictures without any
/// ball. Throws Refusal when nothing round and coloured is seen; InputError for bad pictures.
LearntColors learn_colors(const std::vector<ColorPicture>& pictures, const RegionSearchOptions& search = {},
                          const std::vector<ColorPicture>& background = {});

/// One class per request. Which of several colours is meant, the ball pointed at settles, or a name with a
/// colour word in it (the colour nearest in hue). Throws Refusal when a class's pictures show nothing round and
/// coloured, or several colours and nothing says which; InputError for names that are no class names or come
/// twice, a pointed ball that is not finite, not larger than nothing or outside its picture (all faults at
/// once).
LearntColors learn_classes(const std::vector<ColorPicture>& pictures,
                           const std::vector<ClassRequest>& requests, const RegionSearchOptions& search = {},
                           const std::vector<ColorPicture>& background = {});

}  // namespace ballservo
