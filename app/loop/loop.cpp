#include "app/loop/loop.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>

#include "calibration/base/fault.hpp"

namespace ballservo {

namespace {
constexpr std::size_t frames_on_the_way = 64;  // more than any latency holds; the oldest go

/// What a camera sees that is turned so far to the left.
void turn(Percept& percept, double pan_rad) {
  percept.ball.pan_rad = pan_rad;
  for (std::size_t k = 0; k < percept.floor.count; ++k) percept.floor.rays[k].bearing_rad += pan_rad;
}

/// Processor time of the calling thread: what work costs, whoever else uses the machine.
double thread_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

void run_loop(const LoopPorts& ports, Clock& clock, const GoOn& go_on) {
  Loop loop(ports, clock);
  const RestAtEnd rest(ports.robot, clock);
  while (go_on(loop.advance())) {
  }
}

Loop::Loop(const LoopPorts& ports, Clock& clock)
    : ports_(ports), clock_(clock), on_the_way_(frames_on_the_way) {
  if (ports.controller.avoidance() != nullptr && !ports.robot.has_sonars()) {
    throw InputError(
        "avoidance", "a robot without sonars",
        "a robot with sonars, or avoidance.type none: nothing passes that no sonar has shown to be free");
  }
}

bool Loop::see(double until_s) {
  auto frame = ports_.camera.take(clock_, until_s);
  if (!frame) return false;
  const double before_s = thread_cpu_s();
  Seen seen{ports_.perception.look(*frame)};
  turn(seen.percept, frame->pan_rad);
  seen.perception_s = thread_cpu_s() - before_s;
  seen.arrived_s = std::max(frame->arrives_s, clock_.now_s());
  for (LoopObserver* each : ports_.observers)
    each->frame({*frame, seen.percept, seen.arrived_s, seen.perception_s});
  on_the_way_.put(std::move(seen));
  return true;
}

std::optional<double> Loop::step(const std::function<bool(double step_s)>& until_step) {
  const double rate_hz = ports_.controller.options().rate_hz;
  const long last = tick_;
  // What could not be done in time is left out.
  tick_ = std::max(last + 1, static_cast<long>(std::floor(clock_.now_s() * rate_hz)));
  if (!until_step(static_cast<double>(tick_) / rate_hz)) return std::nullopt;
  return control(tick_ - last - 1);
}

double Loop::advance() {
  return *step([this](double step_s) {
    while (see(step_s) && clock_.now_s() < step_s) {
    }
    clock_.sleep_until(step_s);
    return true;
  });
}

/// Processor time of perception for the newest frame; NaN where none has arrived.
double Loop::hear(double now_s) {
  double perception_s = std::nan("");
  while (const auto seen = on_the_way_.take([&](const Seen& s) { return s.arrived_s <= now_s; })) {
    ports_.controller.see(seen->percept.ball, seen->arrived_s);
    if (seen->percept.floor.count > 0) ports_.controller.see(seen->percept.floor);
    perception_s = seen->perception_s;
  }
  ports_.robot.listen([this](const SonarReading& reading) { ports_.controller.hear(reading); });
  return perception_s;
}

/// Hears of what has arrived, decides, commands. The time of the step.
double Loop::control(long skipped) {
  const RobotState robot = ports_.robot.read(clock_.now_s());
  const double perception_s = hear(robot.time_s);
  const double before_s = thread_cpu_s();
  ports_.controller.note_pan(robot.pan);
  const ControlOutput control = ports_.controller.step(robot.time_s, robot.odometry, robot.twist);
  const double control_s = thread_cpu_s() - before_s;
  ports_.robot.command(control.command, clock_.now_s());
  ports_.robot.pan(control.pan_radps, clock_.now_s());

  const StepEvent event{steps_++, robot, control, control_s, perception_s, skipped};
  for (LoopObserver* each : ports_.observers) each->step(event);
  if (control.state != state_) {
    for (LoopObserver* each : ports_.observers) each->transition(event, state_);
    state_ = control.state;
  }
  return robot.time_s;
}

RestAtEnd::~RestAtEnd() {
  try {
    robot_.command({}, clock_.now_s());
    robot_.pan(0, clock_.now_s());
  } catch (...) {  // NOLINT: nobody is left to hear of it
  }
}

}  // namespace ballservo
