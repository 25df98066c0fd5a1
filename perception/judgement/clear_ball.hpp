// What a clear ball tells of the other things of its colour in its picture.
#pragma once

#include "perception/judgement/ball_shading.hpp"
#include "perception/judgement/second_look.hpp"

namespace ballservo {

/// How a supposed ball looks, without its outline's fit.
struct BallLooks {
  double radius_px = 0;
  SecondLook::Look look;
  BallShading shading;
};

/// So plainly a ball that others of its class can be compared with it.
bool is_clear_ball(const BallLooks& looks);

/// Why it is no ball, where another of its class is clear in the same picture; null where it may be one. The
/// light that shades one ball shades all: what is evenly bright beside it is flat. And specks are many where
/// second balls are few.
const char* reason_beside_clear_ball(const BallLooks& looks);

}  // namespace ballservo
