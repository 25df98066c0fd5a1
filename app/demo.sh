#!/bin/bash
# usage: app/demo.sh
# Installs what is missing from Debian 12, builds, and shows the main job on real pictures and a simulated robot.
# The results lie in build/demo; the last line printed is the path of the page that explains them.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
[ $# = 0 ] || { echo "usage: app/demo.sh" >&2; exit 2; }

. "$root/app/setup.sh"
apt_install $build_packages
find_example_pictures
build ballservo

out=$root/build/demo
mkdir -p "$out"
cd "$out"
: >demo.log

# Runs one command of the program: results into demo.log, progress and messages to the screen.
ballservo() {
  echo "\$ ballservo $*" >>demo.log
  "$root/build/release/app/ballservo" "$@" --force >>demo.log
}

# One figure of a JSON file, as Python's format writes it.
figure() {
  python3 -c 'import json, sys
value = json.load(open(sys.argv[1]))[sys.argv[2]]
print("unknown" if value is None else format(value, sys.argv[3]))' "$@"
}

say "1/5 Calibrating a camera from 13 photographs of a chessboard"
ballservo calibrate camera "$examples"/left[0-9]*.jpg --board chessboard:9x6 --square 0.025 --model brown \
  -o left.yaml --report boards --json left.json
say "    RMS $(figure left.json rms_px .3f) px, focal length $(figure left.json fx_px .1f) px"

say "2/5 Learning the colours of round sweets from one photograph, without help"
ballservo calibrate colors "$examples/smarties.png" -o smarties.colors --preview colors --json colors.json

say "3/5 Finding the sweets in that photograph"
ballservo detect "$examples/smarties.png" --colors smarties.colors -o detections.csv --overlay found --stages stages
say "    $(tail -n +2 detections.csv | cut -d, -f5 | sort | uniq -c | awk '{ printf "%s%d %s", (NR > 1 ? ", " : ""), $1, $2 }')"

say "4/5 Driving a simulated robot to a ball that it sees through rendered camera pictures"
ballservo servo "$root/data/scenarios/static_ball.yaml" -o servo --video
say "    $(figure servo/summary.json outcome s) after $(figure servo/summary.json settled_s .1f) s," \
  "$(figure servo/summary.json range_error_m .4f) m from where it should stand"

say "5/5 Comparing one step of the fit with the converged fit on the same pixels"
ballservo compare "$root/data/comparisons/basic.yaml" -o compare

echo '{"page": "demo"}' >report.json
ballservo report .
say "Done. Open this page in a browser:"
say "$out/report.html"
