#include "servo/simulation/rendering/sensor.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "calibration/base/numbers.hpp"
#include "calibration/base/options.hpp"
#include "calibration/base/random.hpp"
#include "servo/simulation/world/lanes.hpp"

namespace ballservo {

namespace {

/// So many equally likely values of a standard normal.
constexpr std::size_t normal_values = 1 << 16;
constexpr std::size_t draw = 16;  // neighbours in a shuffled table are as good as drawn one by one

/// The word of that number in a stream of random words (SplitMix64).
std::uint64_t random_word(std::uint64_t stream, std::uint64_t number) {
  return mixed_bits(stream + (number + 1) * split_mix_step);
}

/// The values, shuffled, and the first ones again, so that a draw may start anywhere.
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
  for (std::size_t k = normal_values - 1; k > 0; --k)
    std::swap(values[k], values[random_word(0, k) % (k + 1)]);
  values.insert(values.end(), values.begin(), values.begin() + draw);
  return values;
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

/// sum += weight (a + b).
BALLSERVO_WIDE void add_weighted(float weight, const float* a, const float* b, float* __restrict sum,
                                 std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) sum[i] += weight * (a[i] + b[i]);
}

BALLSERVO_WIDE void add_noise(float read2, float shot, const float* normal, float* __restrict levels,
                              std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    levels[i] += std::sqrt(read2 + shot * std::max(0.0f, levels[i])) * normal[i];
}

BALLSERVO_WIDE void cut_off(float* levels, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) levels[i] = std::min(std::max(0.0f, levels[i]), 255.0f);
}

BALLSERVO_WIDE void round_levels(const float* levels, std::uint8_t* __restrict out, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<std::uint8_t>(levels[i] + 0.5f);
}

/// One row of the blurred picture, times `scale`; `columns` is room for a row with `reach` pixels more on
/// either side, blurred along y.
void blur_row(const cv::Mat& light, int row, const std::vector<float>& kernel, float scale,
              std::vector<float>& columns, std::vector<float>& blurred) {
  const std::size_t reach = kernel.size() - 1, width = blurred.size();
  float* const middle = columns.data() + 3 * reach;
  const auto source = [&](std::size_t k, int side) {
    return light.ptr<float>(std::clamp(row + side * static_cast<int>(k), 0, light.rows - 1));
  };
  std::fill(columns.begin(), columns.end(), 0.0f);
  for (std::size_t k = 0; k <= reach; ++k)
    add_weighted(k == 0 ? kernel[0] / 2 : kernel[k], source(k, -1), source(k, 1), middle, width);
  for (std::size_t k = 0; k < 3 * reach; ++k) {
    columns[k] = middle[k % 3];
    middle[width + k] = middle[width - 3 + k % 3];
  }
  std::fill(blurred.begin(), blurred.end(), 0.0f);
  for (std::size_t k = 0; k <= reach; ++k) {
    add_weighted(scale * (k == 0 ? kernel[0] / 2 : kernel[k]), middle - 3 * k, middle + 3 * k, blurred.data(),
                 width);
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
    std::vector<float> columns(width + 6 * reach), levels(width), noise(width + 4 * draw);
    for (int row = rows.begin(); row < rows.end(); ++row) {
      blur_row(light, row, kernel, scale, columns, levels);
      if (noisy) {
        for (std::size_t i = 0; i < width; i += 4 * draw) {
          const std::uint64_t bits = random_word(frame_seed, static_cast<std::uint64_t>(row) * width + i);
          for (std::size_t k = 0; k < 4; ++k)
            std::copy_n(&normal[(bits >> (16 * k)) % normal_values], draw, &noise[i + k * draw]);
        }
        add_noise(read2, shot, noise.data(), levels.data(), width);
      }
      cut_off(levels.data(), width);
      std::uint8_t* out = picture.ptr<std::uint8_t>(row);
      if (response.empty()) {
        round_levels(levels.data(), out, width);
      } else {
        for (std::size_t i = 0; i < width; ++i)
          out[i] = response[static_cast<std::size_t>(levels[i] * 16.0f + 0.5f)];
      }
    }
  });
  return picture;
}

}  // namespace ballservo
