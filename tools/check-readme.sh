#!/bin/bash
# Both READMEs explain every hint, every counter and every link kind that there is.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

names() {
    sed -n 's/^    {"\([a-z0-9_]*\)", &\(Receive\|Send\|Tunnel\)Counters.*/\1/p' include/gateway/counters.hpp
    sed -n 's/^    {"\([a-z-]*\)", ".*/\1:/p' src/link/kinds.cpp
    grep -oE '"[^"]{20,}"' src/gateway/hints.cpp | tr -d '"'
}
missing=0
for readme in README.md README.zh-CN.md; do
    while IFS= read -r name; do
        grep -qF -- "$name" "$readme" || { echo "$readme does not explain: $name"; missing=1; }
    done < <(names)
done
exit "$missing"
