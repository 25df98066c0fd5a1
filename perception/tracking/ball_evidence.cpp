#include "perception/tracking/ball_evidence.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

// A look's log odds as log likelihood ratio of a ball and a look-alike: by logistic regression on 1614
// tracks, in films with and without balls, to which the quality and radius of the outline add nothing.
constexpr double ratio_per_log_odds = 0.35, most_log_ratio = 3;
constexpr double least_look_log_odds = -10, most_look_log_odds = 20;
// What moves so fast that it smears is seldom a look-alike.
constexpr double least_smeared_log_odds = 8;
// Of so many looks is the mean: a track that goes over to another thing is that thing.
constexpr int looks_kept = 20;
// What its looks speak against so much is no ball.
constexpr double least_log_ratio = -1.5;
// In a scene that is not known, so many look-alikes: of any size, and (px^3, over the radius cubed) the more
// the smaller. As much as so many pictures without any say against it.
constexpr double look_alikes_of_any_size = 0.15, look_alikes_px3 = 150, pictures_of_doubt = 10,
                 least_unknown = 0.3;
// A ball is there again in most pictures, noise in three of ten: per picture, and no more than so much. A
// picture without it says the contrary, with odds of 10 to 1 that there is none.
constexpr double again_ratio = 1.2, most_again = 3, refuted = -2.3;
// Odds of 80 to 1.
constexpr double enough = 4.4;
// A picture's weight when the next one comes: sixty are remembered.
constexpr double fades = 1 - 1.0 / 60;

}  // namespace

void BallEvidence::see(double radius_px, std::optional<double> log_odds, bool smeared) {
  if (pictures_++ > 0) again_ = std::min(again_ + again_ratio, most_again);
  radius_px_ = pictures_ == 1
                   ? radius_px
                   : radius_px_ * std::pow(radius_px / radius_px_, 1.0 / std::min(pictures_, looks_kept));
  if (log_odds) {
    looks_ = std::min(looks_ + 1, looks_kept);
    log_odds_ += (std::clamp(*log_odds, least_look_log_odds, most_look_log_odds) - log_odds_) / looks_;
  }
  if (smeared) log_odds_ = std::max(log_odds_, least_smeared_log_odds);
}

void BallEvidence::miss() { again_ -= again_ratio; }

bool BallEvidence::is_unlikely() const { return log_ratio_of_looks() < least_log_ratio; }

bool BallEvidence::is_refuted() const { return again_ < refuted; }

double BallEvidence::log_ratio_of_looks() const {
  return std::min(ratio_per_log_odds * (log_odds_ - even_log_odds), most_log_ratio);
}

double BallEvidence::usual_look_alikes() const {
  return look_alikes_of_any_size + look_alikes_px3 / std::pow(radius_px_, 3);
}

double BallEvidence::doubt() const {
  return usual_look_alikes() / (usual_look_alikes() + std::exp(log_ratio_of_looks()));
}

bool BallEvidence::suffices(double look_alikes) const {
  if (pictures_ < 3 || is_unlikely()) return false;
  const double unknown = std::max(pictures_of_doubt / (pictures_of_doubt + pictures_ - 3), least_unknown);
  return log_ratio_of_looks() - std::log(unknown * usual_look_alikes() + look_alikes) + again_ >= enough;
}

void LookAlikes::begin() {
  weights_ = fades * weights_ + 1;
  for (auto& sums : classes_)
    for (double& sum : sums) sum *= fades;
}

std::size_t LookAlikes::size_of(const BallEvidence& thing) {
  const double octave = std::log2(std::max(thing.radius_px(), 3.0) / 3);
  return static_cast<std::size_t>(std::min(octave, sizes - 1.0));
}

void LookAlikes::add(ClassIndex color_class, const BallEvidence& thing) {
  if (color_class == no_class || color_class > classes_.size()) return;
  classes_[color_class - 1u][size_of(thing)] += thing.doubt();
}

double LookAlikes::near(ClassIndex color_class, const BallEvidence& thing) const {
  if (color_class == no_class || color_class > classes_.size()) return 0;
  // What it was counted as itself, at every picture before this one.
  const double own = thing.doubt() * (1 - std::pow(fades, thing.pictures() - 1)) / (1 - fades);
  const double others = classes_[color_class - 1u][size_of(thing)] - own;
  return weights_ > 0 ? std::max(0.0, others / weights_) : 0;
}

}  // namespace ballservo
