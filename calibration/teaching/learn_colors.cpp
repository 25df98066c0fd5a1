#include "calibration/teaching/learn_colors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "calibration/base/fault.hpp"
#include "calibration/teaching/class_choice.hpp"
#include "calibration/teaching/class_table.hpp"
#include "calibration/teaching/clear_picture.hpp"

namespace ballservo {
namespace {

/// The pictures after the search for round regions.
struct Survey {
  std::vector<ColorPicture> cleared;  // what was searched; what is learnt are the pixels as they came
  std::vector<SearchedPicture> pictures;
  std::vector<BallCandidate> candidates;
};

Survey survey(const std::vector<ColorPicture>& pictures, const RegionSearchOptions& search) {
  Survey result;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (search.before_each_picture) search.before_each_picture(i);
    result.cleared.push_back({pictures[i].source, clear_picture(pictures[i].bgr)});
    const ColorPicture& cleared = result.cleared.back();
    const RoundRegions found =
        pictures[i].searched ? *pictures[i].searched : find_round_regions(cleared.bgr, search);
    for (BallCandidate& candidate : ball_candidates(cleared, i, found))
      result.candidates.push_back(std::move(candidate));
    result.pictures.push_back({found.working, found.scale});
  }
  return result;
}

std::vector<BallCandidate> candidates_in(const std::set<std::size_t>& wanted, const Survey& seen) {
  std::vector<BallCandidate> here;
  for (const BallCandidate& candidate : seen.candidates)
    if (wanted.count(candidate.picture)) here.push_back(candidate);
  return here;
}

/// The groups of those candidates that lie in the pictures named.
std::vector<ColorGroup> groups_in(const std::set<std::size_t>& wanted, const Survey& seen) {
  CellCounts all(ColorTable::entries, 0);
  for (const std::size_t i : wanted) count_cells(seen.cleared[i].bgr, {}, all);
  return color_groups(candidates_in(wanted, seen), all);
}

/// Pixels off every ball (and off its blurred rim), of the pictures and of those that show none.
CellCounts background_of(const std::vector<ColorPicture>& pictures, const std::vector<ColorGroup>& groups,
                         const std::vector<ColorPicture>& background) {
  CellCounts counts(ColorTable::entries, 0);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    cv::Mat1b off(pictures[i].bgr.size(), 255);
    for (const ColorGroup& group : groups) {
      for (const BallCandidate& ball : group.balls)
        if (ball.picture == i) cover(off, ball.region);
    }
    count_cells(pictures[i].bgr, off, counts);
  }
  for (const ColorPicture& picture : background) count_cells(picture.bgr, {}, counts);
  return counts;
}

/// Smaller round things than a sure ball count if none is larger by more than this factor.
constexpr double max_speck_ratio = 2;

/// Smaller round things are left out beside a larger one.
constexpr double sure_ball_radius_px = 8;

/// Beside a ball that is sure, the small print of the picture is none: the pips of cards, lamps, buttons.
void leave_out_specks(std::vector<ColorGroup>& groups) {
  double largest_px = 0;
  for (const ColorGroup& group : groups) largest_px = std::max(largest_px, group.largest_radius_px());
  groups.erase(std::remove_if(groups.begin(), groups.end(),
                              [&](const ColorGroup& group) {
                                const double radius_px = group.largest_radius_px();
                                return radius_px < sure_ball_radius_px &&
                                       radius_px * max_speck_ratio < largest_px;
                              }),
               groups.end());
}

/// The pictures that no ball was learnt from, in words; nothing where there are none.
std::string doubt_about_unused(const std::vector<ColorGroup>& groups,
                               const std::vector<ColorPicture>& pictures) {
  constexpr std::size_t most_named = 3;
  std::set<std::size_t> used;
  for (const ColorGroup& group : groups)
    for (const BallCandidate& ball : group.balls) used.insert(ball.picture);
  std::vector<std::string> unused;
  for (std::size_t i = 0; i < pictures.size(); ++i)
    if (used.count(i) == 0) unused.push_back(pictures[i].source);
  if (unused.empty()) return {};
  const std::size_t more = unused.size() - std::min(unused.size(), most_named);
  unused.resize(unused.size() - more);
  return fmt::format(
      "nothing was learnt from {}{}: no ball there is as clear as the others. If there is one, point at it: "
      "--class NAME=IMAGE --at NAME=CX,CY,R",
      fmt::join(unused, ", "), more > 0 ? fmt::format(" and {} more", more) : "");
}

