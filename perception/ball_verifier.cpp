#include "perception/ball_verifier.hpp"

#include <algorithm>
#include <utility>

#include "perception/outline/paper_refinement.hpp"

namespace ballservo {
namespace {

// A region may be less than its ball unless so good a ball was found in it, if it is so large and so full:
// then there may be an outline around it, with an edge on so much of it, its radius larger by up to a part of
// the circle's.
constexpr double sure_quality = 0.7, min_frayed_radius_px = 8, min_frayed_fill = 0.6;
constexpr double min_frayed_edge = 0.37, frayed_reach = 0.6;
constexpr double surer_by = 5;  // log odds of a second look, whatever the outlines say

// A small ball is looked at again, since some circle fits into a few pixels of anything; and is none where
// the odds are worse than e^3 and what its size asks beyond. A larger one shows its shape in its outline,
// unless that is doubtful and nothing else says that a ball is there: then that it is one must be likelier
// than not, and the more so the more of its edge leaves the outline or runs straight. Of 1151 doubtful balls
// one is below that, of 49 other things half. A streak, which is no circle, shows its shape there alone.
constexpr double least_small_log_odds = 3;
constexpr double least_log_odds_if_not_round = 20;

// Half a disc passes for a half-hidden ball. Where neither the class nor the second look sees most of the
// disc, the second look must be so much surer. The circle that it sees lies off the fitted one by about so
// much (radii); further off, it speaks of another thing.
constexpr double half_hidden = 0.4, half_filled = 0.7, half_log_odds = 4, off_sigma = 0.15;

// A lens may depart from the one that was stated, so that balls are ovals by about so much. That it does is
// believed where it makes a doubtful ball so much clearer, and a second look is sure of that ball; but what
// is more of an oval than this (radii) is one through any lens.
constexpr double lens_oval_fraction = 0.004, clearer_by = 0.1, most_lens_oval = 0.045;
// An outline that is more of an oval (radii) does not speak for itself, whatever the lens.
constexpr double most_sure_oval = 0.02;

// What is a ball by a second look: its odds, and how far it may lie off the circle that is seen (radii),
// where the second look speaks for it alone and where it is half hidden; how much of its outline has an edge;
// its size in pixels and as a part of the picture's shorter side; and how much of its disc has the colour.
constexpr double least_log_odds_alone = 4, most_off_alone = 0.12, most_off_half = 0.5;
constexpr double least_thorough_arc = 0.2, least_half_px = 8, most_thorough_side = 0.25;
constexpr double least_thorough_fill = 0.25, least_half_fill = 0.15;
// Less suffices of one that is shaded and shows most of its rim, where the picture has hardly any of its
// colour elsewhere.
constexpr double nowhere_else = 0.9, least_shaded_alone = 0.5, least_log_odds_nowhere_else = 1.5;
// The outline of a small ball says little, its pixels nearly as much as ever: less is asked of them, but the
// more the smaller it is. Its place is sure to about a pixel.
constexpr double least_thorough_px = 3.5, least_small_alone = 3.5, most_off_px = 1.2;
constexpr double elsewhere = 0.2;  // radii: a circle so far off is another one

constexpr const char* no_edge = "no edge along the circle";
constexpr const char* disc_aslant = "flat and an oval, as a disc seen aslant";

// How far the circle that a second look sees, if any, lies off the outline, radii.
double radii_off(const SecondLook::Look& look, const OutlineEllipse& outline) {
  if (!(look.seen.radius_px > 0)) return 0;
  return std::max((look.seen.center_px - outline.center_px).norm(),
                  std::abs(look.seen.radius_px - outline.radius_px)) /
         outline.radius_px;
}

// Of what is half hidden nothing is said: it shows too little of a shading.
bool is_flat(const SecondLook::Look& look) {
  constexpr double least_shaded = 0.22;
  return look.seen.sphere() < least_shaded && look.seen.filled >= half_filled;
}

// Asked only where nothing says that a ball is there, and of a large thing: a small ball's few edges may show
// an oval by chance, its few pixels no shading.
bool is_disc_aslant(const ClassView& view, const SecondLook::Look& look, const OutlineFit& fit) {
  return view.prior.anywhere && fit.ball.outline.radius_px >= small_ball_px && fit.oval > most_sure_oval &&
         is_flat(look);
}

void forget(VerifiedCandidate& candidate) {
  candidate.is_fitted = false;
  candidate.fit.clear();
  candidate.verdict = {};
  candidate.log_odds = 0;
}

}  // namespace

VotedCircle::VotedCircle(const CircleEstimate& voted, double focal_px)
    : estimate(voted), cone(cone_near_circle(voted, focal_px)) {}

BallObservation VerifiedCandidate::observation(ClassIndex color_class,
                                               const std::optional<CircleEstimate>& vote) const {
  return {fit.ball, color_class, vote, verdict.support, verdict.quality};
}

BallVerifier::BallVerifier(std::shared_ptr<const RayTable> rays, const DetectorOptions& options)
    : rays_(std::move(rays)),
      options_(options),
      fitter_(rays_, options.oval_fraction),
      oval_fitter_(rays_, lens_oval_fraction) {
  scouted_.points.reserve(most_outline_sectors);
}

const VerifiedCandidate& BallVerifier::verify(const ClassView& view, const VotedCircle& circle,
                                              const std::vector<BoundaryPoint>& points, bool inside_region) {
  VerifiedCandidate& candidate = voted_;
  Verdict& verdict = candidate.verdict;
  forget(candidate);
  if (circle.estimate.radius_px < min_ball_radius_px) {
    verdict.reason = "too small";
  } else if (!circle.cone) {
    verdict.reason = "no ball makes this circle";
  } else {
    const TangentCone rough = rough_cone(circle, points);
    verdict = judge(view).early(points, rough);
    if (!candidate.is_ball() && !inside_region) return candidate;
    fit_and_judge(view, points, candidate, [&](BallFitter& fitter, OutlineFit& fit) {
      return options_.fit == BallFit::sphere
                 ? fit_sphere(fitter, view.bgr, view.response, circle, rough, points, radius(view), fit)
                 : fitter.fit_circle(view.bgr, circle.estimate, radius(view), fit);
    });
  }
  return looked_at_again(view, candidate);
}

// Through the stated lens and, where that leaves it doubtful, as an oval.
template <typename FitBy>
void BallVerifier::fit_and_judge(const ClassView& view, const std::vector<BoundaryPoint>& points,
                                 VerifiedCandidate& candidate, const FitBy& fit_by) {
  candidate.is_fitted = fit_by(fitter_, candidate.fit);
  if (candidate.is_fitted)
    candidate.verdict = judge(view).of(candidate.fit, points);
  else
    candidate.verdict.reason = no_edge;
  if (options_.fit != BallFit::sphere || options_.oval_fraction > 0 || !candidate.is_ball() ||
      candidate.verdict.quality >= doubtful_quality)
    return;
  forget(oval_);
  oval_.is_fitted = fit_by(oval_fitter_, oval_.fit);
  if (!oval_.is_fitted) return;
  oval_.verdict = judge(view).of(oval_.fit, {});
  if (!oval_.is_ball() || oval_.verdict.quality < candidate.verdict.quality + clearer_by ||
      oval_.fit.ball.residual_px > candidate.fit.ball.residual_px)
    return;
  const SecondLook::Look look = second_look_.look(view.bgr, view.colored, oval_.fit.ball.outline);
  if (is_disc_aslant(view, look, oval_.fit))
    candidate.verdict.reason = disc_aslant;
  else if (look.log_odds >= least_small_log_odds && oval_.fit.oval <= most_lens_oval)
    std::swap(candidate, oval_);
}

// Where a ball is expected, less suffices, and nothing is looked at again.
const VerifiedCandidate& BallVerifier::looked_at_again(const ClassView& view, VerifiedCandidate& candidate) {
  if (view.prior.thorough && is_seen_ball(view, candidate)) {
    candidate.verdict.reason = nullptr;
    candidate.verdict.quality = std::max(candidate.verdict.quality, min_ball_quality);
    return candidate;
  }
  if (!candidate.is_ball() || view.prior.min_quality < min_ball_quality) return candidate;
  const OutlineEllipse& outline = candidate.fit.ball.outline;
  const bool small = outline.radius_px < small_ball_px;
  const bool doubtful = small || (view.prior.anywhere && (candidate.verdict.quality < doubtful_quality ||
                                                          candidate.fit.oval > most_sure_oval));
  if (!doubtful) return candidate;
  const SecondLook::Look look = second_look_.look(view.bgr, view.colored, outline);
  candidate.log_odds = look.log_odds;
  if (!small && fit_seen(view, look, candidate)) return candidate;
  const bool half = candidate.verdict.support.hidden > half_hidden && look.seen.filled < half_filled;
  const double least =
      small ? least_small_log_odds + log_look_alikes_by_size(outline.radius_px)
            : std::max(half ? half_log_odds : 0,
                       least_log_odds_if_not_round * (1 - candidate.verdict.support.shape.roundness()));
  const double off = small ? 0 : radii_off(look, outline) / off_sigma;
  if (is_disc_aslant(view, look, candidate.fit))
    candidate.verdict.reason = disc_aslant;
  else if (look.log_odds - 0.5 * off * off < least + view.prior.log_look_alikes)
    candidate.verdict.reason = "contour and shading are no ball's";
  return candidate;
}

// The outline of a ball's lit part, or of a seam on it, is no ball's. Where the second look surely sees a
// circle elsewhere, the ball is sought there.
bool BallVerifier::fit_seen(const ClassView& view, const SecondLook::Look& look,
                            VerifiedCandidate& candidate) {
  const FittedBall& fitted = candidate.fit.ball;
  if (look.log_odds < least_log_odds_alone || radii_off(look, fitted.outline) < elsewhere) return false;
  const auto axis = rays_->camera().unproject(look.seen.center_px);
  if (!axis) return false;
  const double alpha_rad = fitted.cone.alpha_rad * look.seen.radius_px / fitted.outline.radius_px;
  fit_near(view, {axis->normalized(), alpha_rad}, most_off_alone * look.seen.radius_px, min_frayed_edge,
           seen_);
  if (!seen_.is_fitted || radii_off(look, seen_.fit.ball.outline) > elsewhere) return false;
  if (!seen_.is_ball() && !is_seen_ball(view, seen_)) return false;
  seen_.verdict.reason = nullptr;
  seen_.log_odds = look.log_odds;
  std::swap(candidate, seen_);
  return true;
}

// A seam or a sheet across a ball, a skin that is not quite round: the outline says too little, where
// contour, shading and colour together leave no doubt.
bool BallVerifier::is_seen_ball(const ClassView& view, const VerifiedCandidate& candidate) {
  const OutlineEllipse& outline = candidate.fit.ball.outline;
  const OutlineSupport& support = candidate.verdict.support;
  const double most_px = most_thorough_side * std::min(view.bgr.cols, view.bgr.rows);
  const bool half = support.hidden > half_hidden;
  if (!candidate.is_fitted || outline.radius_px < least_thorough_px || outline.radius_px > most_px ||
      support.fill < (half ? least_half_fill : least_thorough_fill) || support.arc < least_thorough_arc ||
      support.leak > max_leak)
    return false;
  const SecondLook::Look look = second_look_.look(view.bgr, view.colored, outline);
  if (is_flat(look)) return false;
  const double off = radii_off(look, outline);
  const bool small = outline.radius_px < small_ball_px;
  const bool is_alone = view.prior.anywhere && view.prior.share >= nowhere_else && !half &&
                        look.seen.sphere() >= least_shaded_alone;
  const double least = small      ? least_small_alone + log_look_alikes_by_size(outline.radius_px) / 3
                       : is_alone ? least_log_odds_nowhere_else
                                  : least_log_odds_alone;
  const double most_off = std::max(most_off_alone, most_off_px / outline.radius_px);
  if (look.log_odds - view.prior.log_look_alikes >= least && off < most_off) return true;
  return half && outline.radius_px >= least_half_px && off < most_off_half &&
         judge(view).half_hidden_log_odds(candidate.fit, support, look) >= 0;
}

bool BallVerifier::fit_sphere(BallFitter& fitter, const cv::Mat& bgr, const CameraResponse& response,
                              const VotedCircle& circle, const TangentCone& rough,
                              const std::vector<BoundaryPoint>& points, const BallRadius& radius,
                              OutlineFit& fit) {
  const TangentCone start =
      boundary_cone_.robust(rough, points, rays_->camera().focal_px(), fitter.oval_fraction())
          .value_or(*circle.cone);
  if (!fitter.fit_sphere(bgr, response, start, radius, fit)) return false;
  fit.ball.start = circle.estimate;
  return true;
}

const VerifiedCandidate& BallVerifier::verify_frayed(const ClassView& view, const VotedCircle& circle,
                                                     const std::vector<BoundaryPoint>& points,
                                                     const std::vector<BoundaryPoint>& region) {
  const VerifiedCandidate& voted = verify(view, circle, points);
  const double radius_px = circle.estimate.radius_px;
  const bool is_sure = voted.is_ball() && voted.verdict.quality >= sure_quality;
  if (is_sure || options_.fit != BallFit::sphere || !circle.cone || radius_px < min_frayed_radius_px ||
      voted.verdict.support.fill < min_frayed_fill)
    return voted;
  fit_near(view, *circle.cone, frayed_reach * radius_px, min_frayed_edge, around_);
  Verdict& around = around_.verdict;
  if (!around_.is_ball() && around_.is_fitted && judge(view).encloses(region, around_.fit, around.support)) {
    around.reason = nullptr;
    around.quality = std::max(around.quality, share_on_outline(around_.fit));
  }
  const bool says_more = around_.is_ball() && !(voted.is_ball() && around.quality <= voted.verdict.quality);
  if (!says_more) return voted;
  const VerifiedCandidate& again = looked_at_again(view, around_);
  return voted.is_ball() && voted.log_odds > again.log_odds + surer_by ? voted : again;
}

std::optional<BallObservation> BallVerifier::verify_near(const ClassView& view, const TangentCone& start,
                                                         double reach_px, bool clearly,
                                                         const KnownAngle& known) {
  fit_near(view, start, reach_px, clearly ? min_frayed_edge : min_expected_edge, around_, known);
  const bool is_there =
      around_.is_ball() || (!clearly && around_.is_fitted &&
                            judge(view).suffices_where_expected(around_.fit, around_.verdict.support));
  if (!is_there) return std::nullopt;
  return around_.observation(view.colored.color_class, std::nullopt);
}

void BallVerifier::fit_near(const ClassView& view, const TangentCone& start, double reach_px, double min_edge,
                            VerifiedCandidate& candidate, const KnownAngle& known) {
  forget(candidate);
  const bool scouted = scout_outline(view.bgr, rays_->camera(), start, reach_px, min_edge, scouted_);
  fit_and_judge(view, {}, candidate, [&](BallFitter& fitter, OutlineFit& fit) {
    return scouted && fitter.fit_sphere(view.bgr, view.response, scouted_.cone, radius(view), fit, known);
  });
}

}  // namespace ballservo
