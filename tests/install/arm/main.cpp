// An arm that looks at a ball: a Viper 850 with the camera in its hand keeps the ball on the camera's axis,
// 0.4 m away. ViSP's own: the arm's kinematics and the task. Ours: the feature.
#include <visp3/robot/vpViper850.h>
#include <visp3/vs/vpServo.h>

#include <Eigen/Core>
#include <cstdio>

#include "servo/features/ball_feature.hpp"

int main() {
  vpViper850 arm;
  vpColVector q(6);  // the joints (rad)
  const double start_rad[6] = {0.2, -1.2, 3.0, 0.3, 0.6, -0.2};
  for (unsigned int i = 0; i < 6; ++i) q[i] = start_rad[i];

  // The ball, in the arm's base frame: first seen half a metre away, to the side.
  const vpColVector p_fB = arm.get_fMc(q) * vpColVector({0.15, -0.1, 0.5, 1.0});
  const auto p_CB = [&] {
    const vpColVector p = arm.get_fMc(q).inverse() * p_fB;
    return Eigen::Vector3d(p[0], p[1], p[2]);
  };

  ballservo::ConeFeature seen, desired;
  seen.buildFrom(p_CB());
  desired.buildFrom({0, 0, 0.4});

  vpServo task;  // not vpServo(type): ViSP 3.5 leaves the threshold of the pseudo-inverse uninitialised there
  task.setServo(vpServo::EYEINHAND_L_cVe_eJe);
  task.setInteractionMatrixType(vpServo::CURRENT);
  task.setLambda(1.0);
  vpVelocityTwistMatrix cVe;
  arm.get_cVe(cVe);
  task.set_cVe(cVe);
  task.addFeature(seen, desired);

  const double period_s = 0.01;
  for (int step = 0; step <= 1000; ++step) {
    vpMatrix eJe;
    arm.get_eJe(q, eJe);
    task.set_eJe(eJe);
    seen.buildFrom(p_CB());
    const vpColVector joint_speeds = task.computeControlLaw();
    const vpColVector e = task.getError();
    if (step % 200 == 0)
      std::printf("%4.1f s: log range %+.6f, azimuth %+.6f rad, elevation %+.6f rad\n", step * period_s, e[0],
                  e[1], e[2]);
    q += joint_speeds * period_s;
  }
  const double left = task.getError().frobeniusNorm();
  task.kill();
  return left < 1e-3 ? 0 : 1;
}
