"""Calls of the JSON interface: one after the other, in a process of their own."""

from __future__ import annotations

import json
import threading
from typing import Any

from drystone.live.computing.helper import Helper
from drystone.mcp.folder import Folder

WAITING = 8
"""Calls that may wait for the one that is computed, chosen."""


class ToolCalls:
    """The process is started with the first call."""

    def __init__(self, folder: Folder, seconds: float) -> None:
        self.folder, self.seconds = folder, seconds
        self.helper = Helper()
        self._one = threading.Lock()
        self._room = threading.BoundedSemaphore(WAITING)

    def call(self, tool: str, body: bytes) -> tuple[int, str]:
        """The status of the protocol and the answer, or an error in words."""
        if not self._room.acquire(blocking=False):
            return 503, _error(f"{WAITING} calls are waiting", "try again")
        try:
            with self._one:
                heard: list[dict[str, Any]] = []
                message = {"do": "tool", "tool": tool, "body": body, "folder": self.folder,
                           "seconds": self.seconds}  # fmt: skip
                self.helper.run(message, heard.append, 1.2 * self.seconds)
        finally:
            self._room.release()
        for event in heard:
            if event["event"] == "answer":
                return 200, str(event["answer"])
            if event["event"] == "error":
                status = 504 if event.get("late") else 400
                return status, _error(event["what"], event["remedy"], event["where"])
        return 503, _error("the server is closing", "start it again")

    def close(self) -> None:
        """End the process."""
        self.helper.close()


def _error(what: str, remedy: str, where: str = "") -> str:
    return json.dumps({"error": {"what": what, "where": where, "remedy": remedy}})
