#include "app/live/remedies.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace ballservo {
namespace {

constexpr const char* teach_again = "teach the colour anew in this light";
constexpr const char* no_circle =
    "the region is a box or a slanted disc, or too little of a boundary is seen";
constexpr const char* come_nearer = "come nearer, or take a larger picture";

constexpr std::array<std::pair<std::string_view, std::string_view>, 10> remedies{{
    {"too small", come_nearer},
    {"no ball makes this circle", no_circle},
    {"the region's outline follows no circle",
     "the class ends inside the ball or runs past it: teach the rim's shade too"},
    {"no edge along the circle", "contrast under 4 to 10 grey levels: more light, or another background"},
    {"too little of the outline has an edge", "more than 70 % is hidden: move what stands before it"},
    {"too little of the disc has the colour", "teach the rest of the ball too, in this light"},
    {"the colour runs on around it",
     "a thing of its colour lies behind it, and no edge between them: move one of them"},
    {"half of it is hidden, and the rest is not shaded as a sphere",
     "a flat disc; or a ball lit from everywhere, or wholly in shadow"},
    {"outline and colour together are too weak",
     "a ball that is known already passes with less: show it whole first"},
    {"contour and shading are no ball's",
     "a small ball, one of many alike or a doubtful one must be plainly round and shaded: come nearer"},
}};

}  // namespace

const std::vector<LiveView>& live_views() {
  static const std::vector<LiveView> views = {
      {"picture", "", ""},
      {"taught", "", "what has a class shines in its colour: the ball should, and nothing else"},
      {"classified", "classified", std::string("are the ball's pixels without a class? ") + teach_again},
      {"opened", "opened",
       std::string("do they vanish here? The ball is under about 6 px across: ") + come_nearer},
      {"closed", "closed",
       "is the ball one region with other things? Votes and inner edges separate them; teach a tighter "
       "colour "
       "where they fail"},
      {"votes", "outlines", std::string("is no circle voted? ") + no_circle},
      {"edges", "ring pixels",
       std::string("no points on the ball's rim? Contrast is under 4 to 10 grey levels: "
                   "more light, or another background")},
      {"candidates", "estimate", "grey circles are rejected; the list says why and what helps"},
      {"refined", "refined",
       "found, but the distance is wrong? Look at --diameter, then at --camera; a blurred picture"}};
  return views;
}

const LiveView* live_view(std::string_view name) {
  const auto found = std::find_if(live_views().begin(), live_views().end(),
                                  [&](const LiveView& view) { return view.name == name; });
  return found == live_views().end() ? nullptr : &*found;
}

std::string_view remedy_of(std::string_view reason) {
  const auto* const found = std::find_if(remedies.begin(), remedies.end(),
                                         [&](const auto& remedy) { return remedy.first == reason; });
  return found == remedies.end() ? std::string_view() : found->second;
}

}  // namespace ballservo
