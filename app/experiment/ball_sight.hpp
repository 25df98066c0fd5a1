// Where perception meets servo: the three levels at which a run sees its ball.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration/camera/camera.hpp"
#include "calibration/color/color_table.hpp"
#include "servo/control/ball_measurement.hpp"
#include "servo/control/law.hpp"
#include "servo/simulation/rendering/truth.hpp"
#include "servo/simulation/robot/geometric_ball_sensor.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// image: rendered frames through detector and tracker. geometric: the true centre with the errors of a fit
/// to its outline. truth: the true centre.
enum class PerceptionLevel { image, geometric, truth };
std::string_view perception_level_name(PerceptionLevel level);
/// The level of that name; InputError about `--perception` otherwise.
PerceptionLevel parse_perception_level(const std::string& text);

/// One frame, for whoever looks at it.
struct SightInput {
  int frame = 0;
  double time_s = 0;                  ///< middle of the exposure
  const cv::Mat* picture = nullptr;   ///< level image only
  const BallTruth* target = nullptr;  ///< what is true of the target; for the other levels only
};

/// What was seen of the target in a frame.
struct Sight {
  BallMeasurement measurement;
  std::optional<OutlineEllipse> outline;
};

/// Looks at frames in order of time and tells the target from everything else.
class BallSight {
 public:
  virtual ~BallSight() = default;
  /// Appends the frame's rows (all balls it knows of) to `rows`, in the form of tracks.csv.
  virtual Sight look(const SightInput& input, std::string& rows) = 0;
};

/// Level image. The target is the first track of its class that was confirmed, for as long as it lives; until
/// then the best tentative one. What lies elsewhere than at the height of the goal's ball, or between there
/// and where it is lifted to, by more than a badly known mount explains, is another thing: a sign on the
/// wall. `diameters_m` hold each class's ball, 0 where it is not known; the target's class must be in
/// `colors` (InputError, which names those that are). The colours follow the light unless `fixed_colors`.
std::unique_ptr<BallSight> make_image_sight(const Camera& camera, std::shared_ptr<const ColorTable> colors,
                                            const Ball& target, const std::vector<Ball>& balls,
                                            const ServoGoal& goal, std::uint64_t seed, bool fixed_colors);

/// A camera and a ball's radius (m) as they are believed to be.
struct BelievedView {
  Camera camera;
  double radius_m;
};

/// Levels geometric and truth (`options.exact`). With `believed` the place is the one that the ball's outline
/// would have by those beliefs.
std::unique_ptr<BallSight> make_geometric_sight(const Camera& camera, const Ball& target,
                                                const GeometricSensorOptions& options, std::uint64_t seed,
                                                const std::optional<BelievedView>& believed = {});

}  // namespace ballservo
