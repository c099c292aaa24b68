"""Notebooks are run as a user runs them; the widget answers. Skipped where extras are missing."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import pytest

import drystone
from drystone import InputError, MissingDependency
from drystone.models import arch, tower
from drystone.view import interact, notebook

EXAMPLES = Path(__file__).parents[2] / "examples"
MODEL = drystone.Model.of(arch(0.2, 8), friction=0.7)


def checked(friction: float) -> drystone.Result:
    return drystone.check(MODEL.with_friction(friction))


@pytest.mark.filterwarnings("ignore")
def test_the_jupyter_notebook_runs_and_shows_pages(tmp_path):
    nbformat = pytest.importorskip("nbformat", reason="no nbformat (Jupyter)")
    nbclient = pytest.importorskip("nbclient", reason="no nbclient (Jupyter)")
    pytest.importorskip("ipykernel", reason="no ipykernel (Jupyter)")
    pytest.importorskip("anywidget", reason="no anywidget, the extra 'notebook'")
    content = nbformat.read(EXAMPLES / "notebook.ipynb", as_version=4)
    where: dict[str, Any] = {"metadata": {"path": str(tmp_path)}}
    done = nbclient.NotebookClient(content, timeout=300, resources=where).execute()
    outputs = [cell.outputs for cell in done.cells if cell.cell_type == "code"]
    pages = [
        out.data["text/html"]
        for cell in outputs
        for out in cell
        if "text/html" in out.get("data", {})
    ]
    assert sum("<iframe" in page for page in pages) == 4  # model, result, limit, show
    assert any("anywidget" in str(out) or "widget-view" in str(out) for out in outputs)
    assert "UNSTABLE" in str(outputs[-1])
    assert sum(map(len, pages)) < 1_000_000


@pytest.mark.filterwarnings("ignore")
def test_the_marimo_notebook_runs():
    pytest.importorskip("marimo", reason="no marimo")
    pytest.importorskip("anywidget", reason="no anywidget, the extra 'notebook'")
    app = runpy.run_path(str(EXAMPLES / "notebook_marimo.py"))["app"]
    _, found = app.run()
    assert found["result"].stable
    assert found["told"] == "click a block"


def test_a_slider_asks_python_again_and_trouble_is_told():
    pytest.importorskip("anywidget", reason="no anywidget, the extra 'notebook'")
    live = interact(checked, friction=(0.0, 0.9, 0.7))
    page = live.page
    assert live.subject.stable
    assert live.names == list(MODEL.assembly.names)
    live.values = {"friction": 0.1}
    assert live.subject.verdict == "unstable"
    assert live.page != page
    live.values = {"friction": -1.0}
    assert "friction" in live.trouble
    assert live.subject.verdict == "unstable"  # the last answer stays
    live.values = {"friction": 0.7}
    assert (live.trouble, live.page) == ("", page)


def test_ranges_are_checked_before_anything_is_asked():
    for ends in ((0.9, 0.1, 0.5), (0.1, 0.9, 1.0), (0.1, 0.1, 0.1), (0.1, 0.9)):
        with pytest.raises(InputError, match="the range of 'friction'"):
            interact(checked, friction=ends)  # type: ignore[arg-type]


def test_without_anywidget_its_extra_is_named(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda *_: None)
    with pytest.raises(MissingDependency, match=r"\.\[notebook\]"):
        interact(checked, friction=(0.1, 0.9, 0.7))


def test_outside_a_notebook_a_page_is_opened_in_the_browser(monkeypatch):
    asked: list[str] = []
    monkeypatch.setattr(notebook, "in_notebook", lambda: False)
    monkeypatch.setattr("webbrowser.open", lambda url: not asked.append(url))
    drystone.show(tower(2))
    path = Path(asked[0].removeprefix("file://"))
    assert path.read_text(encoding="utf-8").startswith("<!doctype html>")
    path.unlink()
    monkeypatch.setattr("webbrowser.open", lambda _: False)
    with pytest.raises(InputError, match=r"no browser was found; open .*\.html") as told:
        drystone.show(tower(2))
    Path(str(told.value.remedy).split()[1]).unlink()
