"""A JSON file of drystone, of COMPAS or of bricks, told apart by what it holds."""

from __future__ import annotations

from pathlib import Path

from drystone.io import bricks, compas_json, drystone_json, jsontext
from drystone.io.draft import Draft


def read(data: bytes, path: Path) -> Draft:
    """The draft of any of the JSON formats."""
    top = jsontext.parse(data, path)
    if bricks.is_list(top):
        return bricks.from_json(top)
    return compas_json.read(top) if compas_json.is_compas(top) else drystone_json.read(top)
