#include "calibration/teaching/class_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <string>

#include "calibration/color/color_file.hpp"
#include "calibration/color/color_names.hpp"

namespace ballservo {
namespace {

constexpr double farthest_hue_deg = 70;  // beyond a word's border: no neighbour goes on further
constexpr double hue_spread_deg = 12;    // of what people call by a word, beyond its border
constexpr double other_word = 4;         // against a colour that we would call otherwise
constexpr double neighbouring = 4;       // and at most so much more, since some people do
constexpr double no_answer = -1e9;
constexpr double decisive_lead = 2, least_ball_log_odds = 0, sure_ball_log_odds = 5;
constexpr double least_share_beside = 1.0 / 3;  // of a colour in round things, beside a likelier ball
constexpr std::size_t max_listed = 12;
constexpr double sure_fit_ratio = 0.5, sure_radius_px = 8;
constexpr double least_of_circle = 0.5;  // that has its colour: fingers and shine have not

bool more_likely(const ColorGroup& a, const ColorGroup& b) { return a.log_odds() > b.log_odds(); }

/// What fingers hide and blur softens is no clear circle; shaded as a sphere and of a colour that is nowhere
/// else, it is a ball where nothing else comes near it.
bool may_stand_alone(const ColorGroup& group) {
  constexpr double least_sphere = 0.5, least_filled = 0.5, least_alone = -6;
  const CircleEvidence& evidence = group.balls.front().region.evidence;
  return group.round_share >= min_round_share && group.log_odds() >= least_alone &&
         evidence.sphere() >= least_sphere && evidence.filled >= least_filled;
}

/// Whether nothing comes near the first group's `score`. Beside a ball that stands, what lies mostly
/// elsewhere is a part of something else.
template <class Score>
bool leads(const std::vector<ColorGroup>& groups, Score score) {
  const ColorGroup& best = groups.front();
  const bool stands = best.round_share >= least_share_beside &&
                      (best.log_odds() >= sure_ball_log_odds || may_stand_alone(best));
  return std::none_of(groups.begin() + 1, groups.end(), [&](const ColorGroup& group) {
    return (!stands || group.round_share >= least_share_beside) && score(best) < score(group) + decisive_lead;
  });
}

/// What the word in the class's name says of a colour: 0 where we would call it so ourselves or it has none.
double log_likelihood_of_word(const std::optional<std::string>& word, const ColorGroup& group) {
  if (!word || group.word == *word) return 0;
  const double away = hue_distance_to_word_deg(*word, group.samples.hue_deg());
  if (away > farthest_hue_deg) return no_answer;
  return -other_word - std::min(neighbouring, 0.5 * std::pow(away / hue_spread_deg, 2));
}

/// What the pictures of the class say that show no ball of that colour: a user gives pictures of the ball.
double log_likelihood_of_pictures(const ClassRequest& request, const ColorGroup& group) {
  constexpr double without_ball = 3;
  return -without_ball *
         static_cast<double>(
             std::count_if(request.pictures.begin(), request.pictures.end(), [&](std::size_t picture) {
               return std::none_of(group.balls.begin(), group.balls.end(),
                                   [&](const BallCandidate& ball) { return ball.picture == picture; });
             }));
}

/// "CX,CY,R" as `--at` takes it.
std::string at_text(const RoundRegion& region) {
  return fmt::format("{:.0f},{:.0f},{:.0f}", region.center_px.x(), region.center_px.y(), region.radius_px);
}

/// One line a colour, with the `--at` that points at its best ball in the class's first picture; the most
/// likely first, and no more than a user reads.
std::string list_of(const ClassRequest& request, std::vector<ColorGroup> groups,
                    const std::vector<ColorPicture>& pictures) {
  std::string text;
  std::stable_sort(groups.begin(), groups.end(), more_likely);
  if (groups.size() > max_listed) groups.resize(max_listed);
  for (const ColorGroup& group : groups) {
    const auto in_first =
        std::find_if(group.balls.begin(), group.balls.end(),
                     [&](const BallCandidate& ball) { return ball.picture == request.pictures.front(); });
    const BallCandidate& shown = in_first != group.balls.end() ? *in_first : group.balls.front();
    text += fmt::format(
        "\n  {}, {} round region{} with {:.0f} % of that colour, the best in {} around ({:.0f}, {:.0f}) px",
        group.word, group.balls.size(), group.balls.size() == 1 ? "" : "s", 100 * group.round_share,
        pictures[shown.picture].source, shown.region.center_px.x(), shown.region.center_px.y());
    if (in_first != group.balls.end())
      text += fmt::format(": --at {}={}", request.name, at_text(shown.region));
  }
  return text;
}

/// Of the pixels inside a ball's circle, those of the group's colour.
double share_of_color(const ColorGroup& group, const BallCandidate& ball) {
  const auto of_color = std::count_if(
      ball.samples.pixels.begin(), ball.samples.pixels.end(), [&](const ColorSamples::Pixel& pixel) {
        return group.chroma.cells.at<uchar>(pixel.chroma_cell / ChromaHistogram::side,
                                            pixel.chroma_cell % ChromaHistogram::side) != 0;
      });
  return static_cast<double>(of_color) / static_cast<double>(ball.samples.looked_at);
}

}  // namespace

ColorGroup chosen_group(const ClassRequest& request, std::vector<ColorGroup> groups,
                        const std::vector<ColorPicture>& pictures) {
  if (groups.empty()) {
    throw Refusal(fmt::format(
        "class {}: nothing round and coloured was found in {}. Try a picture where the ball is whole, "
        "in even light and larger than {:.0f} px across, or say where it is: --at {}=CX,CY,R",
        request.name, pictures[request.pictures.front()].source, 2 * RegionSearchOptions().min_radius_px,
        request.name));
  }
  const auto word = word_in_name(request.name);
  // Beside a sure ball of the word's colour, another is no likelier to be meant for being a clearer one.
  const bool shown = std::any_of(groups.begin(), groups.end(), [&](const ColorGroup& group) {
    return group.word == word && group.log_odds() >= sure_ball_log_odds;
  });
  const auto score = [&](const ColorGroup& group) {
    const double odds = group.log_odds();
    const bool other = shown && group.word != word;
    return (other ? std::min(odds, sure_ball_log_odds) : odds) + log_likelihood_of_word(word, group) +
           log_likelihood_of_pictures(request, group);
  };
  std::stable_sort(groups.begin(), groups.end(),
                   [&](const ColorGroup& a, const ColorGroup& b) { return score(a) > score(b); });
  const ColorGroup& best = groups.front();
  const auto refuse = [&](const char* reason) {
    throw Refusal(fmt::format("class {}: {}:{}", request.name, reason, list_of(request, groups, pictures)));
  };
  if (log_likelihood_of_word(word, best) == no_answer)
    refuse(
        "no round thing of that colour was found; say where the ball is, or give the class another name. "
        "What was found");
  if (best.log_odds() < least_ball_log_odds && !may_stand_alone(best))
    refuse("nothing that was found is surely a ball. If one of it is, point at it. What was found");
  if (!leads(groups, score)) refuse("round things of several colours were found; say which is meant");
  return std::move(groups.front());
}

std::vector<ColorGroup> ball_groups(std::vector<ColorGroup> groups,
                                    const std::vector<ColorPicture>& pictures) {
  std::vector<ColorGroup> balls;
  std::stable_sort(groups.begin(), groups.end(), more_likely);
  const double most = groups.empty() ? 0 : groups.front().log_odds();
  const double least = std::clamp(most - candidate_lead, least_ball_log_odds, sure_ball_log_odds);
  std::set<std::size_t> shown;  // pictures with a likelier ball
  const auto is_shown = [&](const BallCandidate& ball) { return shown.count(ball.picture) > 0; };
  for (const ColorGroup& group : groups) {
    if (group.log_odds() < least) break;
    const bool beside = std::all_of(group.balls.begin(), group.balls.end(), is_shown);
    if (beside && group.round_share < least_share_beside) continue;
    for (const BallCandidate& ball : group.balls) shown.insert(ball.picture);
    balls.push_back(group);
  }
  sort_by_size(balls);
  if (!balls.empty()) return balls;
  if (!groups.empty() && may_stand_alone(groups[0]) && leads(groups, std::mem_fn(&ColorGroup::log_odds)))
    return {groups[0]};
  throw Refusal(
      fmt::format(
          "nothing round and coloured was found. Try a picture where the ball is whole, in even light, and "
          "at least {:.0f} px across; or say where it is: --class NAME=IMAGE --at NAME=CX,CY,R",
          2 * RegionSearchOptions().min_radius_px) +
      (groups.empty()
           ? ""
           : "\nRound regions that are no sure balls:" + list_of({"NAME", {0}, {}}, groups, pictures)));
}

std::string doubt_about_choice(const ClassRequest& request, const ColorGroup& chosen,
                               std::vector<ColorGroup> groups, const std::vector<ColorPicture>& pictures) {
  if (word_in_name(request.name)) return {};
  groups.erase(std::remove_if(groups.begin(), groups.end(),
                              [&](const ColorGroup& group) {
                                return group.word == chosen.word || group.log_odds() < sure_ball_log_odds ||
                                       group.round_share < least_share_beside;
                              }),
               groups.end());
  if (groups.empty()) return {};
  return fmt::format("{} was learnt from the clearest balls, which are {}; others are sure balls, too:{}",
                     request.name, chosen.word, list_of(request, std::move(groups), pictures));
}

std::string doubt_about(const ColorGroup& group, const std::vector<ColorPicture>& pictures) {
  const BallCandidate& best = group.balls.front();
  std::string reasons;
  const auto add = [&](const std::string& reason) { reasons += (reasons.empty() ? "" : "; ") + reason; };
  if (best.region.smeared)
    add("its best ball is an ellipse, as motion makes of one");
  else if (best.region.fit_ratio() < sure_fit_ratio)
    add(fmt::format("its outline is round to {:.2f} (1 is a whole ball)", best.region.fit_ratio()));
  if (group.round_share < min_round_share)
    add(fmt::format("{:.0f} % of its colour lies outside round things", 100 * (1 - group.round_share)));
  if (best.region.radius_px < sure_radius_px)
    add(fmt::format("it is only {:.0f} px across", 2 * best.region.radius_px));
  const auto word = word_in_name(group.word);
  const std::string seen = color_word(group.samples.mean_lab());
  if (word && seen != *word && hue_distance_to_word_deg(*word, group.samples.hue_deg()) > 0)
    add("its colour is rather " + seen);
  if (const double share = share_of_color(group, best); share < least_of_circle)
    add(fmt::format("only {:.0f} % of its circle has its colour", 100 * share));
  if (reasons.empty()) return {};
  return fmt::format(
      "{} was learnt from what lies around ({:.0f}, {:.0f}) px in {}, but not for sure: {}. Look at the "
      "--preview, or point at the ball: --class {}={} --at {}=CX,CY,R",
      group.word, best.region.center_px.x(), best.region.center_px.y(), pictures[best.picture].source,
      reasons, group.word, pictures[best.picture].source, group.word);
}

ColorGroup pointed_group(const ClassRequest& request, const std::vector<BallCandidate>& candidates,
                         const std::vector<ColorPicture>& pictures) {
  ColorGroup group;
  BallCandidate pointed;
  pointed.picture = request.pictures.front();
  pointed.region.center_px = request.at->center_px;
  pointed.region.radius_px = request.at->radius_px;
  pointed.region.evidence.arc = pointed.region.evidence.filled = 1;
  pointed.samples = samples_inside(pictures[pointed.picture].bgr, pointed.region, 1);
  if (pointed.samples.pixels.size() < 10 || pointed.samples.colored_fraction() < 0.1) {
    throw Refusal(
        fmt::format("class {}: hardly a pixel inside --at {}={} has a colour ({} of {}); black, white and "
                    "grey things can't be "
                    "learnt",
                    request.name, request.name, at_text(pointed.region), pointed.samples.pixels.size(),
                    pointed.samples.looked_at));
  }
  group.samples = pointed.samples;
  const auto is_pointed_at = [&](const BallCandidate& candidate) {
    const double apart = (candidate.region.center_px - pointed.region.center_px).norm();
    return candidate.picture == pointed.picture &&
           apart < candidate.region.radius_px + pointed.region.radius_px;
  };
  // In its picture the user would have pointed at whatever is a clearer ball.
  double least_beside = sure_ball_log_odds;
  for (const BallCandidate& candidate : candidates) {
    if (is_pointed_at(candidate))
      least_beside = std::max(least_beside, candidate.region.evidence.log_odds() - equal_balls);
  }
  for (const BallCandidate& candidate : candidates) {
    if (is_pointed_at(candidate)) continue;
    const double least = candidate.picture == pointed.picture ? least_beside : least_ball_log_odds;
    if (candidate.region.evidence.log_odds() < least) continue;
    if (!same_color(candidate.samples, pointed.samples)) continue;
    group.samples.add(candidate.samples);
    group.balls.push_back(candidate);
  }
  group.balls.insert(group.balls.begin(), std::move(pointed));
  group.round_share = 1;  // the user says so
  group.chroma = chroma_group(chroma_histogram(group.samples));
  group.word = color_word(group.samples.mean_lab());
  return group;
}

void check_class_name(const std::vector<ClassRequest>& requests, std::size_t which, FaultList& faults) {
  const std::string& name = requests[which].name;
  if (!is_class_name(name)) faults.add("--class", fmt::format("the name \"{}\"", name), class_name_rule);
  for (std::size_t k = 0; k < which; ++k)
    if (requests[k].name == name) faults.add("--class", name + " twice", "each name once");
}

void check_requests(const std::vector<ClassRequest>& requests, const std::vector<ColorPicture>& pictures,
                    FaultList& faults) {
  if (requests.size() > max_classes) {
    faults.add("--class", fmt::format("{} classes", requests.size()), fmt::format("at most {}", max_classes));
  }
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const ClassRequest& request = requests[i];
    check_class_name(requests, i, faults);
    if (request.pictures.empty()) {
      faults.add(fmt::format("--class {}", request.name), "no picture", "one or more pictures");
      continue;
    }
    if (!request.at) continue;
    const cv::Mat& picture = pictures[request.pictures.front()].bgr;
    const double x = request.at->center_px.x(), y = request.at->center_px.y(), r = request.at->radius_px;
    const std::string place = fmt::format("--at {}", request.name);
    const std::string found = fmt::format("{},{},{}", x, y, r);
    const double longest = std::hypot(picture.cols, picture.rows);
    if (!std::isfinite(x) || !std::isfinite(y) ||
        !(x > -0.5 && x < picture.cols - 0.5 && y > -0.5 && y < picture.rows - 0.5)) {
      faults.add(place, found,
                 fmt::format("a centre inside the {} x {} px of {}", picture.cols, picture.rows,
                             pictures[request.pictures.front()].source));
    }
    if (!(r >= 2 && r <= longest)) {
      faults.add(place, found, fmt::format("a radius from 2 to {:.0f} px", longest));
    }
  }
}

}  // namespace ballservo
