#!/usr/bin/env python3
"""Renders all pages as one book in target/book: docs/book/build.py

Needs mdbook (it says how to get it) and blahtexml, which turns equations into MathML. The book needs no network to be
read. The pages of all keys and of the command line are what the program says itself.
"""

import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "target/book-source"
BOOK = ROOT / "target/book"
MDBOOK = "0.5.4"
# What pages link to, in addition to pages: everything else stays out of the book.
LINKED = re.compile(r"\.(md|png|svg|toml|txt|py|rs|h|H|c|cc|sh|sbatch|csv|stl|vtp|cff|yml|html)$|(^|/)(LICENSE|Containerfile)$|^openfoam-case/base/")

CODE = r"(^```.*?^```|`[^`\n]*`)"


def main():
    mdbook = find_mdbook()
    stage()
    write_reference()
    run(mdbook, "build", str(ROOT / "docs/book"))
    broken = broken_links()
    for text in broken:
        print(f"build.py: {text}", file=sys.stderr)
    print(f"{BOOK}/index.html")
    sys.exit(1 if broken else 0)


def find_mdbook():
    """The program in target/tools, which is installed there if need be: results depend on one version only."""
    tools = ROOT / "target/tools"
    program = tools / "bin/mdbook"
    if not program.is_file():
        install = ["cargo", "install", "mdbook", "--version", MDBOOK, "--locked", "--no-default-features", "--features", "search"]
        # Compiling it takes longer than all that it is used for: without optimization.
        run(*install, "--debug", "--quiet", "--root", str(tools))
    return str(program)


def stage():
    """Copies what the book shows, with equations as MathML."""
    shutil.rmtree(SOURCE, ignore_errors=True)
    tracked = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    for name in filter(LINKED.search, tracked.split("\0")):
        if name.startswith("tests/") and not name.startswith("tests/fuzz/"):
            continue
        target = SOURCE / name
        target.parent.mkdir(parents=True, exist_ok=True)
        if name.endswith(".md"):
            text = (ROOT / name).read_text(encoding="utf-8")
            text = re.sub(r"^```(rooms|csv)$", "```text", text, flags=re.M)  # no language that is highlighted
            target.write_text(with_mathml(unbroken(text), name), encoding="utf-8")
        else:
            shutil.copyfile(ROOT / name, target)
    shutil.copyfile(ROOT / "docs/book/SUMMARY.md", SOURCE / "SUMMARY.md")


def write_reference():
    """The pages that the program itself writes: all keys, and the help of all commands."""
    folder = SOURCE / "docs/reference"
    folder.mkdir(parents=True)
    (folder / "keys.md").write_text(keys_page(), encoding="utf-8")
    (folder / "command-line.md").write_text(command_line_page(), encoding="utf-8")


def keys_page():
    """`fsi-driver keys` as a page, with an anchor for each key."""
    page = """# All keys of a case

What [`case.toml`](../running.md#a-case) may contain, as `fsi-driver keys` prints it: default, origin of the default,
meaning, range. Pages of keys by subject: [vessels](../vessels.md), [inlet and outlet](../boundary-conditions.md),
[state](../artery-state.md), [viscosity](../blood.md), [OpenFOAM cases](../own-case.md).
"""
    table = None
    for entry in re.split(r"\n(?=\S)", program("keys").rstrip()):
        head, *lines = entry.split("\n")
        path, value, origin = re.fullmatch(r"(\S+)(?: = (.+?))?(?:\s+\[(\w+)\])?", head).groups()
        if path.split(".")[0] != table:
            table = path.split(".")[0]
            page += f"\n## {table}\n"
        page += f'\n<a id="{path}"></a>**`{path}`**' + (f" = `{value}`" if value else "")
        page += (f" ({origin})" if origin else "") + "<br>\n"
        meaning, words = [], []
        for line in lines:
            depth = len(line) - len(line.lstrip())
            if depth == 4:
                meaning.append(line.strip())
            elif depth == 6:
                words.append(re.split(r"\s+", line.strip(), maxsplit=1))
            else:
                words[-1][1] += " " + line.strip()
        page += plain(" ".join(meaning)) + "\n"
        page += "".join(f"\n- `{word}`: {plain(what)}" for word, what in words) + ("\n" if words else "")
    return page


