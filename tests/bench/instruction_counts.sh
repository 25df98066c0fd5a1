#!/bin/sh
# usage: instruction_counts.sh PROGRAM FIGURES [--update]
# Counts the instructions of the stages that PROGRAM runs, under callgrind: the same whatever else the machine does.
# FIGURES has a line "STAGE COUNT" for each. Fails where one needs over 10 % more than its figure; --update writes the
# figures anew. Callgrind knows no AVX-512: AVX2 is what is counted.
set -u
program=$1 figures=$2 update=${3:-}
if ! command -v valgrind >/dev/null; then
  echo "skipped: valgrind is not installed"
  exit 77
fi
if ! grep -qw avx2 /proc/cpuinfo; then
  echo "skipped: the figures are for a processor with AVX2"
  exit 77
fi

dumps=$(mktemp -d) || exit 1
trap 'rm -rf "$dumps"' EXIT
valgrind --tool=callgrind --callgrind-out-file="$dumps/dump" --collect-atstart=no --toggle-collect=counted_stage \
  --dump-after=counted_stage "$program" >"$dumps/stages" 2>"$dumps/log" </dev/null || {
  cat "$dumps/log"
  if grep -q "Unrecognised instruction" "$dumps/log"; then
    echo "skipped: callgrind does not know an instruction that a library uses on this processor"
    exit 77
  fi
  exit 1
}

i=0
new=$(while read -r stage; do
  i=$((i + 1))
  counted=$(sed -n 's/^totals: *//p' "$dumps/dump.$i")
  figure=$(sed -n "s/^$stage //p" "$figures")
  echo "$stage ${counted:-0} ${figure:-0}"
done <"$dumps/stages")
if [ "$update" = --update ]; then
  echo "$new" | cut -d " " -f 1,2 | tee "$figures"
  exit
fi
echo "$new" | awk '
  BEGIN { form = "%-20s %12s %12s %6s\n"; printf form, "stage", "instructions", "figure", "ratio" }
  { printf form, $1, $2, $3, $3 ? sprintf("%.3f", $2 / $3) : "-"; bad += !$2 || $2 > 1.1 * $3 }
  END { exit bad > 0 }'
