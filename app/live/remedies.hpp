// What helps where a ball gets lost: the table of perception/README.md, beside what it is about.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ballservo {

/// A picture of the pipeline that the page can show.
struct LiveView {
  std::string name;    ///< "classified"
  std::string title;   ///< of its picture among stage_pictures, from the beginning; empty: no stage
  std::string remedy;  ///< what it means where the ball is missing there first, and what helps
};
const std::vector<LiveView>& live_views();
/// Null where there is none of that name.
const LiveView* live_view(std::string_view name);

/// What helps against a reason of the judge's; empty for one without a remedy.
std::string_view remedy_of(std::string_view reason);

}  // namespace ballservo
