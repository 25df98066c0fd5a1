# The set-up that app/demo.sh and tests/run.sh share; they source it with `root` set to the project's folder.
# Everything comes from Debian 12; apt is asked only when something is missing.

build_packages="g++ cmake ninja-build libvisp-dev libopencv-dev libjpeg-dev libeigen3-dev libceres-dev libcli11-dev libfmt-dev
  libspdlog-dev libyaml-cpp-dev nlohmann-json3-dev libtbb-dev libhwy-dev libboost-dev libssl-dev libxml2-dev libzmq3-dev cppzmq-dev libgtest-dev libgmock-dev
  librapidcheck-dev libbenchmark-dev python3-matplotlib python3-jinja2 libjs-chart.js
  pybind11-dev python3-dev python3-numpy"
test_packages="locales dpkg-dev libmujoco-dev python3-camera-calibration-parsers python3-jsonschema python3-mypy python3-opencv python3-zmq poppler-utils xvfb xdotool chromium chromium-driver python3-selenium
  g++-aarch64-linux-gnu qemu-user"
fuzz_packages="clang-16 libclang-rt-16-dev"
log=$root/build/setup.log

say() { printf '%s\n' "$*"; }

fail() {
  printf '%s\n' "$*" >&2
  exit 1
}

# Runs a command into the log, and shows the log's end if it fails.
logged() {
  say "\$ $*" >>"$log"
  if ! "$@" >>"$log" 2>&1 </dev/null; then
    tail -n 40 "$log" >&2
    fail "That failed: $* (the whole log is $log)"
  fi
}

# Runs a command as root, into the log.
as_root() {
  if [ "$(id -u)" = 0 ]; then
    logged env DEBIAN_FRONTEND=noninteractive "$@"
  elif command -v sudo >/dev/null; then
    logged sudo env DEBIAN_FRONTEND=noninteractive "$@"
  else
    fail "Something is missing, and neither root nor sudo is at hand. As root, run: $*"
  fi
}

apt_install() {
  local missing=() package
  for package in "$@"; do
    if [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then
      missing+=("$package")
    fi
  done
  if [ ${#missing[@]} = 0 ]; then return; fi
  say "Installing from Debian (a few minutes the first time): ${missing[*]}"
  as_root apt-get update
  as_root apt-get install -y --no-install-recommends "${missing[@]}"
}

# Sets `examples` to OpenCV's example pictures: where opencv-doc is installed, or unpacked below build/ on machines
# that drop documentation.
find_example_pictures() {
  local below=usr/share/doc/opencv-doc/examples/data place
  for place in / "$root/build/opencv-doc/"; do
    examples=$place$below
    if [ -r "$examples/left01.jpg" ] && [ -r "$examples/smarties.png" ]; then return; fi
  done
  say "Fetching OpenCV's example pictures (package opencv-doc)"
  mkdir -p "$root/build/opencv-doc"
  if ! (cd "$root/build/opencv-doc" && apt-get download opencv-doc) >>"$log" 2>&1; then
    as_root apt-get update
    (cd "$root/build/opencv-doc" && logged apt-get download opencv-doc)
  fi
  logged dpkg -x "$root"/build/opencv-doc/opencv-doc_*.deb "$root/build/opencv-doc"
  rm -f "$root"/build/opencv-doc/opencv-doc_*.deb
  [ -r "$examples/left01.jpg" ] || fail "Package opencv-doc holds no left01.jpg"
}

# Says how far a build is, from Ninja's "[12/128] ..." on stdin, which goes on into the log.
build_progress() {
  tee -a "$log" | awk -F '[][/]' '
    /^\[[0-9]+\/[0-9]+\]/ && $3 > 5 {
      tenths = int(10 * $2 / $3)
      if (tenths > said) { said = tenths; printf "    %d %% built\n", 10 * tenths; fflush() }
    }'
}

# Builds the named targets, or everything.
build() {
  local targets=()
  if [ $# != 0 ]; then targets=(--target "$@"); fi
  say "Building (some minutes the first time)"
  cd "$root"
  logged cmake --preset release
  if ! cmake --build --preset release "${targets[@]}" 2>&1 </dev/null | build_progress; then
    grep -A 20 -m 1 -E "^FAILED|error:" "$log" >&2 || tail -n 40 "$log" >&2
    fail "The build failed (the whole log is $log)"
  fi
}

mkdir -p "$root/build"
: >"$log"
