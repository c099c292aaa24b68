"""drystone in Grasshopper: a script component that asks a server on this machine.

For the Python 3 script component of Rhino 8. It was NOT run in Rhino: there was none where it was
written. The part that needs no Rhino is tested.

1. Start the server beside any model: ``drystone live model.obj``. It prints a link.
2. Put ``drystone_rhino.py``, and the client that ``drystone live --client drystone_client.py``
   writes, into Rhino's folder ``scripts``, where its Python looks for modules.
3. Give the component the inputs ``blocks`` and ``supports`` (lists of meshes or Breps),
   ``friction`` (number) and ``link`` (text), and the outputs ``verdict``, ``message``, ``falling``.
4. Paste this file into it.

Closed meshes and Breps with plane faces are blocks. ``falling`` has the first 20 blocks that fall.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def asked(
    blocks: Sequence[Any], supports: Sequence[Any], friction: float, link: str
) -> tuple[str, str, list[Any]]:
    """Verdict, message and falling geometry of shapes of the open document."""
    import drystone_client
    from drystone_rhino import model_of, named, unit_of_document

    model = model_of(blocks, supports, friction, unit_of_document())
    answer = drystone_client.Server(link).check(model)
    return answer["verdict"], answer["message"], named(answer["falling"]["first"], blocks)


if "ghenv" in globals():  # inside a component, whose inputs are global names
    given = globals()
    verdict, message, falling = asked(
        given["blocks"], given["supports"], given["friction"], given["link"]
    )
