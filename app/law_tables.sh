#!/bin/sh
# The laws beside each other on the same worlds: among obstacles with and without avoidance, over errors of what the robot
# believes, and shown their goal by a robot that believes what is far off. Prints each sweep's table; its folder has a
# report with its map. Killed, it goes on where it was.
#
#   app/law_tables.sh OUT [TRIALS]      OUT: folder for the sweeps; TRIALS: worlds a cell (default 60); THREADS: of each sweep
set -eu
[ $# -ge 1 ] || { sed -n '2,6s/^# \{0,1\}//p' "$0"; exit 2; }
out=$1 trials=${2:-60}
root=$(cd "$(dirname "$0")/.." && pwd)
program=$root/build/release/app/ballservo
mkdir -p "$out"

# sweep NAME SCENARIO OPTION...
sweep() {
  name=$1 scenario=$2
  shift 2
  printf '\n%s\n' "$name"
  "$program" sweep "$root/data/scenarios/$scenario.yaml" -o "$out/$name" --trials "$trials" --seed 60000 \
    --threads "${THREADS:-0}" --resume --quiet --vary law.name=cone,visp,sphere,pose "$@"
}

sweep obstacles obstacles --vary avoidance.type=none,shield,full
sweep lens static_ball \
  --set "vary={believed.focal_scale: {uniform: [0.97, 1.03]}, believed.diameter_scale: {uniform: [0.97, 1.03]}}"
sweep mount static_ball \
  --set "vary={believed.pitch_error_rad: {uniform: [-0.02, 0.02]}, believed.forward_error_m: {uniform: [-0.02, 0.02]}}"
sweep latency static_ball \
  --set "vary={believed.latency_error_s: {uniform: [-0.033, 0.4]}, law.gain_per_s: {uniform: [0.5, 4]}}"
for belief in diameter_scale=0.4 diameter_scale=1 diameter_scale=3 focal_scale=0.5 focal_scale=2 pitch_error_rad=-0.2 \
  pitch_error_rad=0.2 forward_error_m=0.2 up_error_m=0.15 latency_error_s=0.1 latency_error_s=0.2; do
  "$program" servo "$root/data/scenarios/static_ball.yaml" --teach -o "$out/$belief.yaml" --force --quiet \
    --perception geometric --set "believed.$belief"
  sweep "$belief" static_ball --set "believed.$belief" --set "target={ball: target, taught: $out/$belief.yaml}"
done
