#!/bin/bash
# usage: tests/run.sh [--slow]
# Installs what is missing from Debian 12, builds everything, and runs the tests; --slow adds those that take minutes.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

slow=(-LE slow)
for argument in "$@"; do
  case $argument in
    --slow) slow=() ;;
    *) echo "usage: tests/run.sh [--slow]" >&2; exit 2 ;;
  esac
done

. "$root/app/setup.sh"
apt_install $build_packages $test_packages $fuzz_packages
find_example_pictures
# Fresh machines know only C and POSIX; some tests need a locale with a decimal comma.
if ! locale -a 2>/dev/null | grep -qix 'de_DE\.utf-\?8'; then
  say "Generating the locale de_DE.UTF-8"
  as_root localedef -i de_DE -f UTF-8 de_DE.UTF-8
fi
build
say "Building the parsers for fuzzing (a minute the first time)"
logged cmake --preset fuzz
logged cmake --build --preset fuzz
say "Testing; the log of every test will be $root/build/release/Testing/Temporary/LastTest.log"
cd "$root"
exec ctest --preset release -j "$(nproc)" "${slow[@]}"
