#include "app/scenario/scenario_robot.hpp"

namespace ballservo {

namespace {

void read_pose(YamlNode robot, Pose2& pose) {
  YamlNode node = robot.map("pose", false);
  const NumberRange place_m = NumberRange::within(-100, 100, "m");
  pose.x_m = node.number("x_m", place_m, 0.0);
  pose.y_m = node.number("y_m", place_m, 0.0);
  pose.yaw_rad = node.number("yaw_rad", NumberRange::within(-6.2832, 6.2832, "rad"), 0.0);
}

void read_limits(YamlNode robot, UnicycleLimits& limits) {
  YamlNode node = robot.map("limits", false);
  limits.v_max_mps = node.number("v_max_mps", {0, 10, true, false, "m/s"}, limits.v_max_mps);
  limits.w_max_radps = node.number("w_max_radps", {0, 20, true, false, "rad/s"}, limits.w_max_radps);
  limits.a_max_mps2 = node.number("a_max_mps2", {0, 20, true, false, "m/s^2"}, limits.a_max_mps2);
  limits.alpha_max_radps2 =
      node.number("alpha_max_radps2", {0, 100, true, false, "rad/s^2"}, limits.alpha_max_radps2);
}

OdometryOptions read_odometry(YamlNode robot) {
  YamlNode node = robot.map("odometry", false);
  OdometryOptions odometry;
  const NumberRange share = NumberRange::within(0, 0.2, "");
  odometry.bound.distance_share = node.number("distance_share", share, 0.0);
  odometry.bound.turn_share = node.number("turn_share", share, 0.0);
  odometry.bound.turn_per_m_radpm =
      node.number("turn_per_m_radpm", NumberRange::within(0, 0.2, "rad/m"), 0.0);
  odometry.excess = node.number("excess", NumberRange::within(0, 100, ""), odometry.excess);
  return odometry;
}

SonarOptions read_sonar(YamlNode node) {
  SonarOptions sonar;
  sonar.beam.min_range_m = node.number("min_range_m", {0, 1, true, false, "m"}, sonar.beam.min_range_m);
  sonar.beam.max_range_m =
      node.number("max_range_m", NumberRange::within(1, 10, "m"), sonar.beam.max_range_m);
  sonar.beam.half_angle_rad =
      node.number("half_angle_rad", {0.02, 0.7, false, false, "rad"}, sonar.beam.half_angle_rad);
  sonar.height_m = node.number("height_m", {0, 0.4, true, false, "m"}, sonar.height_m);
  sonar.period_s = node.number("period_s", {0.005, 1, false, false, "s"}, sonar.period_s);
  sonar.latency_s = node.number("latency_s", NumberRange::within(0, 1, "s"), sonar.latency_s);
  sonar.noise_sigma_m = node.number("noise_sigma_m", NumberRange::within(0, 0.2, "m"), sonar.noise_sigma_m);
  const NumberRange rate = NumberRange::within(0, 1, "");
  sonar.dropout_rate = node.number("dropout_rate", rate, sonar.dropout_rate);
  sonar.crosstalk_rate = node.number("crosstalk_rate", rate, sonar.crosstalk_rate);
  sonar.specular_limit_rad =
      node.number("specular_limit_rad", {0, 1.5708, true, false, "rad"}, sonar.specular_limit_rad);
  return sonar;
}

void read_fault(YamlNode node, std::vector<SonarFault>& faults) {
  using Kind = SonarFault::Kind;
  std::vector<std::string> names;
  for (const Kind kind : {Kind::dead, Kind::stuck, Kind::reads_long, Kind::late}) {
    names.emplace_back(sonar_fault_name(kind));
  }
  const std::string type = node.choice("type", names);
  SonarFault fault;
  for (const Kind kind : {Kind::dead, Kind::stuck, Kind::reads_long, Kind::late}) {
    if (sonar_fault_name(kind) == type) fault.kind = kind;
  }
  fault.from_s = node.number("from_s", NumberRange::within(0, 3600, "s"), 0.0);
  if (fault.kind == Kind::reads_long) fault.amount = node.number("by_m", {0, 5, true, false, "m"});
  if (fault.kind == Kind::late) fault.amount = node.number("by_s", {0, 10, true, false, "s"});
  if (node.has("array")) {
    if (node.has("sonar")) node.fault("array", "both sonar and array", "one of them");
    const std::size_t first = node.choice("array", {"front", "rear"}) == "rear" ? 8 : 0;
    for (fault.transducer = first; fault.transducer < first + 8; ++fault.transducer) faults.push_back(fault);
    return;
  }
  fault.transducer = static_cast<std::size_t>(node.integer("sonar", 0, sonar_count - 1));
  faults.push_back(fault);
}

}  // namespace

bool read_robot(StrictYaml& yaml, RobotSettings& robot) {
  const std::size_t before = yaml.faults().faults().size();
  YamlNode root = yaml.root();
  YamlNode node = root.map("robot");
  node.choice("type", {"pioneer_3dx"}, "pioneer_3dx");
  read_pose(node, robot.pose);
  robot.actuation_delay_s = node.number("actuation_delay_s", NumberRange::within(0, 2, "s"), 0.05);
  read_limits(node, robot.limits);
  robot.acceleration_share = node.number("acceleration_share", NumberRange::within(0.01, 10, ""), 1.0);
  robot.odometry = read_odometry(node);
  if (node.has("sonar")) robot.sonar = read_sonar(node.map("sonar"));
  for (YamlNode& fault : node.list("faults")) read_fault(fault, robot.sonar_faults);
  if (!robot.sonar_faults.empty() && !robot.sonar) {
    node.fault("faults", "faults of sonars that the robot has not", "robot.sonar beside it");
  }
  return yaml.faults().faults().size() == before;
}

AvoidanceOptions read_avoidance(StrictYaml& yaml, const RobotSettings& robot) {
  using Type = AvoidanceOptions::Type;
  AvoidanceOptions avoidance;
  YamlNode node = yaml.root().map("avoidance", false);
  const std::vector<Type> types{Type::none, Type::shield, Type::full};
  std::vector<std::string> names;
  for (const Type type : types) names.emplace_back(avoidance_type_name(type));
  const std::string name =
      node.choice("type", names, std::string(avoidance_type_name(robot.sonar ? Type::full : Type::none)));
  for (const Type type : types) {
    if (avoidance_type_name(type) == name) avoidance.type = type;
  }
  if (avoidance.type != Type::none && !robot.sonar) {
    node.fault("type", name + ", for a robot without sonars", "none, or robot.sonar beside it");
  }
  avoidance.creep = node.boolean("creep", avoidance.creep);
  avoidance.floor = node.boolean("floor", avoidance.floor);
  OccupancyGridOptions& grid = avoidance.grid;
  grid.start_clear_m = node.number("start_clear_m", NumberRange::within(0, 3, "m"), grid.start_clear_m);
  grid.memory_s = node.number("memory_s", {0, 600, true, false, "s"}, grid.memory_s);
  grid.drift_allowed_m = node.number("drift_allowed_m", {0, 0.5, true, false, "m"}, grid.drift_allowed_m);
  grid.look_range_m = node.number("look_range_m", NumberRange::within(0.5, 3, "m"), grid.look_range_m);
  grid.footprint = robot.footprint;
  grid.odometry = robot.odometry.bound;
  if (robot.sonar) {
    grid.beam = robot.sonar->beam;
    grid.range_error_m = robot.sonar->noise_bound_m() + 0.01;
  }
  return avoidance;
}

}  // namespace ballservo
