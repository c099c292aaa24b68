"""Source, documentation and tests use the words of the glossary and plain English."""

import functools
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = ("src", "docs", "tests", "examples", "benchmarks", "README.md", "CHANGELOG.md")

EVERYWHERE = {
    # the glossary has another word
    r"heaps?": "soup (faces of a file), pile (loose blocks), queue (of a search)",
    r"(?<!\.)registers?(?!\()": "joggle; a call of a function of this name is left out",
    r"eigenstress(es)?": "prestress",
    r"judg(e|es|ed|ing|ement|ements)": "check, verdict, compare with a tolerance",
    r"glanc(e|es|ed|ing)|hast(y|ily)": "the name of a screening level",
    r"(least)?_lack|lacking": "elastic infeasibility",
    # words that an engineer need not know, or that say nothing
    r"dear(er|est|ly)?": "costs more",
    r"believ(e|es|ed|ing)": "checked, assumed",
    r"whither|hither|thither|whence|wherefrom|lest|hereabouts": "where, so, there",
    r"there(by|in|of|upon|from)|where(by|in|of|upon)": "so, in it, with which",
    r"befell?": "happened to",
    r"for want of|as it were|so to speak|to speak of|next to nothing|made up its mind": "",
    r"let go of|in vain": "released, without result",
    r"the more of .{1,30} the (smaller|larger)": "an equation",
}
"""Patterns of words, and what to write instead."""

SOURCE = {
    r"lack(s|ed)?": "has no, is missing",
    r"(is|are|was) told of": "is listed in",
    r"(knows|wants|believes|feels) (no|its|their) (block|joint|corner)s?": "blocks are no persons",
    r"of which (one|all|some|each|every|none)": "two sentences",
    r"in the air": "without contact",
}
"""The same, in source and documentation only: names of tests may tell a story."""


@functools.cache
def texts(*folders: str) -> dict[str, str]:
    """Text files under version control, by name; this file is left out. None without git."""
    if shutil.which("git") is None:
        return {}
    names = subprocess.run(
        ["git", "ls-files", "-z", *folders], cwd=ROOT, capture_output=True, text=True, check=False
    ).stdout.split("\0")
    chosen = [
        n for n in names if n.endswith((".py", ".md")) and Path(n).name != Path(__file__).name
    ]
    return {name: (ROOT / name).read_text(encoding="utf-8") for name in chosen}


def found(pattern: str, files: dict[str, str]) -> list[str]:
    """Places at which a pattern occurs as whole words, across line ends too."""
    inside = rf"(?:{pattern})\b".replace(" ", r"\s+")
    words = re.compile(rf"\b{inside}", re.IGNORECASE)
    quick = re.compile(inside)  # also within a word, of small letters: a third of the time
    return [
        f"{name}, line {text.count(chr(10), 0, match.start()) + 1}: {match.group(0)}"
        for name, text in files.items()
        if quick.search(text.lower())
        for match in words.finditer(text)
    ]


@pytest.mark.parametrize("pattern", EVERYWHERE)
def test_no_file_has_an_excluded_word(pattern: str) -> None:
    places = found(pattern, texts(*FOLDERS))
    assert not places, f"write: {EVERYWHERE[pattern] or 'something plainer'}"


@pytest.mark.parametrize("pattern", SOURCE)
def test_source_and_documentation_have_no_excluded_word(pattern: str) -> None:
    places = found(pattern, texts("src", "docs", "examples", "README.md", "CHANGELOG.md"))
    assert not places, f"write: {SOURCE[pattern]}"


def test_a_word_is_found_across_lines_and_in_any_case() -> None:
    text = {"a.md": "A Heap of\nstones. It is for want\nof a better word."}
    assert found("heaps?", text) == ["a.md, line 1: Heap"]
    assert found("for want of", text) == ["a.md, line 2: for want\nof"]


def test_files_are_searched() -> None:
    names = texts(*FOLDERS)
    if not names:  # not a git checkout
        pytest.skip("no files under version control")
    assert {"README.md", "docs/concepts/glossary.md"} <= set(names)
