#include "calibration/color/learn_colors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <set>

#include "calibration/color/class_choice.hpp"
#include "calibration/color/class_table.hpp"
#include "calibration/files/fault.hpp"

namespace ballservo {
namespace {

/// The pictures after the search for round regions.
struct Survey {
  std::vector<SegmentedPicture> pictures;
  std::vector<BallCandidate> candidates;
};

Survey survey(const std::vector<ColorPicture>& pictures, const CircleEstimator& estimator,
              const LearnOptions& options) {
  Survey result;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const RoundRegions found = find_round_regions(pictures[i].bgr, estimator, options.regions);
    for (BallCandidate& candidate : ball_candidates(pictures[i], i, found, options.samples, options.groups)) {
      result.candidates.push_back(std::move(candidate));
    }
    result.pictures.push_back({found.modes, found.scale});
  }
  return result;
}

/// The groups of those candidates that lie in the pictures named.
std::vector<ColorGroup> groups_in(const std::vector<std::size_t>& wanted, const Survey& seen,
                                  const std::vector<ColorPicture>& pictures, const LearnOptions& options) {
  const std::set<std::size_t> indices(wanted.begin(), wanted.end());
  CellCounts all(ColorTable::entries, 0);
  for (const std::size_t i : indices) count_cells(pictures[i].bgr, {}, all);
  std::vector<BallCandidate> here;
  for (const BallCandidate& candidate : seen.candidates) {
    if (indices.count(candidate.picture)) here.push_back(candidate);
  }
  return color_groups(std::move(here), all, options.samples, options.groups);
}

/// Pixels off every ball (and off its blurred rim), of the pictures and of those that show none.
CellCounts background_of(const std::vector<ColorPicture>& pictures, const std::vector<ColorGroup>& groups,
                         const std::vector<ColorPicture>& background) {
  CellCounts counts(ColorTable::entries, 0);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    cv::Mat1b off(pictures[i].bgr.size(), 255);
    for (const ColorGroup& group : groups) {
      for (const BallCandidate& ball : group.balls) {
        if (ball.picture != i) continue;
        const cv::Point center(cvRound(ball.region.center_px.x()), cvRound(ball.region.center_px.y()));
        cv::circle(off, center, cvRound(1.15 * ball.region.radius_px + 2), cv::Scalar(0), cv::FILLED);
      }
    }
    count_cells(pictures[i].bgr, off, counts);
  }
  for (const ColorPicture& picture : background) count_cells(picture.bgr, {}, counts);
  return counts;
}

LearntColors finish(std::vector<ColorGroup> groups, Survey seen, const std::vector<ColorPicture>& pictures,
                    const std::vector<ColorPicture>& background, const LearnOptions& options) {
  const CellCounts elsewhere = background_of(pictures, groups, background);
  LearntColors result;
  result.pictures = std::move(seen.pictures);
  std::vector<ClassEvidence> evidence;
  for (ColorGroup& group : groups) {
    ColorClass color;
    color.name = group.word;
    color.samples = group.samples.pixels.size();
    color.histogram = chroma_histogram(group.samples);
    result.table.classes.push_back(std::move(color));
    LearntClass learnt;
    for (const BallCandidate& ball : group.balls) {
      learnt.circles.push_back(
          {ball.picture, ball.region.center_px, ball.region.radius_px, ball.region.fit_ratio});
    }
    learnt.group = group.chroma;
    result.classes.push_back(std::move(learnt));
    evidence.push_back({std::move(group.samples), group.chroma});
  }
  result.table.table = class_table(evidence, elsewhere, options.samples);

  for (std::size_t k = 0; k < evidence.size(); ++k) {
    std::vector<double> counts(evidence.size() + 1, 0);
    for (const ColorSamples::Pixel& pixel : evidence[k].samples.pixels)
      counts[result.table.table[pixel.table_cell]] += 1;
    const auto total = static_cast<double>(std::max<std::size_t>(1, evidence[k].samples.pixels.size()));
    LearntClass& learnt = result.classes[k];
    learnt.kept_fraction = counts[k + 1] / total;
    for (std::size_t other = 0; other < evidence.size(); ++other) {
      if (other != k) learnt.overlap[result.table.classes[other].name] = counts[other + 1] / total;
    }
  }
  double all = 0;
  std::vector<double> off_ball(evidence.size() + 1, 0);
  for (std::size_t i = 0; i < elsewhere.size(); ++i) {
    all += elsewhere[i];
    off_ball[result.table.table[i]] += elsewhere[i];
  }
  for (std::size_t k = 0; k < evidence.size(); ++k) {
    result.classes[k].background_fraction = all > 0 ? off_ball[k + 1] / all : 0;
  }
  return result;
}

}  // namespace

