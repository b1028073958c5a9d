#!/bin/sh
# Checks the language of the project: spelling everywhere (codespell), and phrases that are refused.
set -eu
cd "$(dirname "$0")/.."
files() { git ls-files README.md CONTRIBUTING.md ARCHITECTURE.md docs src of-adapter examples openfoam-case tests; }
text() { files | grep -E '\.(md|rs|C|H|toml|py|sh|c|h)$' | grep -v -e '^docs/results/first/' -e '/vendor/'; }
failed=0
text | xargs codespell --ignore-words docs/known-words.txt || failed=1
tab=$(printf '\t')
while IFS=$tab read -r phrase instead; do
    case $phrase in '#'* | '') continue ;; esac
    found=$(text | grep -v -x -e CONTRIBUTING.md | xargs grep -n -i -E -e "$phrase" || true)
    if [ -n "$found" ]; then
        printf '%s\nlanguage.sh: write %s instead of "%s"\n' "$found" "$instead" "$phrase" >&2
        failed=1
    fi
done <docs/refused-phrases.txt
exit $failed
