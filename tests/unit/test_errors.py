"""Errors keep what they know on their way to the user."""

import pickle

import pytest

from drystone import FormatError, InputError, MissingDependency
from drystone.base.errors import DefectKind, one_line_errors, printable


def test_errors_come_back_from_another_process_whole() -> None:
    error = FormatError("is open", where="a.obj", remedy="close it", kind=DefectKind.OPEN)
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is FormatError
    assert (str(again), again.kind) == ("a.obj: is open; close it", DefectKind.OPEN)
    missing = MissingDependency("mujoco", extra="fall", purpose="a film")
    assert str(pickle.loads(pickle.dumps(missing))) == str(missing)


def test_a_fault_is_located_without_losing_its_kind() -> None:
    error = InputError("is open", remedy="close it", kind=DefectKind.OPEN).located("block 'a'")
    assert (str(error), error.kind) == ("block 'a': is open; close it", DefectKind.OPEN)


def fail(what: str) -> None:
    with one_line_errors():
        raise FormatError(what, where="model.json", remedy="mend it")


def test_errors_that_quote_a_file_keep_to_one_short_line() -> None:
    with pytest.raises(FormatError) as caught:
        fail("block 'a\nb\x1b' is " + "very " * 1000 + "bad")
    assert "\n" not in str(caught.value)
    assert "\x1b" not in str(caught.value)
    assert len(str(caught.value)) < 400
    assert str(caught.value).startswith("model.json: block 'a?b?' is very")
    assert str(caught.value).endswith("bad; mend it")


def test_clear_errors_pass_as_they_are() -> None:
    with pytest.raises(FormatError, match=r"model\.json: it is bad; mend it") as caught:
        fail("it is bad")
    assert caught.value.__cause__ is None


def test_short_text_is_left_alone() -> None:
    assert printable("Größe 壁") == "Größe 壁"


def test_what_an_error_quotes_is_cut_where_it_is_too_long() -> None:
    error = InputError(f"there is no block '{'9' * 5000}'", where="x" * 5000)
    assert len(str(error)) < 1000
    assert str(error.located("supports")).startswith("supports: there is no block '999")
