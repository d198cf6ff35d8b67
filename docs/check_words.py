"""Are the pages in plain English? ``python docs/check_words.py`` lists each sentence that is not.

A sentence of a guide has at most 30 words. Guides, docstrings and messages say the noun instead of
"that of", and use the words of the field. Code and formulas count as one word. A line of code has
at most 80 columns, so that no page cuts it. All pages of the site together have a limit of words.
"""

import ast
import re
import sys
import tokenize
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

ROOT = Path(__file__).parent.parent
LONGEST = 30
COLUMNS = 80
MOST = 19_000
"""Words of the pages of the site, tutorials and gallery included, without the reference."""

PHRASES = {
    r"\b(that|those) of\b": "name the noun",
    r"\bof (its|their) own\b": "name the noun",
    r"\bwanted times?\b": "say: output times",
    r"\bto the (last )?bit\b": "say: bit for bit",
    r"\b(normal|random|drawn|perturbation) laws?\b": "say: distribution",
    r"\blaws? of (the |a |their |this )*(random|perturb|noise|sampl|start|direction|map)": "say:"
    " distribution",
    r"\bsilently wrong\b": "say: undetected",
    r"\bjudged (samples|maps?|bodies)\b": "say: custom criterion",
}

PAGE_PHRASES = {
    r"\btells?\b(?! \w+ apart)": "say: shows, says",
    r"\bmend(s|ed)?\b": "say: fix, repair",
    r"\b(way|run|carry) forth\b": "say: forwards",
    r"\bfacts\b": "name them",
    r"\berrors? bounds?\b|\bbounds the (error|rounding)\b": "an error is an estimate",
    r"\b(of the|your) hands?\b": "say: perturbation",
    r"\bdisturbances?\b": "say: perturbation",
    r"\brates\b": "say: angular velocity, or components of it",
    r"\bdecisions? \d": "give the reason",
}
"""Of pages of the site: telegraphic words, and two names of one thing."""

UNSEEN = ("capabilities.md", "errata.md", "how_it_works.md")
"""What is not on the site."""

GUIDES = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md")
SOURCES = ("python/rigid", "docs/gallery")
SUFFIXES = {".html", ".js", ".py", ".pyi", ".rst", ".toml"}

Passage = tuple[str, int, str]
"""Where a passage begins (file, line), and its words without markup."""


def main() -> int:
    only = sys.argv[1:]  # patterns of paths: nothing else is checked

    def chosen(paths: Iterable[Path]) -> list[Path]:
        return [path for path in paths if not only or any(map(path.match, only))]

    guides = chosen([*map(ROOT.joinpath, GUIDES), *sorted((ROOT / "docs").glob("*.md"))])
    sources = chosen(path for folder in SOURCES for path in sorted((ROOT / folder).rglob("*.*")))
    sources = [path for path in sources if path.suffix in SUFFIXES]
    faults: list[str] = []
    sentences = longest = words = 0
    for path in guides:
        faults.extend(wide_code(path))
        is_page = path.parent.name == "docs" and path.name not in UNSEEN
        for where, line, sentence in guide_sentences(path):
            count = len(sentence.split())
            words += count * is_page
            sentences, longest = sentences + 1, max(longest, count)
            if count > LONGEST:
                faults.append(f"{where}:{line}: {count} words: {sentence}")
            faults.extend(wrong_phrases(where, line, sentence, PHRASES))
            if is_page or path.name == "README.md":
                faults.extend(wrong_phrases(where, line, sentence, PAGE_PHRASES))
    for path in sources:
        is_page = path.parent.name in ("gallery", "tutorials")
        for where, line, text in source_texts(path):
            words += len(text.split()) * is_page
            faults.extend(wrong_phrases(where, line, text, PHRASES))
    if words > MOST:
        faults.append(f"the pages of the site have {words} words, at most {MOST}: take away")
    faults = list(dict.fromkeys(faults))  # a part of an f-string is met twice
    for fault in faults:
        print(fault)
    print(
        f"{sentences} sentences of guides, the longest has {longest} words; {words} words of pages;"
        f" {len(sources)} sources; {len(faults)} faults"
    )
    if not guides and not sources:
        print(f"no file matches {only}")
        return 2
    return int(bool(faults) or (not only and sentences < 1000))


def wrong_phrases(where: str, line: int, text: str, phrases: Mapping[str, str]) -> Iterator[str]:
    """Each phrase of a list in a text, with its place and what to say instead."""
    for pattern, instead in phrases.items():
        for found in re.finditer(pattern, text, re.IGNORECASE):
            around = text[max(0, found.start() - 40) : found.end() + 40]
            yield f"{where}:{line}: '{found[0]}' ({instead}): ...{around}..."


def guide_sentences(path: Path) -> Iterator[Passage]:
    """The sentences of a page: of its paragraphs, headings, items and cells."""
    where = path.relative_to(ROOT).as_posix()
    for line, block in blocks(path.read_text(encoding="utf-8").splitlines()):
        for sentence in re.split(
            r"(?<=[.!?:;])[\"'”*_)]*\s+(?=[\"'“*_(\[]*[A-Z0-9`])", plain(block)
        ):
            if sentence.strip():
                yield where, line, sentence.strip()


def wide_code(path: Path) -> Iterator[str]:
    """Each line of a code block that is too wide."""
    fence = ""
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if re.match(r"\s*```", line):
            fence = "" if fence else line.strip()
        elif fence and "{" not in fence and len(line) > COLUMNS:
            yield f"{path.relative_to(ROOT).as_posix()}:{number}: {len(line)} columns: {line}"


def blocks(lines: list[str]) -> Iterator[tuple[int, str]]:
    """Paragraphs, items, headings and cells, with the line at which each begins."""
    fence, start, block = "", 0, []
    for number, line in enumerate(lines, 1):
        mark = re.match(r"\s*(`{3,}|~{3,}|\${2})", line)
        if fence:
            fence = "" if line.strip().startswith(fence) else fence
            continue
        ends = not line.strip() or mark or re.match(r"\s*(#|\||>|[*-] |\d+\. |<)", line)
        if ends and block:
            yield start, " ".join(block)
            block = []
        if mark:
            closed = mark[1] == "$$" and line.strip().count("$$") > 1
            fence = "" if closed else mark[1]
        elif line.lstrip().startswith("|"):
            for cell in line.strip().strip("|").split(" | "):
                yield number, cell.strip()
        elif line.strip():
            start = start if block else number
            block.append(re.sub(r"^\s*(#+|>|[*-]|\d+\.)\s+", "", line).strip())
    if block:
        yield start, " ".join(block)


def plain(text: str) -> str:
    """A passage without markup."""
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"`[^`]*`|\$[^$]*\$", "`code`", text)
    return re.sub(r"<[^>]*>|\*\*?", "", text)


def source_texts(path: Path) -> Iterator[Passage]:
    """Each string of a module, its docstrings and messages among them, and each comment.

    Of other files each line.
    """
    where = path.relative_to(ROOT).as_posix()
    text = path.read_text(encoding="utf-8")
    if path.suffix not in (".py", ".pyi"):
        yield from ((where, number, line) for number, line in enumerate(text.splitlines(), 1))
        return
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.JoinedStr):
            parts = [p.value if isinstance(p, ast.Constant) else "x" for p in node.values]
            yield where, node.lineno, " ".join("".join(map(str, parts)).split())
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield where, node.lineno, " ".join(node.value.split())
    with tokenize.open(path) as file:
        for token in tokenize.generate_tokens(file.readline):
            if token.type == tokenize.COMMENT:
                yield where, token.start[0], token.string


if __name__ == "__main__":
    sys.exit(main())
