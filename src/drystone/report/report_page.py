"""A document as a page of HTML that prints on A4."""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping

from drystone.base.table import Table
from drystone.report.document import Document, Heading, Part, Picture
from drystone.view.joint_page import plan_figure

_STYLE = """
@page { size: A4; margin: 20mm 18mm; }
body { font: 14px/1.45 system-ui, sans-serif; color: #1d1b18; background: #ffffff;
  max-width: 46rem; margin: 1.5rem auto; padding: 0 1rem; overflow-wrap: anywhere; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.1rem; border-bottom: 1px solid #1d1b18;
  margin-top: 1.8rem; } h3 { font-size: 1rem; }
h2, h3 { break-after: avoid; }
img { width: 100%; height: auto; } figcaption, caption { font-size: .85em; text-align: left;
  color: #45423d; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; width: 100%; font-size: .85em;
  margin: .5rem 0; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .15rem .5rem;
  border-bottom: 1px solid #b9b5ab; overflow-wrap: anywhere; }
tr, figure { break-inside: avoid; } figure { margin: .5rem 0; }
.plans { display: flex; flex-wrap: wrap; gap: .75rem; } .plans figure { width: 150px; }
.stone { fill: #e4e4e4; stroke: #000; } .kern { fill: none; stroke: #000;
  stroke-dasharray: 4 3; } .force { fill: #000; stroke: #fff; }
"""


def html_of(document: Document) -> str:
    """The page as text; it asks nothing of the network."""
    title = html.escape(document.title)
    parts = [f"<h1>{title}</h1>", _part(document.entries)]
    for section in document.sections:
        parts.append(f"<h2>{html.escape(section.title)}</h2>")
        parts += [_part(one) for one in section.parts]
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{title}</title><style>{_STYLE}</style></head><body>"
        f"{''.join(parts)}<p><small>{html.escape(document.foot)}</small></p></body></html>\n"
    )


def _part(part: Part) -> str:
    match part:
        case str():
            return f"<p>{html.escape(part)}</p>"
        case Heading():
            return f"<h3>{html.escape(part.text)}</h3>"
        case Table():
            return f'<div class="scroll">{part.to_html()}</div>'
        case Picture():
            data = base64.b64encode(part.png).decode("ascii")
            told = html.escape(part.caption)
            return (
                f'<figure><img alt="{told}" src="data:image/png;base64,{data}">'
                f"<figcaption>{told}</figcaption></figure>"
            )
        case Mapping():
            rows = (
                f"<tr><th>{html.escape(name)}</th><td>{html.escape(text)}</td></tr>"
                for name, text in part.items()
            )
            return f"<table>{''.join(rows)}</table>"
    return f'<div class="plans">{"".join(map(plan_figure, part))}</div>'
