"""The live page: the page of a model with a strip of controls, and a stream of answers."""

from __future__ import annotations

import json
from importlib import resources

from drystone.live.desk import Desk
from drystone.view.web.page import Addition, page_of_data

SCRIPTS = (
    "live-stream.js", "live-state.js", "live-picture.js", "live-push.js", "live-lists.js",
    "live-controls.js",
)  # fmt: skip
"""In the order in which they are put into the page, after those of every page."""


def page_of(desk: Desk) -> str:
    """The page of the model of the file as it was read last."""
    static = resources.files("drystone.live").joinpath("static")

    def read(name: str) -> str:
        return static.joinpath(name).read_text(encoding="utf-8")

    number = desk.current
    kept = desk.models[number]
    begins = json.dumps({"model": number, "name": desk.file.name, "facts": kept.facts})
    for sign in "<>&":
        begins = begins.replace(sign, f"\\u{ord(sign):04x}")
    begins = begins.replace("{{", "{\\u007b")  # a name, and no mark of the page
    controls = read("strip.html").replace("{{BEGINS}}", begins)
    script = "\n".join(read(name) for name in SCRIPTS)
    added = Addition(controls, read("live.css"), script, connects=True)
    return page_of_data(kept.scene, f"drystone live: {desk.file.name}", added=added)


__all__ = ["page_of"]