void LearnOptions::validate() const {
  regions.validate();
  samples.validate();
  groups.validate();
  if (!(weak_round_share >= 0 && weak_round_share <= min_round_share && min_round_share <= 1)) {
    throw InputError("colour classes: weak_round_share, min_round_share",
                     fmt::format("{}, {}", weak_round_share, min_round_share), "0 to 1, in that order");
  }
}

LearntColors learn_colors(const std::vector<ColorPicture>& pictures, const CircleEstimator& estimator,
                          const LearnOptions& options, const std::vector<ColorPicture>& background) {
  options.validate();
  if (pictures.empty()) throw InputError("pictures", "none", "one or more pictures of balls");
  Survey seen = survey(pictures, estimator, options);
  std::vector<std::size_t> everywhere(pictures.size());
  for (std::size_t i = 0; i < everywhere.size(); ++i) everywhere[i] = i;
  std::vector<ColorGroup> groups = groups_in(everywhere, seen, pictures, options);
  const bool any_clear = std::any_of(groups.begin(), groups.end(), [&](const ColorGroup& group) {
    return group.round_share >= options.min_round_share;
  });
  const double least_share = any_clear ? options.min_round_share : options.weak_round_share;
  std::string elsewhere;
  groups.erase(std::remove_if(groups.begin(), groups.end(),
                              [&](const ColorGroup& group) {
                                if (group.round_share >= least_share) return false;
                                const BallCandidate& best = group.balls.front();
                                elsewhere +=
                                    fmt::format("\n  {} in {} at {:.0f},{:.0f}, radius {:.0f} px", group.word,
                                                pictures[best.picture].source, best.region.center_px.x(),
                                                best.region.center_px.y(), best.region.radius_px);
                                return true;
                              }),
               groups.end());
  if (groups.empty()) {
    throw Refusal(
        "nothing round and coloured was found. Try a picture where the ball is whole, in even light, and at "
        "least " +
        fmt::format("{:.0f}", 2 * options.regions.min_radius_px) +
        " px across; or say where it is: --class NAME=IMAGE --at NAME=CX,CY,R" +
        (elsewhere.empty()
             ? ""
             : "\nRound regions whose colour lies mostly elsewhere in the picture:" + elsewhere));
  }
  double best_fit = 0;
  for (const ColorGroup& group : groups) best_fit = std::max(best_fit, group.best_fit());
  groups.erase(std::remove_if(groups.begin(), groups.end(),
                              [&](const ColorGroup& group) {
                                return group.best_fit() < options.groups.min_relative_fit * best_fit;
                              }),
               groups.end());
  if (groups.size() > max_classes) groups.resize(max_classes);
  std::map<std::string, int> uses;
  for (ColorGroup& group : groups) {
    const int use = ++uses[group.word];
    if (use > 1) group.word += fmt::format("_{}", use);
  }
  return finish(std::move(groups), std::move(seen), pictures, background, options);
}

LearntColors learn_classes(const std::vector<ColorPicture>& pictures,
                           const std::vector<ClassRequest>& requests, const CircleEstimator& estimator,
                           const LearnOptions& options, const std::vector<ColorPicture>& background) {
  options.validate();
  FaultList faults;
  check_requests(requests, pictures, faults);
  faults.throw_if_any();
  if (requests.empty()) throw InputError("--class", "none", "one or more classes");
  Survey seen = survey(pictures, estimator, options);
  std::vector<ColorGroup> groups;
  for (const ClassRequest& request : requests) {
    if (request.at) {
      std::vector<BallCandidate> others;
      for (const BallCandidate& candidate : seen.candidates) {
        const auto& wanted = request.pictures;
        if (std::find(wanted.begin(), wanted.end(), candidate.picture) != wanted.end())
          others.push_back(candidate);
      }
      groups.push_back(pointed_group(request, others, pictures, options));
    } else {
      groups.push_back(
          chosen_group(request, groups_in(request.pictures, seen, pictures, options), pictures, options));
    }
    groups.back().word = request.name;
  }
  return finish(std::move(groups), std::move(seen), pictures, background, options);
}

}  // namespace ballservo
