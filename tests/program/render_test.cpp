// Rendered pictures against the frames of a run whose robot stands.
#include <opencv2/core.hpp>

#include "app/experiment/simulated_camera.hpp"
#include "calibration/base/csv_table.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/pictures/image_file.hpp"
#include "tests/program/program_run.hpp"

namespace ballservo {
namespace {

using Render = test::ProgramTest;

// A ball that rolls, smeared by a long exposure; the second frame is lost, the last ones are dark.
const std::vector<std::string> sets{"camera.rate_hz=10",
                                    "camera.exposure_s=0.08",
                                    "camera.exposure_steps=4",
                                    "balls.0.motion.start_s=0",
                                    "balls.0.motion.speed_mps=1",
                                    "camera.faults=[{type: dropped, from_s: 0.1, until_s: 0.2}, {type: "
                                    "exposure, level: 0.3, from_s: 0.3}]"};

TEST_F(Render, PicturesAreTheFramesOfARunWhoseRobotStands) {
  const auto file = test::project_data_dir() / "scenarios" / "moving_ball.yaml";
  constexpr std::uint64_t seed = 7;
  std::string arguments = "render '" + file.string() + "' -o out --frames 5 --seed 7";
  for (const std::string& set : sets) arguments += " --set '" + set + "'";
  const test::Ending ending = run(arguments);
  ASSERT_EQ(ending.code, 0) << ending.messages;

  const Scenario scenario = load_scenario(file, sets, seed);
  SimulatedCamera camera(scenario, true, [&](double time_s) {
    return RobotTruth{time_s, scenario.robot.pose, {}};
  });
  SteppedClock clock;
  std::set<std::string> expected{"out", "camera.yaml", "truth.csv"};
  std::string truth = contents("out/truth.csv");
  while (const auto frame = camera.take(clock, 0.5)) {
    const std::string name = "frame_000" + std::to_string(frame->number) + ".png";
    expected.insert(name);
    EXPECT_EQ(cv::norm(frame->bgr, read_color_image(dir / "out" / name), cv::NORM_INF), 0) << name;
    EXPECT_THAT(truth, testing::HasSubstr(number_text(camera.truth().target.p_CB.z()))) << name;
  }
  EXPECT_EQ(names(), expected);
  EXPECT_EQ(expected.count("frame_0001.png"), 0u);
  const auto brightness = [&](const char* name) { return cv::mean(read_color_image(dir / "out" / name))[1]; };
  EXPECT_LT(brightness("frame_0003.png"), 0.5 * brightness("frame_0000.png"));
}

TEST_F(Render, PicturesAreFollowedAtTheTimesThatTheirTruthTells) {
  const auto file = test::project_data_dir() / "scenarios" / "static_ball.yaml";
  const auto colors = test::project_data_dir() / "colors" / "red.colors";
  ASSERT_EQ(run("render '" + file.string() +
                "' -o out --frames 4 --set camera.rate_hz=10 "
                "--set 'camera.faults=[{type: dropped, from_s: 0.1, until_s: 0.2}]'")
                .code,
            0);
  const auto times = [&] {
    std::set<double> found;
    const CsvTable table =
        parse_csv(run("track out --colors '" + colors.string() + "'").out, "tracks", {"time_s"},
                  {"source", "frame", "track_id", "class", "state", "quality", "cx_px", "cy_px", "r_px",
                   "x_m", "y_m", "z_m", "sxx_m2", "sxy_m2", "sxz_m2", "syy_m2", "syz_m2", "szz_m2"});
    for (const auto& row : table.rows)
      found.insert(std::stod(row[static_cast<std::size_t>(table.column("time_s"))]));
    return found;
  };
  const auto near = [](double time_s) { return testing::DoubleNear(time_s, 1e-9); };
  EXPECT_THAT(times(), testing::ElementsAre(near(0.002), near(0.202), near(0.302)));
  put("out/truth.csv", "source,mine\nframe_0000.png,1\n");  // somebody else's table
  EXPECT_EQ(times().count(0), 1u);
}

TEST_F(Render, FewerPicturesLeaveNoneOfAnEarlierRunButTheUsersOwn) {
  const auto file = test::project_data_dir() / "scenarios" / "static_ball.yaml";
  const std::string render = "render '" + file.string() + "' -o out --force --frames ";
  ASSERT_EQ(run(render + "3").code, 0);
  for (const char* const name : {"out/frame_0500.png", "out/photo.png"}) put(name, "the user's own");
  std::ofstream(dir / "out/truth.csv", std::ios::app) << "photo.png,0,,,,,,,,,\n";
  ASSERT_EQ(run(render + "1").code, 0);
  const std::set<std::string> expected{
      "out", "camera.yaml", "truth.csv", "frame_0000.png", "frame_0500.png", "photo.png"};
  EXPECT_EQ(names(), expected);
}

TEST_F(Render, RefusesACameraThatLosesEveryFrame) {
  const auto file = test::project_data_dir() / "scenarios" / "static_ball.yaml";
  const test::Ending ending =
      run("render '" + file.string() + "' -o out --frames 2 --set 'camera.faults=[{type: dropped}]'");
  EXPECT_EQ(ending.code, 1);
  EXPECT_THAT(ending.messages, testing::HasSubstr("drop all 2 frames"));
  EXPECT_THAT(names(), testing::IsEmpty());
}

}  // namespace
}  // namespace ballservo
