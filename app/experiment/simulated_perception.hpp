// The three levels at which a run sees its ball.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/experiment/simulated_camera.hpp"
#include "app/loop/ports.hpp"
#include "app/scenario/scenario.hpp"
#include "calibration/color/color_table.hpp"
#include "perception/tracking/light_adaptation.hpp"

namespace ballservo {

/// image: rendered frames through detector and tracker. geometric: the true centre with the errors of a fit
/// to its outline. truth: the true centre.
enum class PerceptionLevel { image, geometric, truth };
inline std::string_view perception_level_name(PerceptionLevel level) {
  constexpr std::string_view names[]{"image", "geometric", "truth"};
  return names[static_cast<std::size_t>(level)];
}
/// The level of that name; InputError about `--perception` otherwise.
PerceptionLevel parse_perception_level(const std::string& text);

/// What make_perception is to be given: the scenario's colours for level image; null at the others, and where
/// it names none.
std::shared_ptr<const ColorTable> colors_of(const Scenario& scenario, PerceptionLevel level);

/// Perception that notes all balls that it knows of, in the form of tracks.csv.
class SimulatedPerception : public BallPerception {
 public:
  const std::string& tracks_csv() const { return tracks_csv_; }
  void forget() { tracks_csv_.clear(); }
  /// See Tracker.
  virtual std::optional<AssumedLight> assumed_light() const { return std::nullopt; }
  /// The scenario's world or noise is another from now on.
  virtual void look_around() {}

 protected:
  SimulatedPerception();
  /// Notes the target as measured.
  void note(const Scenario& scenario, const CameraFrame& frame, const Percept& percept, double quality);
  std::string tracks_csv_;
};

/// The robot stamps a frame with its arrival less the latency that it believes.
void stamp_as_believed(const Scenario& scenario, Percept& percept);

/// Detector and tracker for the scenario's balls, with the believed camera and diameter. Throws as
/// make_perception does.
std::unique_ptr<SimulatedPerception> make_image_perception(const Scenario& scenario,
                                                           std::shared_ptr<const ColorTable> colors);

/// What the run's options and the scenario ask for, as the robot believes camera, ball and latency to be:
/// measurements are stamped with a frame's arrival less the latency that is believed.
///   colors   for level image, where they must hold the target's class; may be null at the others
///   camera   whose frames are looked at; the levels without pictures ask it for their truth
/// Throws InputError for level image without colours, or with colours that do not hold the target's class (it
/// names those that are there). `scenario` and `camera` must outlive it.
std::unique_ptr<SimulatedPerception> make_perception(const Scenario& scenario, PerceptionLevel level,
                                                     std::shared_ptr<const ColorTable> colors,
                                                     const SimulatedCamera& camera);

}  // namespace ballservo
