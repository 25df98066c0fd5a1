#include "calibration/color/class_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "calibration/color/color_file.hpp"
#include "calibration/color/color_names.hpp"

namespace ballservo {
namespace {

constexpr double farthest_hue_deg = 20;  // beyond its border a word does not answer

/// "CX,CY,R" as `--at` takes it.
std::string at_text(const RoundRegion& region) {
  return fmt::format("{:.0f},{:.0f},{:.0f}", region.center_px.x(), region.center_px.y(), region.radius_px);
}

/// One line a colour, with the `--at` that points at its best ball in the class's first picture.
std::string list_of(const ClassRequest& request, const std::vector<ColorGroup>& groups,
                    const std::vector<ColorPicture>& pictures) {
  std::string text;
  for (const ColorGroup& group : groups) {
    const auto in_first =
        std::find_if(group.balls.begin(), group.balls.end(),
                     [&](const BallCandidate& ball) { return ball.picture == request.pictures.front(); });
    const BallCandidate& shown = in_first != group.balls.end() ? *in_first : group.balls.front();
    text +=
        fmt::format("\n  {}, {} round region{}, the best in {} around ({:.0f}, {:.0f}) px", group.word,
                    group.balls.size(), group.balls.size() == 1 ? "" : "s", pictures[shown.picture].source,
                    shown.region.center_px.x(), shown.region.center_px.y());
    if (in_first != group.balls.end())
      text += fmt::format(": --at {}={}", request.name, at_text(shown.region));
  }
  return text;
}

}  // namespace

ColorGroup chosen_group(const ClassRequest& request, std::vector<ColorGroup> groups,
                        const std::vector<ColorPicture>& pictures, const LearnOptions& options) {
  if (groups.empty()) {
    throw Refusal(fmt::format(
        "class {}: nothing round and coloured was found in {}. Try a picture where the ball is whole, "
        "in even light and larger than {:.0f} px across, or say where it is: --at {}=CX,CY,R",
        request.name, pictures[request.pictures.front()].source, 2 * options.regions.min_radius_px,
        request.name));
  }
  // A colour that lies mostly outside round things is a worse answer than one that is all in them.
  std::stable_sort(groups.begin(), groups.end(), [&](const ColorGroup& a, const ColorGroup& b) {
    return (a.round_share >= options.weak_round_share) > (b.round_share >= options.weak_round_share);
  });
  const auto mostly_round =
      static_cast<std::size_t>(std::count_if(groups.begin(), groups.end(), [&](const ColorGroup& g) {
        return g.round_share >= options.weak_round_share;
      }));
  if (hue_distance_to_word_deg(request.name, 0)) {
    std::size_t best = 0;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < groups.size(); ++i) {
      const double distance = *hue_distance_to_word_deg(request.name, groups[i].samples.hue_deg());
      if (distance < nearest) {
        nearest = distance;
        best = i;
      }
    }
    if (nearest > farthest_hue_deg) {
      throw Refusal(
          fmt::format("class {}: no round thing of that colour was found; say where the ball is, or give the "
                      "class another name. "
                      "What was found:{}",
                      request.name, list_of(request, groups, pictures)));
    }
    return std::move(groups[best]);
  }
  if (mostly_round == 1 || groups.size() == 1) return std::move(groups.front());
  if (mostly_round > 1) groups.resize(mostly_round);
  throw Refusal(fmt::format("class {}: round things of several colours were found; say which is meant:{}",
                            request.name, list_of(request, groups, pictures)));
}

ColorGroup pointed_group(const ClassRequest& request, const std::vector<BallCandidate>& candidates,
                         const std::vector<ColorPicture>& pictures, const LearnOptions& options) {
  ColorGroup group;
  BallCandidate pointed;
  pointed.picture = request.pictures.front();
  pointed.region.center_px = request.at->center_px;
  pointed.region.radius_px = request.at->radius_px;
  pointed.region.inlier_fraction = pointed.region.fill = pointed.region.fit_ratio = 1;
  pointed.samples = samples_inside(pictures[pointed.picture].bgr, pointed.region, 1, options.samples);
  if (pointed.samples.pixels.size() < 10 || pointed.samples.colored_fraction() < 0.1) {
    throw Refusal(
        fmt::format("class {}: hardly a pixel inside --at {}={} has a colour ({} of {}); black, white and "
                    "grey things can't be "
                    "learnt",
                    request.name, request.name, at_text(pointed.region), pointed.samples.pixels.size(),
                    pointed.samples.looked_at));
  }
  group.samples = pointed.samples;
  for (const BallCandidate& candidate : candidates) {
    const double apart = (candidate.region.center_px - pointed.region.center_px).norm();
    if (candidate.picture == pointed.picture && apart < candidate.region.radius_px + pointed.region.radius_px)
      continue;
    if (!same_color(candidate.samples, pointed.samples, options.groups)) continue;
    group.samples.add(candidate.samples);
    group.balls.push_back(candidate);
  }
  group.balls.insert(group.balls.begin(), std::move(pointed));
  group.chroma = chroma_group(chroma_histogram(group.samples));
  group.word = color_word(group.samples.mean_lab());
  return group;
}

void check_requests(const std::vector<ClassRequest>& requests, const std::vector<ColorPicture>& pictures,
                    FaultList& faults) {
  if (requests.size() > max_classes) {
    faults.add("--class", fmt::format("{} classes", requests.size()), fmt::format("at most {}", max_classes));
  }
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const ClassRequest& request = requests[i];
    if (!is_class_name(request.name)) {
      faults.add("--class", fmt::format("the name \"{}\"", request.name),
                 "1 to 64 of a-z, 0-9 and _, beginning with a letter");
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (requests[j].name == request.name)
        faults.add("--class", fmt::format("{} twice", request.name), "each name once");
    }
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
