"""Errors keep what they know on their way to the user."""

import pickle

from drystone.base.errors import DefectKind, FormatError, InputError


def test_errors_come_back_from_another_process_whole() -> None:
    error = FormatError("is open", where="a.obj", remedy="close it", kind=DefectKind.OPEN)
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is FormatError
    assert (str(again), again.kind) == ("a.obj: is open; close it", DefectKind.OPEN)


def test_a_fault_is_located_without_losing_its_kind() -> None:
    error = InputError("is open", remedy="close it", kind=DefectKind.OPEN).located("block 'a'")
    assert (str(error), error.kind) == ("block 'a': is open; close it", DefectKind.OPEN)