def command_line_page():
    """The help of all commands as a page."""
    overview = program("--help")
    commands = re.findall(r"^  ([a-z-]+) ", overview.split("Commands:")[1].split("Options:")[0], flags=re.M)
    page = "# The command line\n\nWhat `fsi-driver COMMAND --help` prints. [What each is for](../running.md#all-commands).\n"
    for command in ["", *(command for command in commands if command != "help")]:
        text = program(command, "--help") if command else overview
        page += f"\n## {command or 'fsi-driver'}\n\n```text\n{text.rstrip()}\n```\n"
    return page


def plain(text):
    """Text in which Markdown finds no marks, but for code."""
    pieces = re.split(r"(`[^`]*`)", text)
    pieces[::2] = [re.sub(r"([\\*_<>\[\]])", r"\\\1", piece) for piece in pieces[::2]]
    return "".join(pieces)


def program(*words):
    """What fsi-driver prints."""
    command = ["cargo", "run", "--release", "--quiet", "--", *words]
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def unbroken(text):
    """Numbers stay on one line with their units and exponents."""
    pieces = re.split(CODE, text, flags=re.M | re.S)
    for i in range(0, len(pieces), 2):
        pieces[i] = re.sub(r"(?<=\d) (%|[mk]?Pa|mmHg|[mµk]?m|ms|s|Hz|MB|GB|ml)(?![\w/])", "\u00a0\\1", pieces[i])
        pieces[i] = re.sub(r"(?<![\w./#-])\d[\d.]*e-\d+(?![\w/-])", r'<span class="number">\g<0></span>', pieces[i])
    return "".join(pieces)


def with_mathml(text, name):
    """`$$...$$` and `$...$` outside of code as MathML."""
    pieces = re.split(CODE, text, flags=re.M | re.S)
    for i in range(0, len(pieces), 2):
        pieces[i] = re.sub(r"\$\$(.+?)\$\$", lambda m: mathml(m[1], "block", name), pieces[i], flags=re.S)
        pieces[i] = re.sub(r"\$([^\s$](?:[^$\n]*[^\s$])?)\$", lambda m: mathml(m[1], "inline", name), pieces[i])
    return "".join(pieces)


def mathml(tex, display, name):
    tool = ["blahtexml", "--mathml"]
    tex = tex.replace("\n", " ").strip()
    answer = subprocess.run(tool, input=tex, capture_output=True, text=True, check=True).stdout
    found = re.search(r"<markup>\s*(.*?)\s*</markup>", answer, re.S)
    if not found:
        sys.exit(f"build.py: {name}: blahtexml does not understand {tex}:\n{answer}")
    # Browsers draw bold letters only where they are letters of their own.
    markup = re.sub(r'<mi mathvariant="bold">(\w)</mi>', lambda m: f"<mi>{bold(m[1])}</mi>", found[1])
    equation = f'<math display="{display}">{markup}</math>'
    return f'<span class="equation">{equation}</span>' if display == "block" else equation


def bold(letter):
    first = 0x1D400 + ord(letter) - ord("A") if letter.isupper() else 0x1D41A + ord(letter) - ord("a")
    return chr(first)


class Links(HTMLParser):
    """The links and the anchors of a page."""

    def __init__(self):
        super().__init__()
        self.links, self.anchors = [], set()

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.anchors.update(value for key in ("id", "name") if (value := values.get(key)))
        link = values.get("href" if tag == "a" else "src" if tag == "img" else "")
        if link:
            self.links.append(link)


def broken_links():
    """A sentence for each link within the book that leads nowhere."""
    pages = {}
    for page in BOOK.rglob("*.html"):
        pages[page] = Links()
        pages[page].feed(page.read_text(encoding="utf-8"))
    broken = []
    for page, found in sorted(pages.items()):
        if page.name in ("404.html", "toc.html", "print.html"):
            continue
        for link in found.links:
            if re.match(r"[a-z]+:", link):
                continue
            path, _, anchor = unquote(link).partition("#")
            target = (page.parent / path).resolve() if path else page
            if not target.exists():
                broken.append(f"{page.relative_to(BOOK)}: {link} leads nowhere")
            elif anchor and target in pages and anchor not in pages[target].anchors:
                broken.append(f"{page.relative_to(BOOK)}: {link}: the page has no such heading")
    return broken


def run(*command):
    if subprocess.run(command, cwd=ROOT).returncode != 0:
        sys.exit(f"build.py: {' '.join(command)} failed")


if __name__ == "__main__":
    main()
