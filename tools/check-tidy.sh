#!/bin/bash
# What clang-tidy says of the program, the library and anoctl: .clang-tidy. It is to say nothing.
#   tools/check-tidy.sh [FOLDER]       FOLDER: where the build is configured (build/tidy)
# Sources are looked at together, since most of the time goes to what they include.
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
cd "$root"
folder=${1:-build/tidy}
need_packages "${build_packages[@]}" clang-14:clang++-14 clang-tidy-14:clang-tidy-14 python3:python3
mkdir -p build
configure "$root/$folder" -DCMAKE_CXX_COMPILER=clang++-14 -DANOGATE_UNITY=ON -DANOGATE_GROUPS=4 -DANOGATE_PCH=OFF

python3 -c 'import json, sys; sys.stdout.write("\0".join(entry["file"] for entry in json.load(sys.stdin)))' <"$folder/compile_commands.json" |
    xargs -0 -P "$jobs" -n 1 clang-tidy-14 -p "$folder" --quiet --header-filter="^$root/(include|src|tools)/" 2>/dev/null
