#include "app/live/remedies.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "app/live/picture_questions.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

std::string source_of(const std::string& file) {
  std::ifstream stream(test::project_data_dir() / ".." / file);
  return (std::stringstream() << stream.rdbuf()).str();
}

TEST(Remedies, ThereIsOneForEveryReasonOfTheGuide) {
  const std::string guide = source_of("perception/README.md");
  static const std::regex row(R"-(\n\| "([^"|]+)" \| ([789][^|]*)\|)-");
  int rows = 0;
  for (std::sregex_iterator match(guide.begin(), guide.end(), row), end; match != end; ++match, ++rows)
    EXPECT_NE(remedy_of((*match)[1].str()), "") << (*match)[1];
  EXPECT_GE(rows, 9);
}

TEST(Remedies, ThereIsOneForEveryReasonOfTheJudge) {
  static const std::regex reason(
      R"-((?:return|reason =|too_weak =|no_edge =|disc_aslant =|\? nullptr\s*:|:) "([a-z][^"]* [^"]*)")-");
  int reasons = 0;
  for (const char* file : {"perception/judgement/ball_judge.cpp", "perception/judgement/clear_ball.cpp",
                           "perception/ball_verifier.cpp"}) {
    const std::string source = source_of(file);
    for (std::sregex_iterator match(source.begin(), source.end(), reason), end; match != end;
         ++match, ++reasons)
      EXPECT_NE(remedy_of((*match)[1].str()), "") << file << ": " << (*match)[1];
  }
  EXPECT_GE(reasons, 11);
}

TEST(PositionText, HasAsManyDigitsAsMeanSomething) {
  const auto text = [](double sigma_m) {
    return position_text({{0, 0, 1.0023}, Eigen::Matrix3d::Identity() * sigma_m * sigma_m});
  };
  EXPECT_EQ(text(0.0005), "1.0023 m +- 1.0 mm, across +- 1.0 mm");
  EXPECT_EQ(text(0.00056), "1.002 m +- 1.1 mm, across +- 1.1 mm");
  EXPECT_EQ(text(0.0146), "1.00 m +- 29 mm, across +- 29 mm");
  EXPECT_EQ(text(0.0765), "1.0 m +- 150 mm, across +- 150 mm");
}

TEST(WhyNoBall, OfAFollowedBallSaysThatItIsOne) {
  auto colors = std::make_shared<ColorTable>();
  colors->classes.resize(1);
  const Camera camera({LensModel::pinhole, {160, 120}, 150, 150, 79.5, 59.5, {}});
  Detector detector(std::make_shared<const RayTable>(camera), colors, DetectorOptions());
  const cv::Mat grey(120, 160, CV_8UC3, cv::Scalar::all(90));
  Track track;
  track.id = 3;
  track.state = TrackState::confirmed;
  track.ball.outline.center_px = {80, 60};
  track.ball.outline.radius_px = 20;
  const auto said = [&](double u_px) { return why_no_ball(grey, {u_px, 60}, detector, {track}); };
  EXPECT_EQ(said(90)["ball"], true);
  EXPECT_EQ(said(90)["text"].get<std::string>().rfind("track 3 follows this ball", 0), 0u) << said(90);
  EXPECT_EQ(said(110)["ball"], false) << "beside it";
  track.state = TrackState::coasting;
  EXPECT_EQ(said(90)["ball"], false) << "a prediction";
}

}  // namespace
}  // namespace ballservo
