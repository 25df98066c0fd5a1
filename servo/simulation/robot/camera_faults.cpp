#include "servo/simulation/robot/camera_faults.hpp"

#include <utility>

namespace ballservo {

namespace {

bool is_on(const CameraFault& fault, double time_s) {
  return time_s >= fault.from_s && time_s < fault.until_s;
}

}  // namespace

CameraFaults::CameraFaults(std::vector<CameraFault> faults, std::uint64_t seed) : faults_(std::move(faults)) {
  for (std::size_t k = 0; k < faults_.size(); ++k)
    chains_.push_back({random_stream(seed, "camera_fault", k)});
}

bool CameraFaults::drops(double time_s) {
  bool lost = false;
  for (std::size_t k = 0; k < faults_.size(); ++k) {
    const CameraFault& fault = faults_[k];
    if (fault.kind != CameraFault::Kind::dropped || !is_on(fault, time_s)) continue;
    if (fault.rate >= 1.0) {
      lost = true;
      continue;
    }
    // The shares of the two states are rate and 1 - rate, from the first frame on.
    Chain& chain = chains_[k];
    const double end = 1.0 / fault.burst_frames, begin = end * fault.rate / (1.0 - fault.rate);
    const double draw = uniform01(chain.engine);
    if (!chain.begun) {
      chain.begun = true;
      chain.lost = draw < fault.rate;
    } else {
      chain.lost = chain.lost ? draw >= end : draw < begin;
    }
    lost = lost || chain.lost;
  }
  return lost;
}

double CameraFaults::level(double time_s) const {
  double level = 1.0;
  for (const CameraFault& fault : faults_) {
    if (fault.kind == CameraFault::Kind::exposure && is_on(fault, time_s)) level *= fault.level;
  }
  return level;
}

}  // namespace ballservo
