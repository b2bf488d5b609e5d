"""The page: sections as HTML that needs no network, no script and no other file. All text is escaped."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from html import escape

from porous_swim.core.console import printable
from porous_swim.reporting.pictures import Picture
from porous_swim.reporting.section import Cell, Number, Section, Table

LONG = 30  # rows from which a table scrolls within the page

_STYLE = """
:root { color-scheme: light; --ink: #1c2430; --soft: #5a6675; --line: #d9dee6; --ground: #f6f7f9; --warn: #fff4e5; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 74rem; padding: 1.5rem 1.5rem 4rem; color: var(--ink); background: #fff;
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif; }
h1 { font-size: 1.7rem; margin: 0 0 .2rem; overflow-wrap: anywhere; }
h2 { font-size: 1.25rem; margin: 2.6rem 0 .6rem; padding-top: .6rem; border-top: 1px solid var(--line); }
p { margin: .4rem 0; max-width: 60rem; overflow-wrap: anywhere; }
.lead, figcaption, caption { color: var(--soft); }
nav { margin: 1rem 0; font-size: .92rem; }
nav a { margin-right: 1rem; white-space: nowrap; color: #0b5394; }
.warnings { background: var(--warn); border-left: 4px solid #d55e00; padding: .5rem 1rem; margin: 1rem 0; }
.warnings ul { margin: .2rem 0; padding-left: 1.2rem; }
.missing { color: var(--soft); font-style: italic; }
figure { margin: 1rem 0; }
figure img { display: block; max-width: 100%; height: auto; }
figcaption, caption { font-size: .88rem; text-align: left; padding: .3rem 0; }
.table { overflow: auto; margin: .8rem 0; }
.table.long { max-height: 34rem; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; padding: .3rem .9rem .3rem 0; border-bottom: 1px solid var(--line); vertical-align: top; }
th { font-weight: 600; white-space: nowrap; }
thead th { position: sticky; top: 0; background: #fff; border-bottom: 2px solid var(--line); }
tbody th { font-weight: 400; white-space: normal; }
data { white-space: nowrap; }
td small { display: block; color: var(--soft); white-space: nowrap; }
td small.warning { color: #a33c00; white-space: normal; min-width: 16rem; max-width: 30rem; }
pre { background: var(--ground); padding: .8rem 1rem; overflow: auto; font-size: .84rem; }
summary { cursor: pointer; color: #0b5394; margin: .6rem 0; }
@media print { body { max-width: none; } nav { display: none; } .table.long { max-height: none; }
  figure, table { break-inside: avoid; } }
"""


def html(
    title: str, lead: str, sections: Sequence[Section], pictures: Mapping[str, Picture], warnings: Sequence[str]
) -> str:
    """The whole page; `pictures` by the names of their sections."""
    links = "\n".join(f'<a href="#{section.name}">{_text(section.title)}</a>' for section in sections)
    body = "".join(_section(section, pictures.get(section.name)) for section in sections)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<link rel="icon" href="data:,">\n<title>{_text(title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n'
        f'<header>\n<h1>{_text(title)}</h1>\n<p class="lead">{_text(lead)}</p>\n</header>\n<nav>{links}</nav>\n'
        f"{_warnings(warnings)}<main>\n{body}</main>\n</body>\n</html>\n"
    )


def _text(text: str) -> str:
    """Any text as the page holds it."""
    return escape(printable(text))


def _warnings(warnings: Sequence[str]) -> str:
    if not warnings:
        return ""
    items = "".join(f"<li>{_text(warning)}</li>\n" for warning in warnings)
    return f'<div class="warnings" role="note"><strong>Warnings</strong>\n<ul>\n{items}</ul></div>\n'


def _section(section: Section, picture: Picture | None) -> str:
    parts = [f"<p>{_text(text)}</p>\n" for text in section.text]
    if picture is not None:
        parts.append(_figure(section, picture))
    parts += [f'<p class="missing">{_text(text)}</p>\n' for text in section.missing]
    parts += [_table(table) for table in section.tables]
    parts += [
        f"<details><summary>{_text(heading)}</summary>\n<pre>{_text(text)}</pre></details>\n"
        for heading, text in section.listings
    ]
    return f'<section id="{section.name}">\n<h2>{_text(section.title)}</h2>\n{"".join(parts)}</section>\n'


def _figure(section: Section, picture: Picture) -> str:
    data = base64.b64encode(picture.content).decode("ascii")
    return (
        f'<figure><img alt="{_text(section.title)}" width="{picture.width}" height="{picture.height}" '
        f'src="data:{picture.mime};base64,{data}">\n<figcaption>{_text(section.caption)}</figcaption></figure>\n'
    )


def _table(table: Table) -> str:
    head = "".join(f'<th scope="col">{_text(name)}</th>' for name in table.header)
    rows = "".join(
        f'<tr><th scope="row">{_cell(row[0])}</th>{"".join(f"<td>{_cell(cell)}</td>" for cell in row[1:])}</tr>\n'
        for row in table.rows
    )
    caption = f"<caption>{_text(table.caption)}</caption>" if table.caption else ""
    kind = "table long" if len(table.rows) > LONG else "table"
    return (
        f'<div class="{kind}"><table>{caption}\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n'
    )


def _cell(cell: Cell) -> str:
    if not isinstance(cell, Number):
        return _text(cell)
    note = f"<small>{_text(cell.note)}</small>" if cell.note else ""
    note += f'<small class="warning">warning: {_text(cell.warning)}</small>' if cell.warning else ""
    if math.isfinite(cell.value):
        return f'<data value="{cell.value!r}">{_text(cell.text)}</data>{note}'
    return f"{_text(cell.text)}{note}"
