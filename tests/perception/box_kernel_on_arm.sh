#!/bin/sh
# usage: box_kernel_on_arm.sh ROOT
# Compiles the classification's inner loop for 64-bit ARM (NEON) and runs it against its definition in an emulator.
set -eu
for tool in aarch64-linux-gnu-g++ qemu-aarch64; do
  if ! command -v $tool >/dev/null; then
    echo "skipped: $tool is not installed (packages g++-aarch64-linux-gnu, qemu-user)"
    exit 77
  fi
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
ln -s /usr/include/hwy "$work/hwy"  # without the rest of this machine's headers
aarch64-linux-gnu-g++ -std=c++17 -O2 -Wall -Wextra -Werror -static -DHWY_COMPILE_ONLY_STATIC -I "$1" -isystem "$work" \
  "$1/tests/perception/box_kernel_on_arm.cpp" "$1/perception/segmentation/box_kernel.cpp" -o "$work/check"
qemu-aarch64 "$work/check"
