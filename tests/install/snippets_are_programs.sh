#!/bin/sh
# usage: snippets_are_programs.sh README PROGRAM...
# Every line of C++ in the README stands in one of the programs that the tests build and run.
set -eu
readme=$1
shift
sed -n '/^```cpp$/,/^```$/p' "$readme" | grep -v '^```' | {
  missing=0 lines=0
  while IFS= read -r line; do
    lines=$((lines + 1))
    cat "$@" | grep -qxF -e "$line" || { echo "no program says: $line"; missing=$((missing + 1)); }
  done
  echo "$lines lines, $missing missing"
  [ "$lines" -gt 0 ] && [ "$missing" -eq 0 ]
}
