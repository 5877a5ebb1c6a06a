#!/bin/bash
# tools/test-summary.sh FILE...: the slowest tests, skipped tests with the reason, failures, and the totals, from ctest's JUnit files.
# The last line is ctest's own, over all files.
set -euo pipefail
echo
echo "The slowest tests, in seconds:"
for file in "$@"; do
    build=$(basename "$(dirname "$file")")
    sed -n "s|.*<testcase name=\"\([^\"]*\)\".* time=\"\([0-9.]*\)\".*|\2 $build \1|p" "$file"
done | sort -rn | awk 'NR <= 20 { printf "%7.1f  %s (%s)\n", $1, $3, $2 }'
exec awk '
    function reason() {
        if (note) return note
        return last ? last : "no reason given"
    }
    function value(name,  text) {
        text = $0
        if (!sub(".* " name "=\"", "", text)) return ""
        sub(/".*/, "", text)
        return text
    }
    /<testcase / { name = value("name"); status = value("status"); note = last = ""; expect = output = 0; next }
    /<system-out>/ { output = 1; sub(/.*<system-out>/, "") }
    output {
        line = $0
        ended = sub(/<\/system-out>.*/, "", line)
        if (expect && line != "") { note = line; expect = 0 }
        if (line ~ /: Skipped$/) expect = 1            # GoogleTest: the reason is on the next line
        if (line != "") last = line
        if (ended) output = 0
    }
    /<\/testcase>/ {
        if (status == "run") { passed++; next }
        if (status == "fail") { failed++; failures = failures "\n  " name; next }
        skipped++
        if (seen[name]++) next
        program = name
        sub(/\..*/, "", program)
        group = program ": " reason()
        if (!(group in alike)) groups[++count] = group
        alike[group]++
        only[group] = name ": " reason()
    }
    END {
        text = ""
        for (i = 1; i <= count; i++) {    # tests of one program with the same reason share a line
            group = groups[i]
            line = group
            sub(/:/, " (" alike[group] " tests):", line)
            skips = skips "\n  " (alike[group] > 1 ? line : only[group])
        }
        if (skips) text = text "\nNot run:" skips "\n"
        if (failures) text = text "\nFailed:" failures "\n"
        gsub(/&lt;/, "<", text); gsub(/&gt;/, ">", text); gsub(/&quot;/, "\"", text); gsub(/&apos;/, "\047", text)
        gsub(/&amp;/, "\\&", text)
        ran = passed + failed
        printf "%s\n%d%% tests passed, %d tests failed out of %d, %d not run\n",
            text, ran ? int(100 * passed / ran) : 0, failed, ran, skipped
    }' "$@"
