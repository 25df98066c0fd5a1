// A robot in MuJoCo's physics that ballservo drives in lockstep: motors turn wheels, which roll and slip;
// sonars range, and a camera tells where the ball is.
//
//     g++ -std=c++17 -O2 app/examples/mujoco_robot.cpp -o mujoco_robot -lmujoco -lzmq
//     ./mujoco_robot 5577 &                               # libmujoco-dev, cppzmq-dev, nlohmann-json3-dev
//     ballservo servo data/scenarios/corridor.yaml -o run --perception geometric --peer tcp://127.0.0.1:5577
//
// The messages are those of app/peer/README.md. Frames: W world, z up, the floor at 0; R robot, on the floor
// under the middle of the axle, x forward, y left, z up; C camera, x right, y down, z forward.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <zmq.hpp>

using nlohmann::json;

// A Pioneer 3-DX and its world (m, kg, rad). What stands in braces is looked up in the scenario.
const std::string world_mjcf = R"(
<mujoco model="pioneer_3dx">
  <compiler angle="radian" autolimits="true"/>
  <option timestep="0.001"/>
  <default>
    <default class="wheel">  <!-- touches the floor at one point, as a thin tyre -->
      <joint axis="0 1 0" armature="0.02"/>  <!-- and its geared motor's inertia -->
      <geom type="ellipsoid" size="0.0975 0.02 0.0975" mass="1.5"/>
      <velocity kv="10" forcerange="-5 5"/>
    </default>
    <default class="wall"> <geom type="plane" size="0 0 1"/> </default>
  </default>
  <worldbody>
    <body name="robot" pos="{/robot/pose/x_m} {/robot/pose/y_m} 0" euler="0 0 {/robot/pose/yaw_rad}">
      <freejoint/>
      <geom type="box" pos="-0.0455 0 0.15" size="0.2555 0.2125 0.07" mass="6"/>
      <body pos="0 0.1655 0.0975"> <joint name="left" class="wheel"/> <geom class="wheel"/> </body>
      <body pos="0 -0.1655 0.0975"> <joint name="right" class="wheel"/> <geom class="wheel"/> </body>
      <!-- the caster: a sphere without friction -->
      <geom type="sphere" pos="-0.22 0 0.0375" size="0.0375" mass="0.3" condim="1" priority="1"/>
      <body pos="{/camera/mount/forward_m} 0 {/camera/mount/up_m}" euler="0 {/camera/mount/pitch_down_rad} 0">
        <camera xyaxes="0 -1 0 0 0 1"/>
      </body>
    </body>
    <body pos="{/ball/position/x_m} {/ball/position/y_m} {/ball/position/z_m}">
      <freejoint/>
      <geom name="ball" type="sphere" size="{/ball/radius_m}" mass="0.1" condim="6"/>
    </body>
    <geom class="wall"/>  <!-- the floor -->
    <geom class="wall" pos="{/room/x_min_m} 0 0" zaxis="1 0 0"/>
    <geom class="wall" pos="{/room/x_max_m} 0 0" zaxis="-1 0 0"/>
    <geom class="wall" pos="0 {/room/y_min_m} 0" zaxis="0 1 0"/>
    <geom class="wall" pos="0 {/room/y_max_m} 0" zaxis="0 -1 0"/>
    {/obstacles}
  </worldbody>
  <actuator> <velocity joint="left" class="wheel"/> <velocity joint="right" class="wheel"/> </actuator>
</mujoco>)";
const std::string box_mjcf = R"(<geom type="box" pos="{/position/x_m} {/position/y_m} {/z_m}"
  size="{/size/x_m} {/size/y_m} {/size/z_m}" euler="0 0 {/yaw_rad}"/>)";
const std::string cylinder_mjcf = R"(<geom type="cylinder" pos="{/position/x_m} {/position/y_m} {/z_m}"
  size="{/size/x_m} {/size/z_m}"/>)";
