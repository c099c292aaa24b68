"""The loop of docs/how-to/region-by-region.md, command by command."""

import re
import shlex
from pathlib import Path

import pytest

import drystone
from drystone import InputError
from drystone.cli import main
from drystone.models import shelf

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "region-by-region.md"


def test_the_loop_of_the_page_ends_with_a_shelf_that_stands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Three seconds of CPU: two searches of mends, each of one kind on one block."""
    lines = re.findall(r"^ {7}drystone (.*)$", PAGE.read_text("utf-8"), re.MULTILINE)
    assert len(lines) == 8
    monkeypatch.chdir(tmp_path)
    told = []
    for line in lines:
        if "--apply" not in line and line.startswith("mend"):
            continue  # the same search as that of the next line
        words = shlex.split(line)
        if "--html" in words:
            words = words[: words.index("--html")]
        told.append((words[0], main(words), capsys.readouterr().out))
    assert [(name, code) for name, code, _ in told] == [
        ("models", 0), ("check", 1), ("forces", 1), ("mend", 0), ("check", 1), ("mend", 0),
        ("check", 0),
    ]  # fmt: skip
    assert re.search(r"block-9 .*\n *block-10 ", told[1][2])
    assert not re.search(r"^ *block-9 ", told[4][2], re.MULTILINE)
    assert "5 of 5 tried" in told[6][2]


def test_all_blocks_are_fixed_but_those_that_are_isolated(tmp_path: Path) -> None:
    alone = drystone.check(shelf(), friction=0.9, isolate="block-9")
    assert alone.falling_names == ("block-9",)
    assert (~alone.assembly.fixed).sum() == 1
    held = drystone.solve_cra_penalty(shelf(), friction=0.9, isolate="block-9").prop
    assert held is not None
    assert (held[:, :3] ** 2).sum() ** 0.5 == pytest.approx(28.5, abs=0.1)
    drystone.write(shelf(), tmp_path / "shelf.json")
    model = drystone.read(tmp_path / "shelf.json", friction=0.9, isolate=["block-9", "block-1*"])
    free = [name for name, still in zip(model.assembly.names, model.assembly.fixed, strict=True)
            if not still]  # fmt: skip
    assert free == ["block-1", "block-9", "block-10"]
    assert "all blocks are fixed but block-1, block-9, block-10" in model.notes
    assert drystone.check(model, isolate="block-1").stable


def test_a_support_or_an_unknown_block_cannot_be_isolated() -> None:
    with pytest.raises(InputError, match=r"isolate.*is a support"):
        drystone.check(shelf(), isolate="frame")
    with pytest.raises(InputError, match=r"isolate.*blok"):
        drystone.check(shelf(), isolate="blok")
