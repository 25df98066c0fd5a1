// Whether what was seen again and again is a ball: a sequential likelihood ratio test (Wald 1945) against the
// look-alikes that this scene shows.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "perception/ball_observation.hpp"

namespace ballservo {

/// What the pictures said of one track.
class BallEvidence {
 public:
  /// `log_odds` of a second look at it (see Detector::log_odds), where there was one. What its motion smears
  /// speaks not against it.
  void see(double radius_px, std::optional<double> log_odds, bool smeared = false);
  void miss();  ///< it was not in this picture

  /// Whether it is believed, `look_alikes` being the number of others of its class and size that were in a
  /// picture of late. That it stays tells a thing from noise, not a ball from a leaf: this counts for no more
  /// than a few pictures. Its looks do not add up from picture to picture: they are one thing's.
  bool suffices(double look_alikes) const;

  /// Its looks speak so much against a ball that it is none until more pictures say otherwise.
  bool is_unlikely() const;

  /// Missed too often for a ball.
  bool is_refuted() const;

  int pictures() const { return pictures_; }
  double radius_px() const { return radius_px_; }  ///< geometric mean
  /// Probability that it is none, by its looks and size alone.
  double doubt() const;

 private:
  double log_ratio_of_looks() const;
  double usual_look_alikes() const;

  static constexpr double even_log_odds = 6.5;

  int pictures_ = 0, looks_ = 0;
  double again_ = 0;  // log likelihood ratio of a ball and noise, by its coming again
  double radius_px_ = 0, log_odds_ = even_log_odds;  // means
};

/// How many things a picture showed, in the mean of the last few, that were like a ball and not believed.
class LookAlikes {
 public:
  explicit LookAlikes(std::size_t classes) : classes_(classes) {}

  void begin();  ///< before the things of another picture
  void add(ClassIndex color_class, const BallEvidence& thing);
  /// Of that size; the thing itself not counted.
  double near(ClassIndex color_class, const BallEvidence& thing) const;

 private:
  static constexpr int sizes = 6;  // each twice the one before
  static std::size_t size_of(const BallEvidence& thing);
  std::vector<std::array<double, sizes>> classes_;  // sums of weights that fade
  double weights_ = 0;                              // of all pictures
};

}  // namespace ballservo
