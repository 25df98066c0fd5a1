// From light on the sensor to an 8-bit picture: blur of the optics, gain, noise, response curve,
// quantisation.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace ballservo {

class OptionVisitor;

/// In this order: blur, gain, noise, response, rounding to the nearest of 0 to 255 (what is brighter stays
/// 255).
struct SensorOptions {
  double blur_px = 0;     ///< sigma of the optics' Gaussian blur
  double gain = 1;        ///< exposure and amplification: light of 1 / gain is full scale
  double read_noise = 0;  ///< sigma of the noise in the dark, in grey levels of linear light
  double shot_noise = 0;  ///< grey levels; the noise's variance is read_noise^2 + shot_noise * level
  double gamma = 1;       ///< response: grey = 255 * light^(1 / gamma); 1 is linear
};
void declare(OptionVisitor& v, SensorOptions& sensor);

/// `light`: CV_32FC3. Noise is independent for every pixel and channel and depends on (seed, frame_index)
/// alone, not on the number of threads.
cv::Mat expose(const cv::Mat& light, const SensorOptions& options, std::uint64_t seed,
               std::uint64_t frame_index);

}  // namespace ballservo
