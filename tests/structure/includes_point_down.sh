#!/bin/sh
# usage: includes_point_down.sh ROOT
# calibration is the ground floor, perception and servo stand on it and do not know each other, the simulation cannot
# lean on what it tests, app joins them. Ceres serves off line, ViSP stays inside source files, and the libraries do not
# print. Every include of ours starts at the root.
set -u
cd "$1" || exit 1

find calibration perception servo app -name "*.[ch]pp" 2>/dev/null | sort | xargs awk '
  function complain(why) { print FILENAME ":" FNR ": " $0 "  (" why ")"; bad++ }
  function floor_of(path) {
    if (path ~ /^servo\/simulation\//) return "simulation"
    return substr(path, 1, index(path, "/") - 1)
  }
  BEGIN {
    may["calibration"] = " calibration "
    may["perception"] = " calibration perception "
    may["servo"] = " calibration servo "
    may["simulation"] = " calibration servo simulation "
    may["app"] = " calibration perception servo simulation app "
  }
  FNR == 1 { here = floor_of(FILENAME); header = FILENAME ~ /\.hpp$/ }
  /^[ \t]*#[ \t]*include[ \t]*"/ {
    split($0, parts, "\"")
    if (index(may[here], " " floor_of(parts[2]) " ") == 0) complain(here " must not know it")
  }
  /^[ \t]*#[ \t]*include[ \t]*<ceres\// && FILENAME !~ /^(app\/offline|calibration\/camera)\// {
    complain("Ceres serves off line only")
  }
  /^[ \t]*#[ \t]*include[ \t]*<visp3\// && header { complain("ViSP stays inside source files") }
  /^[ \t]*#[ \t]*include[ \t]*<spdlog\// && here != "app" { complain("libraries do not print") }
  /std::c(out|err)[ \t]*<<|fmt::print\(|[^a-z_]printf\(/ && here != "app" { complain("libraries do not print") }
  END {
    print bad + 0 " lines point the wrong way"
    exit bad > 0
  }'
