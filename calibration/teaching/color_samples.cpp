#include "calibration/teaching/color_samples.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calibration/color/color_names.hpp"
#include "calibration/color/color_space.hpp"
#include "calibration/teaching/chroma_picture.hpp"

namespace ballservo {
namespace {

constexpr double min_lightness = 10;    // L
constexpr double min_chroma = 8;        // sqrt(a^2 + b^2); in the dark less will do:
constexpr double min_saturation = 0.1;  // sqrt(a^2 + b^2) / (L + 16), which a weaker light leaves as it is
constexpr double sampled_rim = 0.92;    // of the circle's radius: further out the background mixes in
constexpr double hue_bin_deg = 360.0 / ColorSamples::hue_bins;
constexpr double hue_smoothing_deg = 2.5;

std::array<double, ColorSamples::hue_bins> smoothed(const ColorSamples& samples) {
  constexpr int bins = ColorSamples::hue_bins, reach = 2;
  std::array<double, bins> result{};
  double total = 0;
  for (int i = 0; i < bins; ++i) {
    for (int d = -reach; d <= reach; ++d) {
      const double t = d * hue_bin_deg / hue_smoothing_deg;
      const double part = samples.hue_counts[i] * std::exp(-0.5 * t * t);
      result[(i + d + bins) % bins] += part;
      total += part;
    }
  }
  for (double& value : result) value = total > 0 ? value / total : 0;
  return result;
}

}  // namespace

bool has_color(const Eigen::Vector3d& lab) {
  const double least = std::min(min_chroma, min_saturation * (lab.x() + 16));
  return lab.x() >= min_lightness && lab.tail<2>().squaredNorm() >= least * least;
}

const std::vector<Eigen::Vector3f>& table_cell_colors() {
  static const std::vector<Eigen::Vector3f> colors = [] {
    cv::Mat3b centers(ColorTable::side * ColorTable::side, ColorTable::side);
    const auto center = [](int i) { return static_cast<std::uint8_t>(4 * i + 2); };
    for (int rg = 0; rg < centers.rows; ++rg) {
      for (int b = 0; b < ColorTable::side; ++b)
        centers(rg, b) = {center(b), center(rg % ColorTable::side), center(rg / ColorTable::side)};
    }
    std::vector<Eigen::Vector3f> result;
    for (const cv::Vec3f& lab : lab_image(centers)) result.emplace_back(lab[0], lab[1], lab[2]);
    return result;
  }();
  return colors;
}

int chroma_cell(double a, double b) {
  constexpr int side = ChromaHistogram::side;
  const auto cell = [](double v) {
    return std::clamp(static_cast<int>(std::floor(v / ChromaHistogram::cell)) + side / 2, 0, side - 1);
  };
  return cell(b) * side + cell(a);
}

void count_cells(const cv::Mat& bgr, const cv::Mat& mask, CellCounts& counts) {
  counts.resize(ColorTable::entries, 0);
  for (int y = 0; y < bgr.rows; ++y) {
    const cv::Vec3b* row = bgr.ptr<cv::Vec3b>(y);
    const std::uint8_t* wanted = mask.empty() ? nullptr : mask.ptr<std::uint8_t>(y);
    for (int x = 0; x < bgr.cols; ++x) {
      if (!wanted || wanted[x]) ++counts[ColorTable::index(row[x][0], row[x][1], row[x][2])];
    }
  }
}

void cover(cv::Mat1b& off_balls, const RoundRegion& ball) {
  cv::circle(off_balls, {cvRound(ball.center_px.x()), cvRound(ball.center_px.y())},
             cvRound(1.15 * ball.radius_px + 2), cv::Scalar(0), cv::FILLED);
}

OccupiedCells occupied(const CellCounts& counts) {
  OccupiedCells result;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] > 0) result.push_back({static_cast<std::uint32_t>(i), counts[i]});
  }
  return result;
}

CellCounts all_counts(const OccupiedCells& cells) {
  CellCounts result(ColorTable::entries, 0);
  for (const CellCount& cell : cells) result[cell.cell] = cell.count;
  return result;
}

Eigen::Vector3d ColorSamples::mean_lab() const {
  return pixels.empty() ? Eigen::Vector3d::Zero().eval()
                        : (lab_sum / static_cast<double>(pixels.size())).eval();
}

double ColorSamples::hue_deg() const { return lab_hue_deg(lab_sum.y(), lab_sum.z()); }

double ColorSamples::saturation() const {
  const Eigen::Vector3d lab = mean_lab();
  return lab.tail<2>().norm() / (lab.x() + 16);
}

double ColorSamples::colored_fraction() const {
  return looked_at > 0 ? static_cast<double>(pixels.size()) / static_cast<double>(looked_at) : 0;
}

OccupiedCells ColorSamples::cells() const {
  CellCounts counts(ColorTable::entries, 0);
  for (const Pixel& pixel : pixels) ++counts[pixel.table_cell];
  return occupied(counts);
}

void ColorSamples::add(const ColorSamples& other) {
  pixels.insert(pixels.end(), other.pixels.begin(), other.pixels.end());
  for (int i = 0; i < hue_bins; ++i) hue_counts[i] += other.hue_counts[i];
  lab_sum += other.lab_sum;
  looked_at += other.looked_at;
}

ColorSamples samples_inside(const cv::Mat& bgr, const RoundRegion& region, double scale) {
  ColorSamples result;
  const double radius = sampled_rim * region.radius_px;
  const Eigen::Vector2d at = region.center_px;
  const int top = std::max(0, static_cast<int>(std::ceil(at.y() - radius)));
  const int bottom = std::min(bgr.rows - 1, static_cast<int>(std::floor(at.y() + radius)));
  const int left = std::max(0, static_cast<int>(std::ceil(at.x() - radius)));
  const int right = std::min(bgr.cols - 1, static_cast<int>(std::floor(at.x() + radius)));
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      if ((Eigen::Vector2d(x, y) - at).squaredNorm() > radius * radius) continue;
      ++result.looked_at;
      if (!region.mask.empty()) {
        const int mx = static_cast<int>((x + 0.5) * scale) - region.mask_origin.x;
        const int my = static_cast<int>((y + 0.5) * scale) - region.mask_origin.y;
        if (mx < 0 || my < 0 || mx >= region.mask.cols || my >= region.mask.rows) continue;
        if (!region.mask.at<std::uint8_t>(my, mx)) continue;
      }
      const cv::Vec3b& c = bgr.at<cv::Vec3b>(y, x);
      const Eigen::Vector3d lab = lab_from_bgr(c[0], c[1], c[2]);
      if (!has_color(lab)) continue;
      result.pixels.push_back({static_cast<std::uint32_t>(ColorTable::index(c[0], c[1], c[2])),
                               static_cast<std::uint16_t>(chroma_cell(lab.y(), lab.z()))});
      const int bin = static_cast<int>(lab_hue_deg(lab.y(), lab.z()) / hue_bin_deg) % ColorSamples::hue_bins;
      result.hue_counts[bin] += 1;
      result.lab_sum += lab;
    }
  }
  return result;
}

double hue_overlap(const ColorSamples& a, const ColorSamples& b) {
  const auto smooth_a = smoothed(a), smooth_b = smoothed(b);
  double common = 0;
  for (int i = 0; i < ColorSamples::hue_bins; ++i) common += std::min(smooth_a[i], smooth_b[i]);
  return common;
}

}  // namespace ballservo
