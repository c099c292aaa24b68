"""Buttons that open the notebook of the examples where nothing has to be installed."""

import re
from urllib.parse import quote


def buttons(repository: str) -> str:
    """The buttons for ``OWNER/NAME`` on GitHub; without such a repository, where they are."""
    if not re.fullmatch(r"[\w.-]+/[\w.-]+", repository):
        return "The buttons for Binder and Colab are on the site that the workflow *Pages* builds."
    notebook = "examples/notebook.ipynb"
    binder = f"https://mybinder.org/v2/gh/{repository}/HEAD?labpath={quote(notebook, safe='')}"
    colab = f"https://colab.research.google.com/github/{repository}/blob/HEAD/{notebook}"
    return (
        f"[Open in Binder]({binder}) · [Open in Colab]({colab}), with "
        f"`%pip install git+https://github.com/{repository}` in a first cell."
    )
