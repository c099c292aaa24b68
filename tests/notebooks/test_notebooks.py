"""The widget of notebooks answers. Skipped where its extra is missing."""

from __future__ import annotations

from pathlib import Path

import pytest

import drystone
from drystone import InputError, MissingDependency
from drystone.models import arch, tower
from drystone.view import interact, notebook

MODEL = drystone.Model.of(arch(0.2, 8), friction=0.7)


def checked(friction: float) -> drystone.Result:
    return drystone.check(MODEL.with_friction(friction))


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
