#include "servo/simulation/world/light_course.hpp"

#include <algorithm>

namespace ballservo {

Rgb planckian_rgb(double temperature_k) {
  const double t = temperature_k, t2 = t * t, t3 = t2 * t;
  const double x = t <= 4000 ? -0.2661239e9 / t3 - 0.2343589e6 / t2 + 0.8776956e3 / t + 0.179910
                             : -3.0258469e9 / t3 + 2.1070379e6 / t2 + 0.2226347e3 / t + 0.240390;
  const double x2 = x * x, x3 = x2 * x;
  const double y = t <= 2222   ? -1.1063814 * x3 - 1.34811020 * x2 + 2.18555832 * x - 0.20219683
                   : t <= 4000 ? -0.9549476 * x3 - 1.37418593 * x2 + 2.09137015 * x - 0.16748867
                               : 3.0817580 * x3 - 5.87338670 * x2 + 3.75112997 * x - 0.37001483;
  const Eigen::Vector3d xyz(x / y, 1.0, (1.0 - x - y) / y);
  Eigen::Matrix3d rgb_from_xyz;
  rgb_from_xyz << 3.2404542, -1.5371385, -0.4985314,  //
      -0.9692660, 1.8760108, 0.0415560,               //
      0.0556434, -0.2040259, 1.0572252;
  return (rgb_from_xyz * xyz).cwiseMax(0.0);
}

Rgb LightCourse::gain(double time_s) const {
  if (keys.empty()) return Rgb::Ones();
  const auto after = std::upper_bound(keys.begin(), keys.end(), time_s,
                                      [](double time, const LightKey& key) { return time < key.time_s; });
  LightKey now = after == keys.begin() ? keys.front() : *(after - 1);
  if (after != keys.begin() && after != keys.end()) {
    const double share = (time_s - now.time_s) / (after->time_s - now.time_s);
    now.temperature_k += share * (after->temperature_k - now.temperature_k);
    now.level += share * (after->level - now.level);
  }
  return now.level * planckian_rgb(now.temperature_k).cwiseQuotient(planckian_rgb(white_balance_k));
}

}  // namespace ballservo
