"""Why a figure of ours differs from the published one, a sentence each."""

from __future__ import annotations

EXPLANATIONS: dict[tuple[str, str], str] = {
    ("concave-long y mu 0.84", "5.6"): (
        "checked states of eq. 5.6 reach beyond the published CRA (a whole degree) and stay below "
        "3DEC: the plank slides out of the slab, held by the couple of its overhang."
    ),
    ("curve-3-blocks x mu 0.84", "5.6"): (
        "checked states of eq. 5.6 reach beyond the published whole degree: the cradle slides "
        "along the strips of its bed, and how far it turns while it does depends on how the "
        "friction is shared between them."
    ),
    ("curve-3-blocks x mu 0.84", "3DEC"): (
        "the tangential stiffness decides: ours is a tenth of the normal one; with the two equal "
        "the limit is 25.0, next to the whole degree of 3DEC."
    ),
}
"""By study and column."""
