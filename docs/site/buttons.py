"""Buttons that open the notebook of the examples where nothing has to be installed."""

import re
from urllib.parse import quote


def buttons(address: str) -> str:
    """The buttons for the address of a repository; without one on GitHub, what has to be set."""
    notebook = "examples/notebook.ipynb"
    place = re.fullmatch(r"https://github\.com/([\w.-]+/[\w.-]+?)(\.git)?/?", address)
    if place is None:
        return (
            "The buttons appear once `[project.urls]` of `pyproject.toml` has a `Repository` "
            "on GitHub and the site is built anew."
        )
    binder = f"https://mybinder.org/v2/gh/{place[1]}/HEAD?labpath={quote(notebook, safe='')}"
    colab = f"https://colab.research.google.com/github/{place[1]}/blob/HEAD/{notebook}"
    return f"[Open in Binder]({binder}) · [Open in Colab]({colab})"
