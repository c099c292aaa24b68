"""Names of blocks that were made to do harm, and a structure that has them."""

from __future__ import annotations

from dataclasses import replace

from drystone import Assembly, Model
from drystone.models import tower

FIRES = "window.fired = true"
NAMES = (
    f"</script></style></title></textarea></svg><script>{FIRES}</script>",
    f"<img src=x onerror='{FIRES}'><svg onload='{FIRES}'><iframe srcdoc='<script>{FIRES}'>",
    f"\" autofocus onfocus=\"{FIRES}\" onmouseover='{FIRES}' style='position:fixed;inset:0' x=`",
    f"${{{FIRES}}} {{{{constructor.constructor('{FIRES}')()}}}} %s {{0}} DATA PACKED",
    f"javascript:{FIRES}//<!-- --!> <![CDATA[ ]]> &lt;b&gt; \\u003cscript\\u003e",
    "\u202egnorw eht yaw dnuor\u202c \u2066\u2067 \u200f \ufeff",
    "n" * 10_000,
    "many words " * 900,
    "two\nlines\r\nand\ttabs \u2028 \u2029 \x0b \x85",
    "nul \0 bell \a escape \x1b[31m delete \x7f",
    "half a letter \ud800 \udfff",
    "o\u0300\u0301\u0302\u0303" * 300,
)


def hostile_model() -> Model:
    """A tower of blocks with these names, which are its metadata too."""
    plain = tower(len(NAMES) + 1)
    names = ("the lowest", *NAMES)
    blocks = tuple(
        replace(block.renamed(name), metadata={name: name})
        for block, name in zip(plain.blocks, names, strict=True)
    )
    return Model.of(Assembly(blocks, plain.fixed), friction=0.6)
