"""The count of the package that .ci/run holds against .ci/size.toml."""

import runpy
from pathlib import Path

SIZE = runpy.run_path(str(Path(__file__).parents[2] / ".ci" / "size.py"))

SOURCE = '''"""A module."""

from dataclasses import dataclass

MOST = 3
"""A bound."""
NAME = "no number"

@dataclass
class Pair:
    """Two."""

    one: int
    other: int = 2  # a comment


def simple(a):
    """Say yes."""
    return a


def many(a):
    if a or a or a or a or a or a or a or a or a or a:
        return 1
'''


def test_code_constants_fields_and_complex_functions_are_counted() -> None:
    assert SIZE["size_of"](SOURCE) == {
        "code": 13,
        "files": 1,
        "constants": 1,
        "fields": 2,
        "complex": 1,
    }


def test_what_grew_is_told_and_what_shrank_can_be_lowered() -> None:
    bounds = {"code": 11, "files": 1, "constants": 5, "fields": 2, "complex": 1}
    grown, lower = SIZE["sentences"](SIZE["size_of"](SOURCE), bounds)
    assert grown == [
        "lines of code: 13, 2 more than the 11 of .ci/size.toml. Take something away; "
        "or raise 'code' there, and say why in the commit."
    ]
    assert lower == ["numeric constants at module level: 1. 'constants' in .ci/size.toml can be 1."]
