#include "app/peer/lockstep_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace ballservo {

namespace {

using nlohmann::json;

constexpr const char* version_key = "ballservo_lockstep";
constexpr int version = 1;
constexpr double time_slack_s = 1e-6;  // 3 * 0.02 is not 0.06
constexpr double most_size = 1e6;      // of any coordinate, speed or time
constexpr std::size_t most_readings = 1024;
constexpr std::ptrdiff_t most_nested = 8192;
constexpr std::size_t most_said = 300;  // of the other side's words, in ours

std::string cut(std::string text) {
  if (text.size() > most_said) text = text.substr(0, most_said) + "...";
  // It ends up on a terminal.
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, ' ');
  return text;
}

[[noreturn]] void lie(const std::string& place, const std::string& found, const std::string& allowed) {
  throw PeerGone(to_text({place, cut(found), allowed}));
}

std::string text_of(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

const json& at(const json& object, const std::string& key, const std::string& place) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  if (!object.is_object() || found == object.end()) lie(place, "nothing", "a value: " + key + " is required");
  return *found;
}

double number(const json& value, const std::string& place, double low = -most_size, double high = most_size) {
  const double number = value.is_number() ? value.get<double>() : std::nan("");
  if (!(number >= low && number <= high))
    lie(place, text_of(value), fmt::format("a number from {:.9g} to {:.9g}", low, high));
  return number;
}

template <int Count>
std::array<double, Count> numbers(const json& list, const std::string& place) {
  if (!list.is_array() || list.size() != Count)
    lie(place, text_of(list), fmt::format("a list of {} numbers", Count));
  std::array<double, Count> values{};
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = number(list[i], fmt::format("{}[{}]", place, i));
  return values;
}

template <int Count>
std::array<double, Count> numbers(const json& object, const std::string& key, const std::string& within) {
  return numbers<Count>(at(object, key, within + key), within + key);
}

std::string word(const json& object, const std::string& key, const std::string& within = "") {
  const json& value = at(object, key, within + key);
  if (!value.is_string()) lie(within + key, text_of(value), "text");
  return cut(value.get<std::string>());
}

Twist2 twist_of(const json& object, const std::string& key, const std::string& within = "") {
  const auto [v_mps, w_radps] = numbers<2>(object, key, within);
  return {v_mps, w_radps};
}

Pose2 pose_of(const json& object, const std::string& key, const std::string& within = "") {
  const auto [x_m, y_m, yaw_rad] = numbers<3>(object, key, within);
  return {x_m, y_m, yaw_rad};
}

/// 0 where the key is missing.
double number_or_0(const json& object, const std::string& key, const std::string& within = "") {
  const auto found = object.find(key);
  return found == object.end() ? 0.0 : number(*found, within + key);
}

const json& list_at(const json& object, const std::string& key, std::size_t longest) {
  const json& list = at(object, key, key);
  if (!list.is_array() || list.size() > longest)
    lie(key, text_of(list), fmt::format("a list of up to {}", longest));
  return list;
}

std::string in_list(const std::string& key, std::size_t index) { return fmt::format("{}[{}].", key, index); }

json header_of(const LockstepParts& parts) {
  if (parts.empty() || parts[0].size() > most_header_bytes)
    lie("header", fmt::format("{} bytes", parts.empty() ? 0 : parts[0].size()),
        fmt::format("up to {} bytes", most_header_bytes));
  const std::string& text = parts[0];
  // JSON that nests deeply would overflow the stack of who prints it.
  const bool nests =
      std::count_if(text.begin(), text.end(), [](char c) { return c == '[' || c == '{'; }) > most_nested;
  json header = nests ? json(json::value_t::discarded) : json::parse(text, nullptr, false);
  if (!header.is_object()) lie("header", text, "an object in JSON (which has neither NaN nor Infinity)");
  const auto said = header.find(version_key);
  if (said == header.end() || !said->is_number_integer() || *said != version)
    lie(version_key, said == header.end() ? "nothing" : text_of(*said), std::to_string(version));
  return header;
}

