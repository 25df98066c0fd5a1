// MRPT's reactive navigation as a controller of our simulated robot, in lockstep: what a robot does among
// obstacles that drives by other people's planner. peers_in_hard_worlds.py runs it world by world.
//
//     ballservo servo data/scenarios/poles.yaml -o run --perception geometric --deadline 60 --serve
//     tcp://127.0.0.1:5577 & build/release/tests/bench/mrpt_controller 5577
//
// The navigator chooses among families of arcs by how far each is free and how near it comes to the goal
// (Blanco, Gonzalez and Fernandez-Madrigal, Autonomous Robots 24, 2008). It is sent to the place from which
// the ball is seen as the goal says; near it a law on range and bearing goes on. Where no ball is seen for
// long, the robot turns once around and drives somewhere, and so on.
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/core/Clock.h>
#include <mrpt/kinematics/CVehicleVelCmd_DiffDriven.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/nav/holonomic/CHolonomicFullEval.h>
#include <mrpt/nav/reactive/CReactiveNavigationSystem.h>
#include <mrpt/nav/reactive/CRobot2NavInterface.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <zmq.hpp>

using mrpt::kinematics::CVehicleVelCmd;
using mrpt::math::TPoint2D;
using mrpt::math::TPose2D;
using nlohmann::json;
using Navigator = mrpt::nav::CReactiveNavigationSystem;

namespace {

// Chosen by seeds 1 to 10 of three worlds: faster, it collides, as it brakes as if at once; with a longer
// memory of echoes it drives through no corridor.
constexpr double cruise_mps = 0.4, remembered_s = 3;
constexpr double turning_radps = 1, reach_m = 4;    // of the arcs
constexpr double docking_m = 0.5;                   // the way left from which on the law drives
constexpr double forgotten_s = 1, patience_s = 20;  // without the ball: the law gives up; the navigator does
constexpr double searching_radps = 0.5, round_s = 14, ramble_m = 2, ramble_s = 10;
constexpr double arrival_m = 0.1;

/// MRPT's own parameters but for what is written here.
mrpt::config::CConfigFileMemory parameters() {
  mrpt::config::CConfigFileMemory ini;
  constexpr double turning_degps = turning_radps * 180 / M_PI;
  mrpt::nav::CHolonomicFullEval().options.saveToConfigFile(ini, "CHolonomicFullEval");
  ini.write("CAbstractNavigator", "alarm_seems_not_approaching_target_timeout", 1e9);
  const std::string navigator = "CAbstractPTGBasedReactive";
  ini.write(navigator, "robotMax_V_mps", cruise_mps);
  ini.write(navigator, "robotMax_W_degps", turning_degps);
  ini.write(navigator, "holonomic_method", "CHolonomicFullEval");
  ini.write(navigator, "motion_decider_method", "CMultiObjMotionOpt_Scalarization");
  ini.write(navigator, "ref_distance", reach_m);
  ini.write(navigator, "enable_obstacle_filtering", false);
  const std::string scores = "CMultiObjectiveMotionOptimizerBase";
  ini.write(scores, "score1_name", "free");
  ini.write(scores, "score1_formula", "collision_free_distance");
  ini.write(scores, "score2_name", "near");
  ini.write(scores, "score2_formula", "(ref_dist - dist_eucl_final) / ref_dist");
  ini.write(scores, "score3_name", "steady");
  ini.write(scores, "score3_formula", "hysteresis");
  ini.write(scores, "score4_name", "priority");
  ini.write(scores, "score4_formula", "ptg_priority");
  ini.write("CMultiObjMotionOpt_Scalarization", "scalar_score_formula",
            "priority * (0.5 * free + 2 * near + 0.1 * steady)");
  const std::string robot = "CReactiveNavigationSystem";
  ini.write(robot, "min_obstacles_height", 0);
  ini.write(robot, "max_obstacles_height", 1);
  ini.write(robot, "RobotModel_shape2D_xs", "0.21 0.21 -0.301 -0.301");  // a Pioneer 3-DX
  ini.write(robot, "RobotModel_shape2D_ys", "0.2125 -0.2125 -0.2125 0.2125");
  const auto arcs = [&](const std::string& name, const std::string& type, double priority) {
    ini.write(robot, name + "_Type", type);
    ini.write(robot, name + "_score_priority", priority);
    ini.write(robot, name + "_resolution", 0.05);
    ini.write(robot, name + "_refDistance", reach_m);
    ini.write(robot, name + "_num_paths", 121);
    ini.write(robot, name + "_v_max_mps", cruise_mps);
    ini.write(robot, name + "_w_max_dps", turning_degps);
  };
  ini.write(robot, "PTG_COUNT", 3);
  arcs("PTG0", "CPTG_DiffDrive_C", 1);
  ini.write(robot, "PTG0_K", 1);
  arcs("PTG1", "CPTG_DiffDrive_alpha", 1);
  ini.write(robot, "PTG1_cte_a0v_deg", 57);
  ini.write(robot, "PTG1_cte_a0w_deg", 57);
  arcs("PTG2", "CPTG_DiffDrive_C", 0.5);
  ini.write(robot, "PTG2_K", -1);        // backwards
  mrpt::config::CConfigFileMemory read;  // what was written can only be read from the text
  read.setContent(ini.getContent());
  return read;
}

/// What the navigator knows of the robot, in the frame O of its odometry, and what it commands.
class LockstepRobot final : public mrpt::nav::CRobot2NavInterface {
 public:
  TPose2D pose;
  double v_mps = 0, w_radps = 0, time_s = 0;
  double command_v_mps = 0, command_w_radps = 0;

