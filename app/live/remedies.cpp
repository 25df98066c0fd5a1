#include "app/live/remedies.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace ballservo {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 13> remedies{{
    {"too small", "come nearer, or take a larger picture"},
    {"no ball makes this circle",
     "the region is a box or a slanted disc, or too little of a boundary is seen"},
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
    {"flat and an oval, as a disc seen aslant",
     "a disc or a lid; or a ball lit from everywhere, through another lens than the stated one"},
    {"evenly bright, beside a ball that is shaded", "a disc; the light that shades one ball shades all"},
    {"a speck, beside a clear ball", "beside a clear ball, a small one must be surer: come nearer"},
}};

}  // namespace

const std::vector<LiveView>& live_views() {
  static const std::vector<LiveView> views = {
      {"picture", "", ""},
      {"taught", "", "What has a class shines in its colour: the ball should, and nothing else."},
      {"classified", "classified",
       "Where the ball's pixels have no class, teach the colour anew in this light."},
      {"opened", "opened",
       "Where they vanish, the ball is under about 6 px across: come nearer, or take a larger picture."},
      {"closed", "closed",
       "Where the ball and other things are one region, votes and inner edges separate them; where those "
       "fail, teach a tighter colour."},
      {"votes", "outlines",
       "Where no circle is voted, the region is a box or a slanted disc, or too little of a boundary is "
       "seen."},
      {"edges", "ring pixels",
       "Where the ball's rim has no points, contrast is under 4 to 10 grey levels: more light, or another "
       "background."},
      {"candidates", "estimate", "Grey circles are rejected; the list says why and what helps."},
      {"refined", "refined",
       "Where the outline fits and the distance does not: look at the ball's diameter, then at the camera's "
       "calibration."}};
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
