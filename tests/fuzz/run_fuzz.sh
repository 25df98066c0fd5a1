#!/bin/bash
# usage: tests/fuzz/run_fuzz.sh TARGET [SECONDS]
# Runs one fuzz target (build/fuzz/tests/fuzz/TARGET, see `cmake --preset fuzz`) from seeds made of the files in data/
# and the inputs kept in tests/fuzz/seeds. A target that has not changed since it last came through tries its corpus
# again and stops; with SECONDS it runs that long in any case. Exit: 0 nothing found, 77 not built.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
target=$1 seconds=${2:-} usual_seconds=3
build=$root/build/fuzz
program=$build/tests/fuzz/$target
if [ ! -x "$program" ]; then
  echo "not built: $program (cmake --preset fuzz && cmake --build --preset fuzz)"
  exit 77
fi

corpus=$build/corpus/$target seeds=$build/seeds/$target passed=$build/passed/$target
mkdir -p "$corpus" "$seeds" "$build/passed" "$build/crashes"

# The files of data/ below a name that tells them apart, each behind a prefix.
seed_from() {
  local prefix=$1 file
  shift
  for file in "$@"; do
    { printf '%s' "$prefix"; cat "$file"; } >"$seeds/$(basename "$(dirname "$file")")_$(basename "$file")"
  done
}

case $target in
  camera_file_fuzz) seed_from '' "$root"/data/cameras/* ;;
  scenario_fuzz) seed_from '' "$root"/data/scenarios/*.yaml ;;
  plan_fuzz) seed_from '' "$root"/data/comparisons/*.yaml ;;
  strict_yaml_fuzz) seed_from '0' "$root"/data/{cameras,scenarios,comparisons}/*.yaml ;;
  color_file_fuzz)
    for file in "$root"/data/colors/*.colors; do tail -n +4 "$file" >"$seeds/$(basename "$file")"; done ;;
  image_header_fuzz)
    for file in "$root"/data/images/*; do head -c 4096 "$file" >"$seeds/$(basename "$file")"; done
    printf 'P6\n# by hand\n2 1 255\nabcdef' >"$seeds/small.ppm" ;;
  csv_fuzz) printf 'source,distance_m,sigma_m\na.png,1.5,0.002\n"b, c.png", 2 ,\n' >"$seeds/distances.csv" ;;
  numbers_fuzz)
    printf '%s' '-12.5e-3' >"$seeds/number"
    printf '%s' 'left2.jpgleft10.jpg' >"$seeds/names" ;;
  live_message_fuzz)
    printf '%s\n' '{"do":"touch","touch":{"do":"ball","x_m":2,"y_m":-1}}' '{"do":"touch","touch":{"do":"law","name":"visp"}}' \
      '{"do":"touch","touch":{"do":"robot","x_m":1,"y_m":0.5,"yaw_rad":0.1}}' '{"do":"touch","touch":{"do":"box","x_m":3,"y_m":1}}' \
      '{"do":"touch","touch":{"do":"obstacle","name":"dropped_1","x_m":3,"y_m":1}}' '{"do":"touch","touch":{"do":"gain","per_s":2}}' \
      '{"do":"touch","touch":{"do":"avoidance","type":"shield"}}' '{"do":"touch","touch":{"do":"latency","latency_s":0.1}}' >"$seeds/touches"
    printf '{"do":"calibrate","board":"chessboard:9x6","square_m":0.025}\n{"do":"load","base64":"%s"}\n' \
      "$(head -c 6000 "$root"/data/colors/red.colors | base64 -w 0)" >"$seeds/words" ;;
  lockstep_message_fuzz)
    printf '%s' '{"ballservo_lockstep":1,"until_s":0.6,"command":[0.1,-0.2],"end":"enough"}' >"$seeds/request"
    printf '%s\n' '{"ballservo_lockstep":1,"over":{"outcome":"reached","text":"there"}}' >"$seeds/over"
    printf '%s\n' '{"ballservo_lockstep":1,"time_s":0.58,"odometry":[1,2,0.5],"twist":[0.1,0],"truth":{"pose":[0,0,0],"twist":[0,0]},' \
      '"sonars":[{"fired_s":0.55,"transducer":15,"range_m":2.5,"echo":true}],"frames":[{"frame":17,"time_s":0.53,"arrived_s":0.57,' \
      '"ball":{"state":"confirmed","p_m":[0.1,0.2,2],"covariance_m2":[[1,0,0],[0,1,0],[0,0,1]]}}]}' | tr -d '\n' >"$seeds/answer"
    { cat "$seeds/answer"; printf '\nabcdef'; } >"$seeds/answer_with_picture" ;;
  covariance_fuzz)
    printf '%s' '{"parameters":["fx_px","fy_px","cx_px","cy_px"],"values":[500,500,320,240],' \
      '"covariance":[[1,0.5,0,0],[0.5,1,0,0],[0,0,2,0],[0,0,0,2]]}' >"$seeds/covariance.json" ;;
esac
kept=("$seeds")
if [ -d "$here/seeds/$target" ]; then kept+=("$here/seeds/$target"); fi

# The words of the seeds, for libFuzzer to put together anew.
grep -ahoE '[A-Za-z_][A-Za-z0-9_]{2,30}' -r "${kept[@]}" | LC_ALL=C sort -u | head -n 400 |
  sed 's/.*/"&"/' >"$seeds.dict" || true

checksum=$(sha256sum <"$program")
limit=(-max_total_time="${seconds:-$usual_seconds}")
if [ -z "$seconds" ] && [ "$(cat "$passed" 2>/dev/null)" = "$checksum" ]; then limit=(-runs=0); fi
rm -f "$passed"
cd "$build"
if ! "$program" "${limit[@]}" -timeout=10 -rss_limit_mb=2048 -detect_leaks=0 -max_len=16384 -print_final_stats=1 \
  -dict="$seeds.dict" -artifact_prefix="$build/crashes/$target-" "$corpus" "${kept[@]}"; then
  echo "$target found something: run $program on the file named above"
  exit 1
fi
echo "$checksum" >"$passed"