  void hear(const json& reading, const json& mount) {
    if (!reading.at("echo")) return;
    const double heading_rad = mount[2], range_m = reading.at("range_m");
    const TPoint2D p_R(mount[0].get<double>() + range_m * std::cos(heading_rad),
                       mount[1].get<double>() + range_m * std::sin(heading_rad));
    echoes_.push_back({time_s, pose.composePoint(p_R)});
    while (echoes_.front().heard_s < time_s - remembered_s) echoes_.pop_front();
  }

  bool getCurrentPoseAndSpeeds(TPose2D& pose_now, mrpt::math::TTwist2D& twist,
                               mrpt::system::TTimeStamp& stamp, TPose2D& odometry, std::string&) override {
    pose_now = odometry = pose;
    twist = {v_mps * std::cos(pose.phi), v_mps * std::sin(pose.phi), w_radps};
    stamp = mrpt::Clock::fromDouble(time_s);
    return true;
  }
  bool changeSpeeds(const CVehicleVelCmd& wanted) override {
    command_v_mps = wanted.getVelCmdElement(0);
    command_w_radps = wanted.getVelCmdElement(1);
    return true;
  }
  bool stop(bool) override {
    command_v_mps = command_w_radps = 0;
    return true;
  }
  CVehicleVelCmd::Ptr getEmergencyStopCmd() override { return getStopCmd(); }
  CVehicleVelCmd::Ptr getStopCmd() override { return mrpt::kinematics::CVehicleVelCmd_DiffDriven::Create(); }
  bool senseObstacles(mrpt::maps::CSimplePointsMap& obstacles, mrpt::system::TTimeStamp& stamp) override {
    obstacles.clear();
    for (const Echo& echo : echoes_) {
      const TPoint2D p_R = pose.inverseComposePoint(echo.p_O);
      obstacles.insertPoint(static_cast<float>(p_R.x), static_cast<float>(p_R.y), 0.2f);
    }
    stamp = mrpt::Clock::fromDouble(time_s);
    return true;
  }
  double getNavigationTime() override { return time_s; }
  void resetNavigationTimer() override {}

 private:
  struct Echo {
    double heard_s;
    TPoint2D p_O;
  };
  std::deque<Echo> echoes_;
};

class BallSeeker {
 public:
  /// `facts`: what the robot says of itself (app/peer/README.md).
  explicit BallSeeker(const json& facts) : facts_(facts), navigator_(robot_, false) {
    navigator_.setMinLoggingLevel(mrpt::system::LVL_ERROR);
    robot_.setMinLoggingLevel(mrpt::system::LVL_ERROR);
    navigator_.loadConfigFile(parameters());
    navigator_.initialize();
  }

  /// The command, v_mps and w_radps, on the robot's answer.
  json step(const json& answer) {
    const json& odometry = answer.at("odometry");
    robot_.pose = {odometry[0], odometry[1], odometry[2]};
    robot_.v_mps = answer.at("twist")[0];
    robot_.w_radps = answer.at("twist")[1];
    robot_.time_s = answer.at("time_s");
    mrpt::Clock::setSimulatedTime(mrpt::Clock::fromDouble(robot_.time_s));
    mrpt::Clock::setActiveClock(mrpt::Clock::Source::Simulated);
    for (const json& reading : answer.at("sonars"))
      robot_.hear(reading, facts_.at("sonars").at(reading.at("transducer").get<std::size_t>()));
    for (const json& frame : answer.at("frames"))
      if (!frame.at("ball").is_null()) see(frame["ball"].at("p_m"));

    if (!ball_O_ || robot_.time_s - seen_s_ > patience_s) {
      search();
    } else {
      search_began_s_ = robot_.time_s;
      approach(robot_.pose.inverseComposePoint(*ball_O_));
    }
    return {robot_.command_v_mps, robot_.command_w_radps};
  }

