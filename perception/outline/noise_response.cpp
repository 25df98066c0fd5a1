#include "perception/outline/noise_response.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "perception/outline/camera_response.hpp"

namespace ballservo {
namespace {

constexpr int bands = 16, band_levels = 256 / bands;
constexpr double looked_at_px = 10000;  // of a picture, evenly
constexpr int least_seen = 150, least_bands = 4;
// Values that were cut off have less noise.
constexpr int darkest = 2, brightest = 251;
// Below, rounding hides the noise (variances, grey levels^2).
constexpr double rounding = 1.0 / 12, least_variance = 0.15;
// How well a band's variance is known (of its logarithm, sigma).
constexpr double band_sigma = 0.2;
// Where the better model errs by so much more than that (mean square), it is no noise that is seen.
constexpr double most_misfit = 2;
constexpr double most_log_odds = 25;  // more than what edges may say against it

// How often the Laplacian of Immerkaer (Computer Vision and Image Understanding 64(2), 1996) has each size:
// slopes do not show in it, and noise has 36 times its variance.
class LaplacianHistogram {
 public:
  void add(int size) { ++counts_[static_cast<std::size_t>(std::min(size, largest))], ++seen_; }
  int seen() const { return seen_; }

  /// By the smallest quarter: most of a texture lies above.
  double noise_variance() const {
    constexpr double quarter_of_normal = 0.31864;  // |x| of a standard normal is below in one of four
    const double wanted = 0.25 * seen_;
    std::size_t size = 0;
    int below = 0;
    while (below + counts_[size] < wanted) below += counts_[size++];
    // Whole numbers stand for half a step to either side, 0 for half a step.
    const double share = (wanted - below) / counts_[size];
    const double quantile = size == 0 ? 0.5 * share : static_cast<double>(size) - 0.5 + share;
    return std::pow(quantile / quarter_of_normal, 2) / 36;
  }

 private:
  static constexpr int largest = 255;
  std::array<int, largest + 1> counts_{};
  int seen_ = 0;
};

using Bands = Eigen::Array<double, Eigen::Dynamic, 1, 0, bands, 1>;
using Terms = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, bands, 3>;

// The non-negative sum of terms that comes nearest to the variances; what is left, in sigmas squared.
double misfit(const Bands& variances, const Terms& terms) {
  double least = std::numeric_limits<double>::infinity();
  for (int chosen = 1; chosen < 8; ++chosen) {
    Bands model = variances;
    bool is_sum = true;
    for (int pass = 0; pass < 3 && is_sum; ++pass) {
      Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
      Eigen::Vector3d right = Eigen::Vector3d::Zero();
      for (int i = 0; i < variances.size(); ++i) {
        Eigen::Vector3d row = terms.row(i).transpose() / model[i];
        for (int k = 0; k < 3; ++k)
          if ((chosen >> k & 1) == 0) row[k] = 0;
        normal += row * row.transpose();
        right += row * (variances[i] - rounding) / model[i];
      }
      for (int k = 0; k < 3; ++k)
        if (!(normal(k, k) > 0)) normal(k, k) = 1;
      const Eigen::Vector3d factors = normal.ldlt().solve(right);
      is_sum = factors.allFinite() && factors.minCoeff() >= 0;
      model = (terms * factors).array() + rounding;
    }
    if (is_sum) least = std::min(least, ((variances / model).log() / band_sigma).square().sum());
  }
  return least;
}

}  // namespace

double srgb_log_odds_by_noise(const cv::Mat& bgr) {
  CV_Assert(bgr.type() == CV_8UC3);
  std::array<LaplacianHistogram, bands> seen{};
  const int step = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(bgr.total()) / looked_at_px)));
  for (int v = 1; v < bgr.rows - 1; v += step) {
    const std::array<const cv::Vec3b*, 3> rows{bgr.ptr<cv::Vec3b>(v - 1), bgr.ptr<cv::Vec3b>(v),
                                               bgr.ptr<cv::Vec3b>(v + 1)};
    for (int u = 1; u < bgr.cols - 1; u += step) {
      for (int c = 0; c < 3; ++c) {
        int laplacian = 0, sum = 0, low = 255, high = 0;
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) {
            const int level = rows[static_cast<std::size_t>(i)][u + j - 1][c];
            laplacian += (i == 1 ? -2 : 1) * (j == 1 ? -2 : 1) * level;
            sum += level;
            low = std::min(low, level);
            high = std::max(high, level);
          }
        }
        if (low >= darkest && high <= brightest)
          seen[static_cast<std::size_t>(sum / 9 / band_levels)].add(std::abs(laplacian));
      }
    }
  }
  Bands variances(bands);
  Terms proportional(bands, 3), srgb(bands, 3);
  int told = 0;
  for (int i = 0; i < bands; ++i) {
    const LaplacianHistogram& band = seen[static_cast<std::size_t>(i)];
    const double variance = band.seen() < least_seen ? 0 : band.noise_variance();
    if (variance < least_variance) continue;
    const auto level = static_cast<std::size_t>(i * band_levels + band_levels / 2);
    const auto light = static_cast<double>(CameraResponse::srgb().light[level]) / 255;
    const double per_light = 1 / std::pow(static_cast<double>(CameraResponse::srgb().slope[level]), 2);
    variances[told] = variance;
    proportional.row(told) << 1, static_cast<double>(level) / 255, 0;
    srgb.row(told++) << per_light, light * per_light, 1;  // and what was filtered is the same everywhere
  }
  if (told < least_bands) return 0;
  const Bands known = variances.head(told);
  const double by_proportional = misfit(known, proportional.topRows(told)),
               by_srgb = misfit(known, srgb.topRows(told));
  if (std::min(by_proportional, by_srgb) > most_misfit * told) return 0;
  return std::clamp(0.5 * (by_proportional - by_srgb), -most_log_odds, most_log_odds);
}

}  // namespace ballservo
