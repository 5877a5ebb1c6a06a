# Shared by tools/run, tools/test and others, which source it. Sets $root and $jobs.
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# may_install: whether packages can be installed, by root or by sudo.
may_install() {
    ((EUID == 0)) || { command -v sudo >/dev/null && { [[ -t 0 ]] || sudo -n true 2>/dev/null; }; }
}

# need_packages PACKAGE[:COMMAND]...: installs missing packages by apt. A package with a COMMAND is not needed where that command exists.
need_packages() {
    local entry missing=()
    command -v dpkg-query >/dev/null || return 0    # not Debian: cmake reports what is missing
    for entry in "$@"; do
        if [[ $entry == *:* ]] && command -v "${entry#*:}" >/dev/null; then continue; fi
        [[ $(dpkg-query -W -f '${Status}' "${entry%:*}" 2>/dev/null) == *" installed" ]] || missing+=("${entry%:*}")
    done
    ((${#missing[@]})) || return 0

    local sudo=()
    if ! may_install; then
        echo "Missing packages; run as root: apt-get install ${missing[*]}" >&2
        exit 1
    fi
    if ((EUID != 0)); then sudo=(sudo); fi
    echo "Installing ${missing[*]}" >&2
    local apt=("${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300)
    "${apt[@]}" update >&2 || echo "apt-get update failed; continuing with the existing package lists" >&2
    "${apt[@]}" install -y --no-install-recommends "${missing[@]}" >&2
}

# unpack_package PACKAGE COMMAND: where COMMAND is missing, the package of Debian is unpacked into build/PACKAGE, and not installed: it
# would start a service. Where that does not work, the tests that want it say so.
unpack_package() {
    local folder=$root/build/$1
    if command -v "$2" >/dev/null || [[ -x $folder/usr/bin/$2 ]] || ! command -v apt-get >/dev/null; then return; fi
    mkdir -p "$folder"
    if ! (cd "$folder" && apt-get -q download "$1" && dpkg -x "$1"_*.deb . && rm "$1"_*.deb) >"$folder.log" 2>&1; then
        echo "cannot download $1, so its tests are skipped; see $folder.log" >&2
        rm -rf "$folder"
    fi
}

build_packages=(cmake:cmake ninja-build:ninja g++:g++ libboost-dev libspdlog-dev nlohmann-json3-dev libcli11-dev
                libgpiod-dev libexpected-dev libpng-dev libqrencode-dev libssl-dev libzstd-dev pkg-config:pkg-config)
page_packages=(npm:npm)    # for the page in the browser
bridge_packages=(libfastrtps-dev libmosquitto-dev libsqlite3-dev)    # for anogate-ros2 and anogate-mqtt; without them the rest is built

# JOBS in the environment; without it, one job for each processor, but at most one for each gigabyte of free memory, so that a small board
# does not swap.
if [[ ${JOBS:-} ]]; then
    [[ $JOBS =~ ^[1-9][0-9]{0,3}$ ]] || { echo "JOBS=$JOBS is not a number of jobs (1 or more)" >&2; exit 2; }
    jobs=$JOBS
else
    jobs=$(nproc)
    memory=$(awk '/^MemAvailable/ {print int($2 / 1048576)}' /proc/meminfo)
    ((memory >= jobs)) || jobs=$((memory > 0 ? memory : 1))
fi

# Who only runs the program has it sooner where there are 3 GB for each processor: larger groups of sources need that much.
groups=$(awk -v jobs="$(nproc)" '/^MemTotal/ {print ($2 / 1048576 >= 3 * jobs) ? 4 : 1}' /proc/meminfo)

# configure FOLDER OPTION...: CMake with Ninja, and ccache where it is installed.
configure() {
    local folder=$1 launcher=
    shift
    if command -v ccache >/dev/null; then launcher=ccache; fi
    cmake -S "$root" -B "$folder" -G Ninja -DCMAKE_CXX_COMPILER_LAUNCHER=$launcher "$@" >"$folder.log" 2>&1 ||
        { cat "$folder.log" >&2; return 1; }
}