constexpr double wheel_radius_m = 0.0975, track_m = 0.331;  // as above
constexpr double a_mps2 = 0.3, alpha_radps2 = 1.745;        // so fast the firmware changes its set points
constexpr double tan_half_width = 0.66, tan_half_height = 0.49;  // of the picture of data/cameras/wide.yaml

// The sonars in R: x_m, y_m, heading_deg. The front eight and the rear eight take turns.
constexpr double sonars[16][3] = {
    {0.069, 0.136, 90},    {0.114, 0.119, 50},     {0.148, 0.078, 30},     {0.166, 0.027, 10},
    {0.166, -0.027, -10},  {0.148, -0.078, -30},   {0.114, -0.119, -50},   {0.069, -0.136, -90},
    {-0.157, -0.136, -90}, {-0.203, -0.119, -130}, {-0.237, -0.078, -150}, {-0.255, -0.027, -170},
    {-0.255, 0.027, 170},  {-0.237, 0.078, 150},   {-0.203, 0.119, 130},   {-0.157, 0.136, 90}};
constexpr int firing_order[8] = {0, 4, 1, 5, 2, 6, 3, 7}, half_cone_deg = 15;
constexpr double sonar_z_m = 0.2, nearest_m = 0.1, farthest_m = 5, firing_s = 0.02, echo_latency_s = 0.03;
constexpr double slack_s = 1e-9;  // 3 * 0.02 is not 0.06

std::string filled(std::string text, const json& values) {
  const json flat = values.flatten();
  for (const auto& [place, value] : flat.items())
    for (std::size_t at; (at = text.find("{" + place + "}")) != std::string::npos;)
      text.replace(at, place.size() + 2, value.is_string() ? value.get<std::string>() : value.dump());
  return text;
}

std::string mjcf_of(json scenario) {
  std::string obstacles;
  for (json thing : scenario.value("obstacles", json::array())) {
    const std::string type = thing.at("type");
    const double width_m = 2 * thing.value("radius_m", 0.0);
    if (type == "scatter") throw std::runtime_error("obstacles: scattered ones are not built here");
    if (type == "cylinder") thing["size"] = {{"x_m", width_m}, {"z_m", thing.at("height_m")}};
    if (type == "disc") thing["size"] = {{"x_m", 0.01}, {"y_m", width_m}, {"z_m", width_m}};  // as a plate
    for (json& side : thing.at("size")) side = side.get<double>() / 2;  // MuJoCo has halves and centres
    thing["z_m"] = thing.value("bottom_m", 0.0) + thing["size"]["z_m"].get<double>();
    thing.emplace("yaw_rad", 0.0);
    obstacles += filled(type == "cylinder" ? cylinder_mjcf : box_mjcf, thing);
  }
  scenario["obstacles"] = obstacles;
  for (const json& ball : scenario.at("balls"))
    if (ball.at("name") == scenario.at("target").at("ball")) scenario["ball"] = ball;
  json& ball = scenario["ball"];
  if (ball.at("motion").at("type") != "static")
    throw std::runtime_error("balls: moving ones are not built here");
  ball["radius_m"] = ball.at("diameter_m").get<double>() / 2;
  return filled(world_mjcf, scenario);
}

mjModel* model_of(const std::string& mjcf) {
  const auto files = std::make_unique<mjVFS>();  // in memory
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "world.xml", static_cast<int>(mjcf.size()));
  std::copy(mjcf.begin(), mjcf.end(), static_cast<char*>(files->filedata[0]));
  char error[1000] = "";
  mjModel* model = mj_loadXML("world.xml", files.get(), error, sizeof error);
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(std::string("MuJoCo refuses the world: ") + error);
  return model;
}

