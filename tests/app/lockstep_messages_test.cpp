// What a peer says in lockstep is read back as it was written; whatever cannot be is refused with words.
#include "app/peer/lockstep_messages.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr AnswerBounds honest{0.58, 0.02, {0, 0}, 0.5, 16};

LockstepAnswer an_answer() {
  LockstepAnswer answer;
  answer.state = {0.58, {1.25, -0.1, 1.0 / 3}, {0.1, -1e-17}, {0.4, -0.3}};
  answer.sonars = {{0.55, 15, 2.5, true}, {0.56, 0, 5, false}};
  CameraFrame frame{17, 0.533, 0.567, {}, 0.35};
  BallMeasurement ball{0.533, TrackState::confirmed, {0.1, 0.2, 1.0 / 7}, 1e-6 * Eigen::Matrix3d::Identity()};
  answer.frames = {{frame, ball}};
  return answer;
}

/// The words by which it is refused; empty: it passes.
std::string refusal(const LockstepParts& parts, const AnswerBounds& bounds = honest) {
  try {
    answer_of(parts, bounds);
  } catch (const PeerGone& gone) {
    return gone.what();
  }
  return "";
}

TEST(LockstepMessages, AnAnswerIsReadAsItWasWritten) {
  const LockstepAnswer told = an_answer(), heard = answer_of(parts_of(told), honest);
  EXPECT_EQ(heard.state.time_s, told.state.time_s);
  EXPECT_EQ(heard.state.odometry.yaw_rad, told.state.odometry.yaw_rad);
  EXPECT_EQ(heard.state.twist.w_radps, told.state.twist.w_radps);
  EXPECT_EQ(heard.state.pan.angle_rad, 0.4);
  EXPECT_EQ(heard.state.pan.speed_radps, -0.3);
  ASSERT_EQ(heard.sonars->size(), 2u);
  EXPECT_EQ((*heard.sonars)[0].transducer, 15u);
  EXPECT_EQ((*heard.sonars)[1].echo, false);
  ASSERT_EQ(heard.frames.size(), 1u);
  EXPECT_EQ(heard.frames[0].frame.number, 17);
  EXPECT_EQ(heard.frames[0].frame.arrives_s, 0.567);
  EXPECT_EQ(heard.frames[0].frame.pan_rad, 0.35);
  EXPECT_EQ(heard.frames[0].ball.p_CB, told.frames[0].ball.p_CB);
  EXPECT_EQ(heard.frames[0].ball.covariance_m2, told.frames[0].ball.covariance_m2);
}

TEST(LockstepMessages, APictureIsReadAsItWasWritten) {
  LockstepAnswer told = an_answer();
  told.frames[0].frame.bgr = cv::Mat(4, 6, CV_8UC3, cv::Scalar(1, 2, 3));
  AnswerBounds bounds = honest;
  bounds.picture = {6, 4};
  const LockstepAnswer heard = answer_of(parts_of(told), bounds);
  EXPECT_EQ(cv::norm(heard.frames[0].frame.bgr, told.frames[0].frame.bgr, cv::NORM_INF), 0);
  EXPECT_THAT(refusal(parts_of(told)), HasSubstr("this run looks at no pictures"));
  EXPECT_THAT(refusal(parts_of(an_answer()), bounds), HasSubstr("a picture for each frame"));
  bounds.picture = {7, 4};
  EXPECT_THAT(refusal(parts_of(told), bounds),
              HasSubstr("picture of frames[0]: found 72 bytes; allowed: 84"));
}

TEST(LockstepMessages, ARequestIsReadAsItWasWritten) {
  const LockstepRequest heard = request_of(parts_of(LockstepRequest{1.0 / 3, {0.1, -0.2}, 0.7, "enough"}));
  EXPECT_EQ(heard.until_s, 1.0 / 3);
  EXPECT_EQ(heard.command.w_radps, -0.2);
  EXPECT_EQ(heard.pan_radps, 0.7);
  EXPECT_EQ(heard.end, "enough");
  const auto refused = [](const char* text) {
    try {
      request_of({text});
    } catch (const PeerGone& gone) {
      return std::string(gone.what());
    }
    return std::string();
  };
  EXPECT_THAT(refused(R"({"ballservo_lockstep":1,"until_s":0,"command":[NaN,0]})"), HasSubstr("JSON"));
  EXPECT_THAT(refused(R"({"ballservo_lockstep":1,"until_s":0,"command":[1e9,0]})"), HasSubstr("command[0]"));
  EXPECT_THAT(refused(R"({"ballservo_lockstep":1,"command":[0,0]})"), HasSubstr("until_s is required"));
}

