#!/bin/sh
# The laws beside each other: among obstacles with and without avoidance, on the same worlds, over errors of what the robot
# believes, and shown their goal by a robot that believes what is far off. Prints the three tables; each sweep's folder has
# a report with its map. Killed, it goes on where it was.
#
#   app/law_tables.sh OUT [TRIALS]      OUT: folder for the sweeps; TRIALS: worlds a cell (default 60); THREADS: of each sweep
set -eu
[ $# -ge 1 ] || { sed -n '2,7s/^# \{0,1\}//p' "$0"; exit 2; }
out=$1 trials=${2:-60}
root=$(cd "$(dirname "$0")/.." && pwd)
program=$root/build/release/app/ballservo
mkdir -p "$out"

# sweep NAME SCENARIO --set ...: one cell; prints "reached, collisions" and the median of the settling times.
sweep() {
  name=$1 scenario=$2
  shift 2
  "$program" sweep "$root/data/scenarios/$scenario.yaml" -o "$out/$name" --trials "$trials" --seed 60000 \
    --threads "${THREADS:-0}" --resume --quiet "$@" >/dev/null
  awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == "settled_s") settled = i; next }
    $3 == "infeasible" { next }
    { ++n } $3 == "reached" { ++reached; s[reached] = $settled + 0 } $3 == "collision" { ++hit }
    END {
      for (i = 2; i <= reached; ++i) { v = s[i]; for (j = i - 1; j > 0 && s[j] > v; --j) s[j + 1] = s[j]; s[j + 1] = v }
      printf "%d of %d, %d | %s", reached, n, hit, reached ? sprintf("%.1f s", s[int((reached + 1) / 2)]) : "-"
    }' "$out/$name/trials.csv"
}

echo "| law | avoidance | reached, collisions | settled, median |"
echo "|---|---|---|---|"
for law in cone visp sphere pose; do
  for avoidance in none shield full; do
    cell=$(sweep "$law-$avoidance" obstacles --set law.name=$law --set avoidance.type=$avoidance)
    echo "| $law | $avoidance | $cell |"
  done
done

echo
echo "| law | scale of f and of the diameter, 0.97 to 1.03 | pitch -0.02 to 0.02 rad, forward -0.02 to 0.02 m | latency -0.033 to 0.4 s, gain 0.5 to 4 1/s |"
echo "|---|---|---|---|"
for law in cone visp sphere pose; do
  row="| $law"
  for errors in \
    "lens {believed.focal_scale: {uniform: [0.97, 1.03]}, believed.diameter_scale: {uniform: [0.97, 1.03]}}" \
    "mount {believed.pitch_error_rad: {uniform: [-0.02, 0.02]}, believed.forward_error_m: {uniform: [-0.02, 0.02]}}" \
    "latency {believed.latency_error_s: {uniform: [-0.033, 0.4]}, law.gain_per_s: {uniform: [0.5, 4]}}"; do
    cell=$(sweep "$law-${errors%% *}" static_ball --set law.name=$law --set "vary=${errors#* }")
    row="$row | ${cell%% |*}"
  done
  echo "$row |"
done

echo
echo "| shown its goal, believed | cone | visp | sphere | pose |"
echo "|---|---|---|---|---|"
for belief in diameter_scale=0.4 diameter_scale=1 diameter_scale=3 focal_scale=0.5 focal_scale=2 pitch_error_rad=-0.2 \
  pitch_error_rad=0.2 forward_error_m=0.2 up_error_m=0.15 latency_error_s=0.1 latency_error_s=0.2; do
  "$program" servo "$root/data/scenarios/static_ball.yaml" --teach -o "$out/$belief.yaml" --force --quiet --perception geometric \
    --set "believed.$belief" >/dev/null
  row="| $belief"
  for law in cone visp sphere pose; do
    row="$row | $(sweep "$law-$belief" static_ball --set law.name=$law --set "believed.$belief" \
      --set "target={ball: target, taught: $out/$belief.yaml}" | sed 's/, \(.*\) | \(.*\)/, \1 (\2)/')"
  done
  echo "$row |"
done