BallMeasurement ball_of(const json& ball, double time_s, const std::string& within) {
  BallMeasurement measurement;
  measurement.time_s = time_s;
  if (ball.is_null()) return measurement;
  const std::string state = word(ball, "state", within);
  for (const TrackState each : {TrackState::tentative, TrackState::confirmed, TrackState::coasting})
    if (state == track_state_name(each)) measurement.state = each;
  if (measurement.state == TrackState::none) lie(within + "state", state, "tentative, confirmed or coasting");
  measurement.p_CB = Eigen::Vector3d(numbers<3>(ball, "p_m", within).data());
  const std::string place = within + "covariance_m2";
  const json& rows = at(ball, "covariance_m2", place);
  if (!rows.is_array() || rows.size() != 3) lie(place, text_of(rows), "three rows");
  for (int i = 0; i < 3; ++i)
    measurement.covariance_m2.row(i) = Eigen::RowVector3d(
        numbers<3>(rows[static_cast<std::size_t>(i)], fmt::format("{}[{}]", place, i)).data());
  if (measurement.covariance_m2.diagonal().minCoeff() < 0)
    lie(place, text_of(rows), "variances of 0 or more");
  return measurement;
}

json ball_json(const BallMeasurement& ball) {
  if (ball.state == TrackState::none) return nullptr;
  const Eigen::Vector3d& p = ball.p_CB;
  const Eigen::Matrix3d& s = ball.covariance_m2;
  return {{"state", track_state_name(ball.state)},
          {"p_m", {p.x(), p.y(), p.z()}},
          {"covariance_m2",
           {{s(0, 0), s(0, 1), s(0, 2)}, {s(1, 0), s(1, 1), s(1, 2)}, {s(2, 0), s(2, 1), s(2, 2)}}}};
}

SonarReading reading_of(const json& reading, double until_s, const std::string& within) {
  SonarReading heard;
  heard.fired_s = number(at(reading, "fired_s", within + "fired_s"), within + "fired_s", -most_size, until_s);
  const json& transducer = at(reading, "transducer", within + "transducer");
  if (!transducer.is_number_integer() || transducer < 0 || transducer >= sonar_count)
    lie(within + "transducer", text_of(transducer),
        fmt::format("a whole number from 0 to {}", sonar_count - 1));
  heard.transducer = transducer.get<std::size_t>();
  heard.range_m = number(at(reading, "range_m", within + "range_m"), within + "range_m", 0);
  const json& echo = at(reading, "echo", within + "echo");
  if (!echo.is_boolean()) lie(within + "echo", text_of(echo), "true or false");
  heard.echo = echo.get<bool>();
  return heard;
}

/// The frame with its place in the header, without its picture.
LockstepFrame frame_of(const json& frame, const std::string& within, const AnswerBounds& after,
                       double now_s) {
  LockstepFrame arrived;
  const json& count = at(frame, "frame", within + "frame");
  if (!count.is_number_integer() || count <= after.frame || count > 1000000000)
    lie(within + "frame", text_of(count), fmt::format("a whole number above {}", after.frame));
  arrived.frame.number = count.get<long>();
  arrived.frame.time_s =
      number(at(frame, "time_s", within + "time_s"), within + "time_s", after.frame_s, now_s);
  arrived.frame.arrives_s =
      number(at(frame, "arrived_s", within + "arrived_s"), within + "arrived_s", arrived.frame.time_s, now_s);
  arrived.frame.pan_rad = number_or_0(frame, "pan_rad", within);
  if (arrived.frame.time_s == after.frame_s) lie(within + "time_s", text_of(frame["time_s"]), "a later time");
  if (const auto ball = frame.find("ball"); ball != frame.end())
    arrived.ball = ball_of(*ball, arrived.frame.time_s, within + "ball.");
  arrived.ball.time_s = arrived.frame.time_s;
  return arrived;
}

cv::Mat picture_of(std::string pixels, ImageSize size, const std::string& place) {
  const std::size_t bytes =
      3u * static_cast<std::size_t>(size.width_px) * static_cast<std::size_t>(size.height_px);
  if (pixels.size() != bytes)
    lie(place, fmt::format("{} bytes", pixels.size()),
        fmt::format("{} bytes: {} rows of {} pixels, blue, green, red", bytes, size.height_px,
                    size.width_px));
  return cv::Mat(size.height_px, size.width_px, CV_8UC3, pixels.data()).clone();
}

LockstepParts with_header(const json& header) { return {text_of(header)}; }

}  // namespace

LockstepParts parts_of(const LockstepRequest& request) {
  json header = {{version_key, version},
                 {"until_s", request.until_s},
                 {"command", {request.command.v_mps, request.command.w_radps}},
                 {"pan_radps", request.pan_radps}};
  if (!request.end.empty()) header["end"] = request.end;
  if (!request.scenario.is_null()) header["scenario"] = request.scenario;
  return with_header(header);
}

