#!/bin/bash
# What clang-tidy says of the program, the library and anoctl: .clang-tidy. It is to say nothing.
#   tools/check-tidy.sh [FOLDER]       FOLDER: a build by clang 14 (build/test-clang-address-undefined)
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
cd "$root"
folder=${1:-build/test-clang-address-undefined}
need_packages clang-tidy-14:clang-tidy-14
[[ -f $folder/compile_commands.json ]] || { echo "$folder is not a build; make one: tools/test --clang --sanitize=address,undefined" >&2; exit 1; }

find src tools -name '*.cpp' -print0 | xargs -0 -P "$jobs" -n 1 clang-tidy-14 -p "$folder" --quiet 2>/dev/null
