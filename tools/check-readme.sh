#!/bin/bash
# What can be checked of the READMEs: the two of the project are one screen; every hint, counter and kind of link is explained in both
# languages, a hint under its id as an anchor; both languages have the same headings, rows, anchors and items in the same order; every
# link and file that they name exists, and Chinese text has Chinese punctuation.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export LC_ALL=C.UTF-8
max_lines=120 max_columns=120
missing=0
fault() {
    echo "$*"
    missing=1
}
mapfile -t readmes < <(find . \( -name build -o -name node_modules \) -prune -o -name 'README*.md' -print | sed 's|^\./||' | sort)

# explained_in FILE...: every line of standard input, at least one, stands in one of them.
explained_in() {
    local name count=0
    while IFS= read -r name; do
        count=$((count + 1))
        grep -qF -- "$name" "$@" || fault "$* does not explain: $name"
    done
    ((count)) || fault "no names were found that $* should explain"
}
hints() {
    { cat src/gateway/hints.cpp include/gateway/hints.hpp; grep -hE '\.(nothing_yet|no_frames|no_frames_any_more) = ' src/link/*/*_link.cpp src/link/*_link.cpp || true; } |
        grep -oE '"[^"]{20,}"' | tr -d '"' | grep -vxE '[a-z_]+'    # those are ids
}
# The ids of hints, as the page translates them; each is the anchor of its row.
hint_anchors() { sed -n '/^export const hints:/,/^};/s/^  \([a-z0-9_]*\): .*/<a id="\1">/p' src/web/src/words_of_gateway.ts; }
counters() { sed -n 's/^    {"\([a-z0-9_]*\)", &\(Receive\|Send\)Counters.*/\1/p' include/gateway/counters.hpp; }
tunnel_counters() { sed -n 's/^    {"\([a-z0-9_]*\)", &TunnelCounters.*/\1/p' include/gateway/counters.hpp; }
kinds() { sed -n 's/^    {"\([a-z-]*\)", ".*/\1:/p; s/^    \.name = "\([a-z-]*\)",$/\1:/p' src/link/kinds.cpp src/link/*_link.cpp src/link/*/*_link.cpp; }

for language in '' .zh-CN; do
    lines=$(wc -l <"README$language.md")
    ((lines <= max_lines)) || fault "README$language.md has $lines lines, at most $max_lines are meant"
    columns=$(wc -L <"README$language.md")    # a Chinese character has two
    ((columns <= max_columns)) || fault "README$language.md is $columns columns wide, at most $max_columns are meant"
    explained_in "tools/README$language.md" < <(hints)
    explained_in "tools/README$language.md" < <(hint_anchors)
    explained_in "tools/README$language.md" < <(counters)
    explained_in "config/README$language.md" < <(tunnel_counters)
    explained_in {config/,src/link/}"README$language.md" < <(kinds)
done

# The anchors of a file: those that it sets itself, and those that GitHub makes of headings: lower case, letters, digits and hyphens.
anchors() {
    grep -oP '<a id="\K[^"]+' "$1" || true
    sed -n 's/^#\+ //p' "$1" | sed 's/[^[:alnum:] _-]//g; s/ /-/g' | tr '[:upper:]' '[:lower:]'
}
prose() { grep -v '^    ' "$1"; }

# Each row of events has an anchor, to which hints lead.
while IFS= read -r row; do
    fault "config/README.md: no anchor in the row: ${row:0:60}"
done < <(sed -n '/^## What happens when/,/^## /p' config/README.md | grep '^|' | tail -n +3 | grep -v '^| <a id="')

for readme in "${readmes[@]}"; do
    folder=$(dirname "$readme")
    while IFS= read -r target; do
        file=$folder/${target%%#*} anchor=
        if [[ $target == '#'* ]]; then file=$readme; fi
        if [[ $target == *'#'* ]]; then anchor=${target#*#}; fi
        if [[ ! -e $file ]]; then
            fault "$readme: $target does not exist"
        elif [[ $anchor ]] && ! anchors "$file" | grep -xF -- "$anchor" >/dev/null; then    # reads all: -q would end it by SIGPIPE
            fault "$readme: $target: no such heading"
        fi
    done < <(prose "$readme" | grep -oP '\]\(\K[^)]*(?=\))' | grep -v '://')
    while IFS= read -r path; do
        [[ -e $path ]] || fault "$readme: $path does not exist"
    done < <(prose "$readme" | grep -oP '`\K(src|include|config|systemd|tools|tests)/[\w./-]*(?=`)')
done

# The headings, the rows of tables with their number of cells and their anchors, and the items of lists, in their order.
shape() {
    sed 's/`[^`]*`//g' "$1" | awk '
        /^#/ { print "heading " $1 }
        /^\|/ {
            text = $0; row = "row of " gsub(/\|/, "") - 1
            while (match(text, /<a id="[^"]*">/)) { row = row " " substr(text, RSTART, RLENGTH); text = substr(text, RSTART + RLENGTH) }
            print row
        }
        /^- / { print "item" }'
}
for readme in "${readmes[@]}"; do
    chinese=${readme%.md}.zh-CN.md
    [[ -e $chinese ]] || continue
    difference=$(diff <(shape "$readme") <(shape "$chinese") | head -3) || true
    [[ -z $difference ]] || fault "$chinese does not have the headings, rows and items of $readme: ${difference//$'\n'/ }"
done

# Chinese text: no ASCII punctuation beside a Chinese character. Code and the targets of links are left out.
for readme in "${readmes[@]}"; do
    [[ $readme == *.zh-CN.md ]] || continue
    while IFS= read -r line; do
        fault "$readme: ASCII punctuation beside Chinese: $line"
    done < <(prose "$readme" | sed 's/`[^`]*`//g; s/\]([^)]*)/]/g' |
        grep -oP '.{0,9}([\p{Han}\x{3000}-\x{303F}\x{FF00}-\x{FFEF}][,;:?!()]|[,;:?!()][\p{Han}\x{3000}-\x{303F}\x{FF00}-\x{FFEF}]).{0,9}')
done
exit "$missing"
