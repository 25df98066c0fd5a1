// The pixels of balls, as colour calibration counts them (paper, "Calibrage", 2c).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "calibration/color/color_table.hpp"
#include "calibration/teaching/round_regions.hpp"

namespace ballservo {

/// Whether a colour of Lab is one to learn. Black, dark and nearly grey pixels (deep shade, glare, white) say
/// nothing of a ball's hue: they are never samples and never classified. The holes that they leave in the
/// class picture are filled by the on-line closing and the absorption of enclosed regions.
bool has_color(const Eigen::Vector3d& lab);

/// The (L, a, b) at the centre of every cell of ColorTable, in its order.
const std::vector<Eigen::Vector3f>& table_cell_colors();

/// The cell of ChromaHistogram that holds (a, b).
int chroma_cell(double a, double b);

/// How many of a picture's pixels fall into each cell of ColorTable.
using CellCounts = std::vector<std::uint32_t>;
void count_cells(const cv::Mat& bgr, const cv::Mat& mask, CellCounts& counts);

/// Covers a ball, with its blurred rim, in a mask of what lies off the balls.
void cover(cv::Mat1b& off_balls, const RoundRegion& ball);

/// The occupied ones of such counts, and back.
OccupiedCells occupied(const CellCounts& counts);
CellCounts all_counts(const OccupiedCells& cells);

/// The coloured pixels of one ball, or of several of one colour.
struct ColorSamples {
  /// Bins of 5 degrees of hue.
  static constexpr int hue_bins = 72;

  struct Pixel {
    std::uint32_t table_cell;
    std::uint16_t chroma_cell;
  };
  std::vector<Pixel> pixels;
  std::array<double, hue_bins> hue_counts{};
  Eigen::Vector3d lab_sum{0, 0, 0};
  std::uint64_t looked_at = 0;  ///< pixels inside the circle, coloured or not, in the region or not

  Eigen::Vector3d mean_lab() const;
  double hue_deg() const;
  /// sqrt(a^2 + b^2) / (L + 16) of the mean: what a change of the light's strength leaves as it is, because
  /// a, b and L + 16 all grow with its cube root.
  double saturation() const;
  double colored_fraction() const;
  OccupiedCells cells() const;  ///< the pixels by cells of ColorTable
  void add(const ColorSamples& other);
};

/// The coloured pixels inside a round region (of the region itself, holes included, and a bit inside the
/// circle). `scale` is the region's picture's working scale.
ColorSamples samples_inside(const cv::Mat& bgr, const RoundRegion& region, double scale);

/// 0 to 1: how much of their hues two sets of samples share, the histograms smoothed a little.
double hue_overlap(const ColorSamples& a, const ColorSamples& b);

}  // namespace ballservo
