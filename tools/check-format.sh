#!/bin/bash
# Every source is as clang-format writes it, in the version of Debian 12: other versions write some lines differently.
#   tools/check-format.sh [--fix]
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
cd "$root"
need_packages clang-format-14:clang-format-14

mode=(--dry-run -Werror)
if [[ ${1-} == --fix ]]; then mode=(-i); fi
find include src tests tools \( -name '*.cpp' -o -name '*.hpp' \) -print0 | xargs -0 -P "$jobs" -n 30 clang-format-14 "${mode[@]}"
