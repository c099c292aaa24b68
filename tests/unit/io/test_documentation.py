"""The documentation of files says what is so."""

import re
from pathlib import Path
from typing import Any

import pytest

import drystone
from benchmarks import fuzz
from drystone import io

ROOT = Path(__file__).parents[3]


def text() -> str:
    return (ROOT / "docs" / "reference" / "formats.md").read_text(encoding="utf-8")


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


def test_the_example_of_step_ifc_and_dae_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("cascadio")
    pytest.importorskip("ifcopenshell")
    monkeypatch.chdir(tmp_path)
    for name in ("step", "ifc", "dae"):
        content = fuzz.SMALL[name][0]
        Path({"step": "bridge", "ifc": "house", "dae": "wall"}[name] + f".{name}").write_bytes(
            content
        )
    (code,) = re.findall(r"```python\n# needs bridge\.step(.*?)```", text(), re.DOTALL)
    names: dict[str, Any] = {}
    exec(compile(f"#{code}", "formats.md", "exec"), names)
    assert names["bridge"].assembly.fixed.tolist() == [True, False]
    assert "foot" in names["house"].assembly.names
    assert len(names["wall"].assembly) == 2


def test_the_example_of_usd_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pxr")
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "reference" / "scenes.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(# needs usd-core.*?)```", page, re.DOTALL)
    exec(compile(code, "scenes.md", "exec"), {"Path": Path, "drystone": drystone})
    assert capsys.readouterr().out == "stable\n"