TEST(LockstepMessages, LiesAreAnsweredWithWords) {
  struct Lie {
    const char *place, *value, *words;
  };
  for (const Lie& lie : std::initializer_list<Lie>{
           {"/ballservo_lockstep", "2", "ballservo_lockstep: found 2; allowed: 1"},
           {"/ballservo_lockstep", "\"1\"", "ballservo_lockstep"},
           {"/time_s", "0.56", "time_s: found 0.56"},
           {"/time_s", "0.6", "time_s: found 0.6"},
           {"/time_s", "null", "time_s: found null"},
           {"/odometry", "[1, 2]", "odometry: found [1,2]; allowed: a list of 3 numbers"},
           {"/odometry/2", "1e300", "odometry[2]"},
           {"/twist/0", "\"fast\"", "twist[0]"},
           {"/pan_rad", "\"left\"", "pan_rad: found"},
           {"/sonars", "7", "sonars"},
           {"/sonars/0/transducer", "16", "sonars[0].transducer"},
           {"/sonars/0/transducer", "-1", "sonars[0].transducer"},
           {"/sonars/0/transducer", "1.5", "sonars[0].transducer"},
           {"/sonars/1/range_m", "-0.1", "sonars[1].range_m"},
           {"/sonars/1/echo", "1", "sonars[1].echo"},
           {"/sonars/1/fired_s", "0.7", "sonars[1].fired_s"},
           {"/frames", "{}", "frames"},
           {"/frames/0", "0", "frames[0].frame: found nothing"},
           {"/frames/0/frame", "16", "frames[0].frame: found 16; allowed: a whole number above 16"},
           {"/frames/0/frame", "1e30", "frames[0].frame"},
           {"/frames/0/frame", "18446744073709551615", "frames[0].frame"},
           {"/frames/0/time_s", "0.5", "frames[0].time_s"},
           {"/frames/0/arrived_s", "0.6", "frames[0].arrived_s"},
           {"/frames/0/arrived_s", "0.5", "frames[0].arrived_s"},
           {"/frames/0/ball/state", "\"none\"", "frames[0].ball.state"},
           {"/frames/0/ball/p_m/1", "null", "frames[0].ball.p_m[1]"},
           {"/frames/0/ball/covariance_m2/1", "[0, 1]", "frames[0].ball.covariance_m2[1]"},
           {"/frames/0/ball/covariance_m2/1/1", "-1", "variances of 0 or more"},
           {"/truth", "{\"pose\": [0, 0]}", "truth.pose"},
           {"/over", "{\"text\": 1}", "over.outcome"}}) {
    json header = json::parse(parts_of(an_answer())[0]);
    header[json::json_pointer(lie.place)] = json::parse(lie.value);
    EXPECT_THAT(refusal({header.dump()}), HasSubstr(lie.words)) << lie.place << " " << lie.value;
  }
}

TEST(LockstepMessages, WhatIsNoHeaderIsRefused) {
  const std::string text = parts_of(an_answer())[0];
  for (const std::string& header :
       {std::string(), std::string("hello"), std::string("[1]"), std::string("\xff\xfe\0", 3),
        std::string(100000, '['), text + "}", text.substr(0, text.size() / 2)})
    EXPECT_THAT(refusal({header}), HasSubstr("an object in JSON")) << header.substr(0, 20);
  EXPECT_THAT(refusal({}), HasSubstr("header: found 0 bytes"));
  EXPECT_THAT(refusal({std::string(most_header_bytes + 1, ' ')}), HasSubstr("header: found 1048577 bytes"));
  EXPECT_THAT(refusal({text, text}), HasSubstr("message: found 2 parts"));
  json many = json::parse(text);
  many["frames"] = json::array();
  for (std::size_t i = 0; i <= most_frames; ++i) many["frames"].push_back(nullptr);
  EXPECT_THAT(refusal({many.dump()}), HasSubstr("a list of up to 64"));
}

TEST(LockstepMessages, WordsOfAPeerAreCutAndPlain) {
  json header = json::parse(parts_of(an_answer())[0]);
  header["odometry"] = "\x1b[31m" + std::string(10000, 'x');
  EXPECT_LT(refusal({header.dump()}).size(), 500u);
  header = {{"ballservo_lockstep", 1}, {"over", {{"outcome", "lost"}, {"text", "\x1b[31m gone\n"}}}};
  EXPECT_EQ(answer_of({header.dump()}, honest).text, " [31m gone ");
}

// Bytes changed at random pass or are refused; nothing else happens.
TEST(LockstepMessages, NoiseIsRefusedOrPasses) {
  const std::string text = parts_of(an_answer())[0];
  RandomEngine engine = random_stream(1, "lockstep noise");
  int refused = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    std::string spoilt = text;
    for (int k = 0; k < 1 + trial % 4; ++k)
      spoilt[uniform_index(engine, static_cast<std::uint32_t>(spoilt.size()))] =
          static_cast<char>(uniform_index(engine, 256));
    refused += refusal({spoilt}).empty() ? 0 : 1;
  }
  EXPECT_GT(refused, 2000);
  EXPECT_LT(refused, 4000);
}

}  // namespace
}  // namespace ballservo
