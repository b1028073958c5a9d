#!/bin/sh
# Checks the language of the project: spelling everywhere (codespell), phrases that are refused, the width of prose, and
# names of tests.
set -eu
cd "$(dirname "$0")/.."
files() { git ls-files "*.md" docs src of-adapter examples openfoam-case tests benches; }
text() { files | grep -E '\.(md|rs|C|H|toml|py|sh|c|h)$' | grep -v -e '^docs/results/first/' -e '/vendor/' -e 'case.resolved.toml'; }
failed=0
text | xargs codespell --ignore-words docs/known-words.txt || failed=1
tab=$(printf '\t')
while IFS=$tab read -r phrase instead; do
    case $phrase in '#'* | '') continue ;; esac
    found=$(text | grep -v -x -e CONTRIBUTING.md | xargs grep -n -i -P -e "$phrase" || true)
    if [ -n "$found" ]; then
        printf '%s\nlanguage.sh: write %s instead of "%s"\n' "$found" "$instead" "$phrase" >&2
        failed=1
    fi
done <docs/refused-phrases.txt
# Prose in Markdown and lines of comments have at most 120 characters. Code and tables may be wider, and addresses do
# not count.
wide=$(text | grep -E '\.(md|rs|C|H|py|sh|c|h)$' | xargs perl -CSDA -ne '
    chomp;
    $code = !$code if m{^[\s/!]*```};
    my $prose = $ARGV =~ /\.md$/ ? !/^(\s*\||<!--)/
        : $ARGV =~ /\.(py|sh)$/ ? /^\s*#/ : m{^\s*(//(?![/!] \|)|\* )};
    my $words = s/\]\([^)]*\)|https?:\S+|\(crate::\S+\)|\(super::\S+\)//gr;
    print "$ARGV:$.: ", length $words, " characters\n" if $prose && !$code && length $words > 120;
    if (eof) { $code = 0; close ARGV }')
if [ -n "$wide" ]; then
    printf '%s\nlanguage.sh: break these lines before column 120\n' "$wide" >&2
    failed=1
fi
# Names of functions have at most 60 characters: what a test claims beyond that is in the line above it.
long=$(git grep -nPo 'fn \K\w{61,}' -- '*.rs' || true)
if [ -n "$long" ]; then
    printf '%s\nlanguage.sh: shorten these names to 60 characters\n' "$long" >&2
    failed=1
fi
# The tests that a page names exist, as a part of a function's or a file's name: of the library (L), with solvers (S),
# within the source (U).
unknown=$({
    grep -oP '\b(L|S\+?|U) `\w+`(, `\w+`)*' docs/*.md
    git ls-files '*.md' | xargs grep -oP '`(a|an|the)_\w+`' | sed 's/:/:any /'
} | tr -d '`,' | while read -r where names; do
    case $where in
    *:any) within=. ;;
    *:L) within=tests/library ;;
    *:U) within=':!tests' ;;
    *) within=tests/solvers ;;
    esac
    for name in $names; do
        git ls-files "$within" | grep -q "$name" || git grep -qE "fn \w*$name" -- "$within" || echo "${where%:*}: $name"
    done
done)
if [ -n "$unknown" ]; then
    printf '%s\nlanguage.sh: there are no such tests\n' "$unknown" >&2
    failed=1
fi
exit $failed
