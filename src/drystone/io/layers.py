"""Layers of CAD files: which are read, which hold their blocks, and notes on the others."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from drystone.base.errors import FormatError, counted

_HELD = ("support", "supports", "fixed", "ground")


def holds(layer: str) -> bool:
    """Whether the blocks of a layer are fixed, by its name without those of the layers above it."""
    return layer.rpartition("::")[2].lower() in _HELD


def hidden_notes(unread: Mapping[str, int]) -> list[str]:
    """Notes on the number of hidden objects of each layer."""
    return [
        f"{counted(count, 'hidden object')} left out on layer '{layer}'"
        for layer, count in unread.items()
    ]


def require_blocks(
    shapes: Sequence[object],
    layers: Sequence[str],
    known: Collection[str],
    unread: Mapping[str, int],
    path: Path,
) -> None:
    """Refuse a file without blocks on the layers that are read.

    Parameters
    ----------
    shapes
    layers
        Those that were asked for; all visible ones when empty.
    known
        Those of the file.
    unread
        Number of hidden objects, by layer.
    path
    """
    if not shapes and layers:
        wanted, has = (", ".join(f"'{one}'" for one in names) for names in (layers, known))
        raise FormatError(
            f"holds no block on layer {wanted}",
            where=str(path),
            remedy=f"its layers are {has or 'none'}",
        )
    if not shapes and unread:
        total = counted(sum(unread.values()), "object")
        raise FormatError(
            f"holds no visible block; {total} hidden on layers {', '.join(map(repr, unread))}",
            where=str(path),
            remedy="read them with --layer NAME or --hidden, or show them in the drawing",
        )
