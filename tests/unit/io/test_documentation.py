"""The documentation of files says what is so."""

import re
from pathlib import Path

import pytest

from drystone import io

ROOT = Path(__file__).parents[3]


def text() -> str:
    return (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")


def test_the_first_example_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code = re.findall(r"```python\n(.*?)```", text(), re.DOTALL)[0]
    exec(compile(code, "formats.md", "exec"), {})
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"arch.obj", "arch.json", "arch-dem.json"}
    assert io.read_file("arch.json").results[0].verdict == "stable"


def test_every_format_is_in_the_table() -> None:
    rows = re.findall(r"^\| `([\w-]+)` \| `(\.\w+)", text(), re.MULTILINE)
    assert {name for name, _ in rows} == {known.name for known in io.FORMATS}
    for name, suffix in rows:
        known = io.format_of("x", name)
        assert not known.suffixes or suffix in known.suffixes