LearntColors finish(std::vector<ColorGroup> groups, Survey seen, const std::vector<ColorPicture>& pictures,
                    const std::vector<ColorPicture>& background) {
  for (ColorGroup& group : groups) {
    group.samples = {};
    for (const BallCandidate& ball : group.balls) {
      group.samples.add(
          samples_inside(pictures[ball.picture].bgr, ball.region, seen.pictures[ball.picture].scale));
    }
  }
  LearntColors result;
  result.table.background = occupied(background_of(pictures, groups, background));
  result.pictures = std::move(seen.pictures);
  for (const ColorGroup& group : groups) {
    if (std::string doubt = doubt_about(group, pictures); !doubt.empty())
      result.doubts.push_back(std::move(doubt));
    add_class(result, group.word, group);
  }
  if (std::string doubt = doubt_about_unused(groups, pictures); !doubt.empty())
    result.doubts.push_back(std::move(doubt));
  rebuild(result.table);
  return result;
}

/// Throws Refusal where all pictures are grey: there is nothing to learn from.
void refuse_grey(const std::vector<ColorPicture>& pictures) {
  constexpr double least_colored = 1e-4;  // what a sensor's noise gives a grey scene is more
  std::vector<std::string> grey;
  for (const ColorPicture& picture : pictures) {
    CellCounts counts;
    count_cells(picture.bgr, {}, counts);
    double colored = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] > 0 && has_color(table_cell_colors()[i].cast<double>())) colored += counts[i];
    }
    if (colored < least_colored * static_cast<double>(picture.bgr.total())) grey.push_back(picture.source);
  }
  if (grey.size() < pictures.size()) return;
  throw Refusal(
      fmt::format("{}", fmt::join(grey, ", ")) +
      ": grey, without any colour to learn. Take the picture with a colour camera and save it in "
      "colour (not as a grey-scale file); if the camera is one, look for its night or black-and-white "
      "mode, or give it more light");
}

}  // namespace

void add_class(LearntColors& colors, const std::string& name, const ColorGroup& group, bool of_video) {
  colors.table.classes.push_back(
      {name, group.samples.pixels.size(), chroma_histogram(group.samples), group.samples.cells()});
  std::vector<LearntCircle>& circles = colors.circles[name];
  for (const auto& [picture, region, samples] : group.balls)
    circles.push_back({of_video ? 0 : picture, of_video ? static_cast<int>(picture) : 0, region.center_px,
                       region.radius_px, region.fit_ratio()});
}

LearntColors learn_colors(const std::vector<ColorPicture>& pictures, const RegionSearchOptions& search,
                          const std::vector<ColorPicture>& background) {
  if (pictures.empty()) throw InputError("pictures", "none", "one or more pictures of balls");
  refuse_grey(pictures);
  Survey seen = survey(pictures, search);
  std::set<std::size_t> everywhere;
  for (std::size_t i = 0; i < pictures.size(); ++i) everywhere.insert(i);
  std::vector<ColorGroup> groups = ball_groups(groups_in(everywhere, seen), pictures);
  leave_out_specks(groups);
  if (groups.size() > max_classes) groups.resize(max_classes);
  std::map<std::string, int> uses;
  for (ColorGroup& group : groups) {
    const int use = ++uses[group.word];
    if (use > 1) group.word += fmt::format("_{}", use);
  }
  return finish(std::move(groups), std::move(seen), pictures, background);
}

LearntColors learn_classes(const std::vector<ColorPicture>& pictures,
                           const std::vector<ClassRequest>& requests, const RegionSearchOptions& search,
                           const std::vector<ColorPicture>& background) {
  FaultList faults;
  check_requests(requests, pictures, faults);
  faults.throw_if_any();
  if (requests.empty()) throw InputError("--class", "none", "one or more classes");
  for (const ClassRequest& request : requests) {
    std::vector<ColorPicture> of_class;
    for (const std::size_t i : request.pictures) of_class.push_back(pictures[i]);
    refuse_grey(of_class);
  }
  Survey seen = survey(pictures, search);
  std::vector<ColorGroup> groups;
  std::vector<std::string> doubts;
  for (const ClassRequest& request : requests) {
    const std::set<std::size_t> wanted(request.pictures.begin(), request.pictures.end());
    if (request.at) {
      groups.push_back(pointed_group(request, candidates_in(wanted, seen), pictures));
    } else {
      const std::vector<ColorGroup> shown = groups_in(wanted, seen);
      groups.push_back(chosen_group(request, shown, pictures));
      std::string doubt = doubt_about_choice(request, groups.back(), shown, pictures);
      if (!doubt.empty()) doubts.push_back(std::move(doubt));
    }
    groups.back().word = request.name;
  }
  LearntColors learnt = finish(std::move(groups), std::move(seen), pictures, background);
  learnt.doubts.insert(learnt.doubts.end(), doubts.begin(), doubts.end());
  return learnt;
}

}  // namespace ballservo
