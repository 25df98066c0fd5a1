#include "servo/simulation/robot/camera_faults.hpp"

#include <utility>

#include "calibration/base/numbers.hpp"
#include "calibration/base/options.hpp"

namespace ballservo {

void declare(OptionVisitor& v, CameraFault& fault) {
  using Kind = CameraFault::Kind;
  const NumberRange time = NumberRange::within(0, 3600, "s");
  v.number("from_s", fault.from_s, time, "the fault begins");
  v.number("until_s", fault.until_s, time, "the fault ends");
  v.require(fault.until_s >= fault.from_s, "until_s", number_text(fault.until_s),
            "a time not before from_s (s)");
  v.one_of("type", fault.kind, {{"dropped", Kind::dropped}, {"exposure", Kind::exposure}},
           "frames that never arrive, or pictures too dark or too bright", required);
  v.only_if(fault.kind == Kind::exposure, "type: exposure", [&] {
    v.number("level", fault.level, NumberRange::within(0, 10, ""),
             "factor on the light that reaches the sensor", required);
  });
  v.only_if(fault.kind == Kind::dropped, "type: dropped", [&] {
    v.number("rate", fault.rate, NumberRange::within(0, 1, ""), "share of the frames that do not arrive");
    const double shortest = CameraFault::shortest_burst_frames(fault.rate);
    fault.burst_frames = std::max(fault.burst_frames, shortest);
    v.number("burst_frames", fault.burst_frames, NumberRange::within(1, 10000, "frames"),
             "so many in a row, on average", otherwise("the shortest"));
    v.require(fault.burst_frames >= shortest, "burst_frames", number_text(fault.burst_frames),
              "at least rate / (1 - rate): shorter bursts can't make up that rate");
  });
}

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
