#!/bin/sh
# usage: includes_point_down.sh ROOT
# Each room includes only itself and the rooms named beside it. Ceres serves off line, ViSP stays inside source files
# (but for the features, which are ViSP's), and the libraries do not print. Every include of ours starts at the root.
set -u
cd "$1" || exit 1

find calibration perception servo app -name "*.[ch]pp" 2>/dev/null | sort | xargs awk '
  function complain(why) { print FILENAME ":" FNR ": " $0 "  (" why ")"; bad++ }
  # The longest room in the table that holds the path; a folder that is no room belongs to the one above it.
  function room_of(path) {
    do sub("/[^/]*$", "", path); while (!(path in may) && index(path, "/"))
    return path
  }
  function room(name, others) { may[name] = " " name " " others " " }
  BEGIN {
    base = "calibration/base"
    camera = base " calibration/camera"
    color = base " calibration/color"
    room("calibration/base", "")
    room("calibration/pictures", base)
    room("calibration/circles", base)
    room("calibration/camera", base)
    room("calibration/camera/files", camera)
    room("calibration/color", base)
    room("calibration/boards", camera " calibration/camera/files calibration/ball")
    room("calibration/ball", camera " calibration/camera/files calibration/boards")
    room("calibration/teaching", color " calibration/circles calibration/pictures")

    # A candidate is a cone, which is what an outline is fitted as: so the fit comes first.
    room("perception/segmentation", color)
    outline = camera " calibration/circles perception/segmentation"
    room("perception/outline", outline)
    room("perception/candidates", outline " " color " perception/outline")
    room("perception/judgement", outline " " color " perception/outline")
    seen = outline " " color " perception/outline perception/candidates perception/judgement"
    room("perception", seen)
    room("perception/tracking", seen " perception")

    room("servo/motion", base)
    room("servo/avoidance", camera " servo/motion")
    room("servo/control", base " servo/motion servo/avoidance")
    room("servo/features", base " servo/motion servo/control")
    simulated = camera " servo/motion servo/avoidance servo/control"
    room("servo/simulation/world", simulated)
    room("servo/simulation/rendering", simulated " servo/simulation/world")
    room("servo/simulation/robot", simulated " servo/simulation/world servo/simulation/rendering")

    looped = seen " perception perception/tracking servo/motion servo/avoidance servo/control"
    room("app/loop", looped)

    room("app/loop/visp", "app/loop " base " servo/motion")

    all = "calibration/pictures calibration/camera/files calibration/boards calibration/ball calibration/teaching " \
          seen " perception perception/tracking " \
          simulated " servo/features servo/simulation/world servo/simulation/rendering servo/simulation/robot " \
          "app app/io app/loop app/loop/visp app/scenario app/experiment app/sweep app/report app/comparison app/live app/peer app/commands"
    room("app", all)
    room("app/io", all)
    room("app/scenario", all)
    room("app/experiment", all)
    room("app/sweep", all)
    room("app/report", all)
    room("app/comparison", all)
    room("app/live", all)
    room("app/peer", looped " app/loop app/io")  # the line alone: runs with peers are experiments
    room("app/commands", all)
  }
  FNR == 1 { here = room_of(FILENAME); header = FILENAME ~ /\.hpp$/ }
  /^[ \t]*#[ \t]*include[ \t]*"/ {
    split($0, parts, "\"")
    if (index(may[here], " " room_of(parts[2]) " ") == 0) complain(here " must not know it")
  }
  /^[ \t]*#[ \t]*include[ \t]*<ceres\// && FILENAME !~ /^(app\/comparison|calibration\/(boards|ball))\// {
    complain("Ceres serves off line only")
  }
  /^[ \t]*#[ \t]*include[ \t]*<visp3\// && header && here != "servo/features" { complain("ViSP stays inside source files") }
  /^[ \t]*#[ \t]*include[ \t]*<spdlog\// && here !~ /^app/ { complain("libraries do not print") }
  /std::c(out|err)[ \t]*<<|fmt::print\(|[^a-z_]printf\(/ && here !~ /^app/ { complain("libraries do not print") }
  /fmt::print\(/ && here ~ /^app/ { complain("a full disk would end it: print_message, print_result") }
  END {
    print bad + 0 " lines point the wrong way"
    exit bad > 0
  }'
