#include "app/experiment/peer_run.hpp"

#include "app/experiment/peer_robot.hpp"
#include "app/experiment/run_recorder.hpp"
#include "app/experiment/run_video.hpp"
#include "app/loop/loop.hpp"

namespace ballservo {

RunRecord drive_peer(const Scenario& scenario, const RunOptions& options, LockstepSocket& socket) {
  const bool pictures = options.perception == PerceptionLevel::image;
  const ControllerOptions settings = controller_options(scenario);
  Controller controller(settings, options.laws.make(scenario.law, settings.goal));
  std::unique_ptr<SimulatedPerception> perception;
  if (pictures) perception = make_image_perception(scenario, options.colors);
  PeerRobot robot(socket, scenario, pictures);
  if (!pictures) perception = std::make_unique<PeerPerception>(scenario, robot);
  RunRecorder recorder(scenario, robot, nullptr, false);
  PictureKeeper keeper(scenario);
  SteppedClock clock;
  std::optional<PeerGone> gone;
  try {
    run_loop({robot, *perception, robot, controller, {&recorder, &keeper}}, clock,
             [&](double time_s) { return (!options.go_on || options.go_on(time_s)) && !recorder.over(); });
  } catch (const PeerGone& error) {
    gone = error;
  }
  RunRecord run = recorder.finish(false);
  if (gone) end_by(*gone, run.summary);
  robot.leave(run.summary.outcome_text);
  if (gone && run.steps.empty()) throw PeerGone(*gone);
  run.tracks_csv = perception->tracks_csv();
  run.assumed_light = perception->assumed_light();
  run.key_frames = keeper.finish();
  return run;
}

}  // namespace ballservo