LockstepParts parts_of(const LockstepAnswer& answer) {
  if (!answer.outcome.empty())
    return with_header(
        {{version_key, version}, {"over", {{"outcome", answer.outcome}, {"text", answer.text}}}});
  const RobotState& state = answer.state;
  json header = {{version_key, version},
                 {"time_s", state.time_s},
                 {"odometry", {state.odometry.x_m, state.odometry.y_m, state.odometry.yaw_rad}},
                 {"twist", {state.twist.v_mps, state.twist.w_radps}},
                 {"pan_rad", state.pan.angle_rad},
                 {"pan_radps", state.pan.speed_radps},
                 {"frames", json::array()}};
  if (answer.sonars) {
    header["sonars"] = json::array();
    for (const SonarReading& heard : *answer.sonars)
      header["sonars"].push_back({{"fired_s", heard.fired_s},
                                  {"transducer", heard.transducer},
                                  {"range_m", heard.range_m},
                                  {"echo", heard.echo}});
  }
  if (!answer.robot.is_null()) header["robot"] = answer.robot;
  for (const auto& [frame, ball] : answer.frames)
    header["frames"].push_back({{"frame", frame.number},
                                {"time_s", frame.time_s},
                                {"arrived_s", frame.arrives_s},
                                {"pan_rad", frame.pan_rad},
                                {"ball", ball_json(ball)}});
  LockstepParts parts = with_header(header);
  for (const auto& [frame, ball] : answer.frames)
    if (!frame.bgr.empty())
      parts.emplace_back(reinterpret_cast<const char*>(frame.bgr.data),
                         frame.bgr.total() * frame.bgr.elemSize());
  return parts;
}

LockstepRequest request_of(const LockstepParts& parts) {
  const json header = header_of(parts);
  if (parts.size() != 1) lie("message", fmt::format("{} parts", parts.size()), "a header alone");
  LockstepRequest request{number(at(header, "until_s", "until_s"), "until_s"), twist_of(header, "command"),
                          number_or_0(header, "pan_radps")};
  if (header.contains("end")) request.end = word(header, "end");
  return request;
}

LockstepAnswer answer_of(LockstepParts parts, const AnswerBounds& bounds) {
  const json header = header_of(parts);
  LockstepAnswer answer;
  if (const auto over = header.find("over"); over != header.end()) {
    answer.outcome = word(*over, "outcome", "over.");
    answer.text = word(*over, "text", "over.");
    return answer;
  }
  const double now_s = number(at(header, "time_s", "time_s"), "time_s", bounds.until_s - time_slack_s,
                              bounds.until_s + bounds.period_s - time_slack_s);
  answer.state = {now_s,
                  pose_of(header, "odometry"),
                  twist_of(header, "twist"),
                  {number_or_0(header, "pan_rad"), number_or_0(header, "pan_radps")}};
  if (header.contains("sonars")) {
    answer.sonars.emplace();
    const json& list = list_at(header, "sonars", most_readings);
    for (std::size_t i = 0; i < list.size(); ++i)
      answer.sonars->push_back(reading_of(list[i], now_s, in_list("sonars", i)));
  }
  if (const auto truth = header.find("truth"); truth != header.end())
    answer.truth = {pose_of(*truth, "pose", "truth."), twist_of(*truth, "twist", "truth.")};
  const json& frames = list_at(header, "frames", most_frames);
  AnswerBounds after = bounds;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    answer.frames.push_back(frame_of(frames[i], in_list("frames", i), after, now_s));
    after.frame = answer.frames.back().frame.number;
    after.frame_s = answer.frames.back().frame.time_s;
  }
  const bool pictures = bounds.picture.width_px > 0;
  const std::size_t expected = 1 + (pictures ? frames.size() : 0);
  if (parts.size() != expected)
    lie("message", fmt::format("{} parts", parts.size()),
        pictures ? fmt::format("{}: the header, and a picture for each frame", expected)
                 : "the header alone: this run looks at no pictures");
  for (std::size_t i = 1; i < parts.size(); ++i)
    answer.frames[i - 1].frame.bgr =
        picture_of(std::move(parts[i]), bounds.picture, fmt::format("picture of frames[{}]", i - 1));
  return answer;
}

}  // namespace ballservo
