#include "servo/simulation/rendering/sensor.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "calibration/base/numbers.hpp"
#include "calibration/base/options.hpp"
#include "calibration/base/random.hpp"

namespace ballservo {

namespace {

/// So many equally likely values of a standard normal: four draws from each random word.
constexpr std::size_t normal_values = 1 << 16;
std::vector<float> normal_table() {
  std::vector<float> values(normal_values);
  // The quantile at (k + 0.5) / size by Newton's method on the distribution function, from the middle
  // outwards.
  double z = 0, square_sum = 0;
  for (std::size_t k = normal_values / 2; k < normal_values; ++k) {
    const double p = (static_cast<double>(k) + 0.5) / normal_values;
    for (int step = 0; step < 4; ++step) {
      const double density = 0.3989422804014327 * std::exp(-z * z / 2);
      z -= (0.5 * std::erfc(-z * 0.7071067811865476) - p) / density;
    }
    values[k] = static_cast<float>(z);
    square_sum += 2 * z * z;
  }
  const double scale = 1.0 / std::sqrt(square_sum / normal_values);
  for (std::size_t k = normal_values / 2; k < normal_values; ++k) {
    values[k] = static_cast<float>(values[k] * scale);
    values[normal_values - 1 - k] = -values[k];
  }
  return values;
}

/// The word of that number in a stream of random words (SplitMix64: Steele, Lea and Flood, OOPSLA 2014).
std::uint64_t random_word(std::uint64_t stream, std::uint64_t number) {
  std::uint64_t x = stream + (number + 1) * 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

/// The weights from the middle to one side; the other side's are the same.
std::vector<float> gaussian_kernel(double sigma_px) {
  const int reach = sigma_px > 0 ? static_cast<int>(std::ceil(4 * sigma_px)) : 0;
  std::vector<double> weights{1.0};
  double sum = 1.0;
  for (int k = 1; k <= reach; ++k) {
    weights.push_back(std::exp(-0.5 * k * k / (sigma_px * sigma_px)));
    sum += 2.0 * weights.back();
  }
  std::vector<float> kernel;
  for (const double weight : weights) kernel.push_back(static_cast<float>(weight / sum));
  return kernel;
}

using Row = Eigen::Map<Eigen::ArrayXf>;
using ConstRow = Eigen::Map<const Eigen::ArrayXf>;

/// One row of the blurred picture; `columns` holds the row blurred along y with `reach` pixels more on either
/// side.
void blur_row(const cv::Mat& light, int row, const std::vector<float>& kernel, std::vector<float>& columns,
              std::vector<float>& blurred) {
  const int reach = static_cast<int>(kernel.size()) - 1, width = light.cols * 3;
  if (reach == 0) {
    std::copy_n(light.ptr<float>(row), width, blurred.begin());
    return;
  }
  float* middle = columns.data() + 3 * reach;
  const auto source = [&](int k) {
    return ConstRow(light.ptr<float>(std::clamp(row + k, 0, light.rows - 1)), width);
  };
  Row sum(middle, width), blurred_row(blurred.data(), width);
  sum = kernel[0] * source(0);
  for (int k = 1; k <= reach; ++k) sum += kernel[static_cast<std::size_t>(k)] * (source(-k) + source(k));
  for (int k = 1; k <= reach; ++k) {
    for (int c = 0; c < 3; ++c) {
      middle[-3 * k + c] = middle[c];
      middle[width - 3 + 3 * k + c] = middle[width - 3 + c];
    }
  }
  blurred_row = kernel[0] * sum;
  for (int k = 1; k <= reach; ++k) {
    blurred_row += kernel[static_cast<std::size_t>(k)] *
                   (ConstRow(middle - 3 * k, width) + ConstRow(middle + 3 * k, width));
  }
}

}  // namespace

void declare(OptionVisitor& v, SensorOptions& sensor) {
  const NumberRange levels = NumberRange::within(0, 255, "grey levels");
  v.number("blur_px", sensor.blur_px, NumberRange::within(0, 20, "px"), "blur, sigma");
  v.number("gain", sensor.gain, NumberRange::above(0, 100, ""), "exposure and amplification");
  v.number("gamma", sensor.gamma, NumberRange::within(1, 3, ""), "response: grey = 255 light^(1 / gamma)");
  v.map("noise", [&] {
    v.number("read", sensor.read_noise, levels, "noise, sigma in the dark");
    v.number("shot", sensor.shot_noise, levels, "shot noise: the variance is read^2 + shot * level");
  });
}

cv::Mat expose(const cv::Mat& light, const SensorOptions& options, std::uint64_t seed,
               std::uint64_t frame_index) {
  const std::vector<float> kernel = gaussian_kernel(options.blur_px);
  const std::size_t reach = kernel.size() - 1, width = static_cast<std::size_t>(light.cols) * 3;
  const std::uint64_t frame_seed = random_stream(seed, "camera_noise", frame_index)();
  const bool noisy = options.read_noise > 0 || options.shot_noise > 0;
  const auto scale = static_cast<float>(255.0 * options.gain);
  const auto read2 = static_cast<float>(options.read_noise * options.read_noise);
  const auto shot = static_cast<float>(options.shot_noise);
  std::vector<std::uint8_t> response;  // in steps of 1/16 grey level of linear light
  if (options.gamma != 1.0) {
    for (int k = 0; k <= 255 * 16; ++k) {
      response.push_back(static_cast<std::uint8_t>(
          std::floor(255.0 * std::pow(k / (255.0 * 16.0), 1.0 / options.gamma) + 0.5)));
    }
  }
  static const std::vector<float> normal = normal_table();

  cv::Mat picture(light.rows, light.cols, CV_8UC3);
  tbb::parallel_for(tbb::blocked_range<int>(0, light.rows, 8), [&](const tbb::blocked_range<int>& rows) {
    std::vector<float> columns(width + 6 * reach), values(width), noise(width + 3);
    Eigen::Map<Eigen::ArrayXf> levels(values.data(), static_cast<Eigen::Index>(width));
    Eigen::ArrayXf sigmas;
    for (int row = rows.begin(); row < rows.end(); ++row) {
      blur_row(light, row, kernel, columns, values);
      levels *= scale;
      if (noisy) {
        sigmas = (read2 + shot * levels.max(0.0f)).sqrt();
        for (std::size_t i = 0; i < width; i += 4) {
          const std::uint64_t bits = random_word(frame_seed, static_cast<std::uint64_t>(row) * width + i);
          for (std::size_t k = 0; k < 4; ++k) noise[i + k] = normal[(bits >> (16 * k)) % normal_values];
        }
        levels += sigmas * Eigen::Map<const Eigen::ArrayXf>(noise.data(), levels.size());
      }
      levels = levels.max(0.0f).min(255.0f);
      std::uint8_t* out = picture.ptr<std::uint8_t>(row);
      if (response.empty()) {
        Eigen::Map<Eigen::Array<std::uint8_t, Eigen::Dynamic, 1>>(out, levels.size()) =
            (levels + 0.5f).cast<std::uint8_t>();
      } else {
        for (std::size_t i = 0; i < width; ++i)
          out[i] = response[static_cast<std::size_t>(values[i] * 16.0f + 0.5f)];
      }
    }
  });
  return picture;
}

}  // namespace ballservo