class Robot {
 public:
  explicit Robot(const json& scenario)
      : frame_period_s_(1 / scenario.at("camera").at("rate_hz").get<double>()),
        frame_latency_s_(scenario.at("camera").at("latency_s")),
        command_delay_s_(scenario.at("robot").at("actuation_delay_s")),
        m_(model_of(mjcf_of(scenario))),
        d_(mj_makeData(m_)),
        robot_(mj_name2id(m_, mjOBJ_BODY, "robot")),
        ball_(mj_name2id(m_, mjOBJ_GEOM, "ball")) {}

  Robot(const Robot&) = delete;
  ~Robot() { mj_deleteData(d_), mj_deleteModel(m_); }

  void command(const json& v_w) { told_.push_back({d_->time + command_delay_s_, v_w}); }

  json answer(double until_s) {
    while (d_->time < until_s - slack_s) tick();
    mj_forward(m_, d_);
    const double *p_WR = d_->xpos + 3 * robot_, *speed = d_->qvel;
    const json twist = {std::cos(yaw_rad()) * speed[0] + std::sin(yaw_rad()) * speed[1], speed[5]};
    return {{"ballservo_lockstep", 1},
            {"time_s", until_s},
            {"odometry", odometry_},
            {"twist", rolling()},
            {"sonars", arrived(heard_, until_s)},
            {"frames", arrived(seen_, until_s)},
            {"truth", {{"pose", {p_WR[0], p_WR[1], yaw_rad()}}, {"twist", twist}}}};
  }

 private:
  using Queue = std::deque<std::pair<double, json>>;  // when (s) what arrives

  static json arrived(Queue& queue, double until_s) {
    json messages = json::array();
    for (; !queue.empty() && queue.front().first <= until_s; queue.pop_front())
      messages.push_back(queue.front().second);
    return messages;
  }

  double yaw_rad() const { return std::atan2(d_->xmat[9 * robot_ + 3], d_->xmat[9 * robot_]); }

  // What the wheels say: v_mps, w_radps. In qvel they come after the robot's six.
  std::array<double, 2> rolling() const {
    const double left_mps = wheel_radius_m * d_->qvel[6], right_mps = wheel_radius_m * d_->qvel[7];
    return {(left_mps + right_mps) / 2, (right_mps - left_mps) / track_m};
  }

  void tick() {
    mj_step1(m_, d_);  // where all things are now
    if (d_->warning[mjWARN_BADQACC].number > 0) throw std::runtime_error("MuJoCo's simulation diverged");
    if (d_->time > frames_ * frame_period_s_ - slack_s) look();
    if (d_->time > firings_ * firing_s - slack_s) fire();
    for (const json& v_w : arrived(told_, d_->time + slack_s)) wanted_mps_ = v_w[0], wanted_radps_ = v_w[1];
    const double tick_s = m_->opt.timestep;
    v_mps_ += std::clamp(wanted_mps_ - v_mps_, -a_mps2 * tick_s, a_mps2 * tick_s);
    w_radps_ += std::clamp(wanted_radps_ - w_radps_, -alpha_radps2 * tick_s, alpha_radps2 * tick_s);
    d_->ctrl[0] = (v_mps_ - w_radps_ * track_m / 2) / wheel_radius_m;  // left, rad/s
    d_->ctrl[1] = (v_mps_ + w_radps_ * track_m / 2) / wheel_radius_m;  // right
    mj_step2(m_, d_);
    const auto [v_mps, w_radps] = rolling();
    odometry_[2] += w_radps * tick_s;
    odometry_[0] += v_mps * tick_s * std::cos(odometry_[2]);
    odometry_[1] += v_mps * tick_s * std::sin(odometry_[2]);
  }

