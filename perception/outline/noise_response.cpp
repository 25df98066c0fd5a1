#include "perception/outline/noise_response.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "perception/outline/camera_response.hpp"
#include "perception/outline/picture_noise.hpp"

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
          seen[static_cast<std::size_t>(sum / 9 / band_levels)].add(laplacian);
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