 private:
  void see(const json& p_C) {
    const auto along = [&](const json& row) {
      double sum = row[3];
      for (std::size_t k = 0; k < 3; ++k) sum += row[k].get<double>() * p_C[k].get<double>();
      return sum;
    };
    const json& X_RC = facts_.at("X_RC");
    ball_O_ = robot_.pose.composePoint(TPoint2D(along(X_RC[0]), along(X_RC[1])));  // as if seen just now
    seen_s_ = robot_.time_s;
  }

  void approach(const TPoint2D& ball_R) {
    const double range_m = ball_R.norm(), left_m = range_m - facts_.at("distance_m").get<double>();
    if (left_m > docking_m) return navigate(robot_.pose.composePoint(ball_R * (left_m / range_m)));
    if (robot_.time_s - seen_s_ > forgotten_s) return turn();
    rest();
    const double braking_mps = std::sqrt(facts_.at("a_max_mps2").get<double>() * std::abs(left_m));
    robot_.command_v_mps = std::copysign(std::min({std::abs(left_m), braking_mps, cruise_mps}), left_m);
    robot_.command_w_radps = 1.5 * std::atan2(ball_R.y, ball_R.x);
  }

  void search() {
    if (robot_.time_s - search_began_s_ > round_s + ramble_s) search_began_s_ = robot_.time_s;
    if (robot_.time_s - search_began_s_ < round_s) {
      const double heading_rad = std::uniform_real_distribution<double>(-M_PI, M_PI)(chance_);
      somewhere_O_ =
          robot_.pose.composePoint({ramble_m * std::cos(heading_rad), ramble_m * std::sin(heading_rad)});
      turn();
    } else {
      navigate(somewhere_O_);
    }
  }

  void turn() {
    rest();
    robot_.command_w_radps = searching_radps;
  }

  void rest() {
    if (navigator_.getCurrentState() == Navigator::NAVIGATING) navigator_.cancel();
    robot_.stop(false);
  }

  void navigate(const TPoint2D& goal_O) {
    if (navigator_.getCurrentState() != Navigator::NAVIGATING || (goal_O - sent_O_).norm() > arrival_m) {
      Navigator::TNavigationParamsPTG way;
      way.target.target_coords = {goal_O.x, goal_O.y, 0};
      way.target.targetAllowedDistance = arrival_m;
      way.target.targetDesiredRelSpeed = 0.3;
      navigator_.navigate(&way);
      sent_O_ = goal_O;
    }
    navigator_.navigationStep();
  }

  json facts_;
  LockstepRobot robot_;
  Navigator navigator_;
  std::optional<TPoint2D> ball_O_;
  TPoint2D sent_O_, somewhere_O_;
  double seen_s_ = 0, search_began_s_ = 0;
  std::mt19937 chance_;
};

}  // namespace

int main(int argc, char** argv) {
  zmq::context_t context;
  zmq::socket_t line(context, zmq::socket_type::req);
  line.set(zmq::sockopt::rcvtimeo, 30000);  // ms
  line.set(zmq::sockopt::linger, 0);
  line.connect(std::string("tcp://127.0.0.1:") + (argc > 1 ? argv[1] : "5577"));

  std::optional<BallSeeker> seeker;
  double rate_hz = 1;
  json command{0, 0};
  for (long step = 0;; ++step) {
    const json request{
        {"ballservo_lockstep", 1}, {"until_s", static_cast<double>(step) / rate_hz}, {"command", command}};
    line.send(zmq::buffer(request.dump()));
    zmq::message_t part;
    if (!line.recv(part)) {
      std::cerr << "the robot is silent\n";
      return 1;
    }
    const json answer = json::parse(part.to_string_view());
    if (answer.contains("over")) {
      std::cout << answer["over"]["text"].get<std::string>() << "\n";
      return answer["over"]["outcome"] == "reached" ? 0 : 1;
    }
    if (!seeker) {
      seeker.emplace(answer.at("robot"));
      rate_hz = answer["robot"].at("rate_hz");
    }
    command = seeker->step(answer);
  }
}