  void look() {
    double p_CB_W[3], p_CB[3];
    mju_sub3(p_CB_W, d_->geom_xpos + 3 * ball_, d_->cam_xpos);
    mju_rotVecMatT(p_CB, p_CB_W, d_->cam_xmat);
    p_CB[1] *= -1, p_CB[2] *= -1;  // MuJoCo's cameras have y up and look along -z
    int first = -1;
    mj_ray(m_, d_, d_->cam_xpos, p_CB_W, nullptr, 1, robot_, &first);
    const bool seen = first == ball_ && p_CB[2] > 0.1 && std::abs(p_CB[0]) < tan_half_width * p_CB[2] &&
                      std::abs(p_CB[1]) < tan_half_height * p_CB[2];
    const double arrived_s = d_->time + frame_latency_s_;
    json ball;  // null: not seen
    const json covariance_m2 = {{1e-6, 0, 0}, {0, 1e-6, 0}, {0, 0, 1e-6}};
    if (seen) ball = {{"state", "confirmed"}, {"p_m", p_CB}, {"covariance_m2", covariance_m2}};
    json frame = {{"frame", frames_++}, {"time_s", d_->time}, {"arrived_s", arrived_s}, {"ball", ball}};
    seen_.push_back({arrived_s, std::move(frame)});
  }

  // The front and the rear array fire in turn. A cone is a fan of rays, each as a rangefinder's of MuJoCo.
  void fire() {
    const int turn = firings_++, k = 8 * (turn % 2) + firing_order[turn / 2 % 8];
    const auto& [x_m, y_m, heading_deg] = sonars[k];
    const double p_RS[3] = {x_m, y_m, sonar_z_m};
    double p_WS[3], range_m = farthest_m;
    mju_rotVecMat(p_WS, p_RS, d_->xmat + 9 * robot_);
    mju_addTo3(p_WS, d_->xpos + 3 * robot_);
    for (int aside_deg = -half_cone_deg; aside_deg <= half_cone_deg; ++aside_deg) {
      const double angle_rad = yaw_rad() + (heading_deg + aside_deg) * M_PI / 180;
      const double ray_W[3] = {std::cos(angle_rad), std::sin(angle_rad), 0};
      int geom = -1;
      const double along_m = mj_ray(m_, d_, p_WS, ray_W, nullptr, 1, robot_, &geom);
      if (along_m >= 0) range_m = std::min(range_m, along_m);  // -1: nothing there
    }
    const bool echo = range_m < farthest_m;
    range_m = std::max(range_m, nearest_m);
    json heard = {{"fired_s", d_->time}, {"transducer", k}, {"range_m", range_m}, {"echo", echo}};
    heard_.push_back({d_->time + echo_latency_s, std::move(heard)});
  }

  double frame_period_s_, frame_latency_s_, command_delay_s_;
  mjModel* m_;
  mjData* d_;
  int robot_, ball_, frames_ = 0, firings_ = 0;
  Queue told_, heard_, seen_;
  double wanted_mps_ = 0, wanted_radps_ = 0, v_mps_ = 0, w_radps_ = 0;  // as commanded; the set points
  double odometry_[3] = {0, 0, 0};                                      // x_m, y_m, yaw_rad: from the wheels
};

int main(int count, char** arguments) {
  const std::string address = std::string("tcp://127.0.0.1:") + (count > 1 ? arguments[1] : "5577");
  zmq::context_t context;
  zmq::socket_t line(context, zmq::socket_type::rep);
  try {
    line.bind(address);
    zmq::message_t message;
    for (std::unique_ptr<Robot> robot; line.recv(message);) {
      const json request = json::parse(message.to_string_view());
      if (request.contains("end")) {
        std::cout << request["end"].get<std::string>() << "\n";
        break;
      }
      if (!robot) robot = std::make_unique<Robot>(request.at("scenario"));
      robot->command(request.at("command"));
      line.send(zmq::buffer(robot->answer(request.at("until_s")).dump()));
    }
  } catch (const zmq::error_t& error) {
    std::cerr << "mujoco_robot: " << address << ": " << error.what() << "\n";
    return 1;
  } catch (const std::exception& error) {
    std::cerr << "mujoco_robot: " << error.what() << "\n";
    const json over = {{"outcome", "fault"}, {"text", error.what()}};
    line.send(zmq::buffer(json{{"ballservo_lockstep", 1}, {"over", over}}.dump()));
    return 1;
  }
}
