"""HTML from words: everything escaped, so that no name of a file can become markup."""

from collections.abc import Iterable, Sequence
from html import escape

LEFT, RIGHT = 'style="text-align:left"', 'class="number" style="text-align:right"'


class Markup(str):
    """Text that is HTML already, which `cell` leaves as it is."""


def cell(value: object) -> str:
    """Return a value as HTML: `Markup` as it is, anything else as escaped text.

    Examples
    --------
    >>> cell("a < b"), cell(Markup("<b>a</b>"))
    ('a &lt; b', '<b>a</b>')
    """
    return value if isinstance(value, Markup) else escape(str(value))


def table(
    heads: Sequence[object], rows: Iterable[Sequence[object]], numbers: Iterable[int] = ()
) -> Markup:
    """Return a table; columns of ``numbers`` are aligned to the right, in notebooks too.

    Parameters
    ----------
    heads : sequence
        A word a column; without any there is no head.
    rows : iterable of sequences
        As many values each, see `cell`.
    numbers : iterable of int
        Indices of columns.

    Examples
    --------
    >>> print(table([], [["<floor>", 3]], numbers=[1]))
    <table><tbody>
    <tr><td style="text-align:left">&lt;floor&gt;</td><td class="number" ...>3</td></tr>
    </tbody></table>
    """
    right = set(numbers)

    def line(values, tag):
        marks = (RIGHT if k in right else LEFT for k in range(len(values)))
        cells = (f"<{tag} {m}>{cell(v)}</{tag}>" for m, v in zip(marks, values, strict=True))
        return f"<tr>{''.join(cells)}</tr>"

    head = f"<thead>{line(heads, 'th')}</thead>" if heads else ""
    body = "\n".join(line(row, "td") for row in rows)
    return Markup(f"<table>{head}<tbody>\n{body}\n</tbody></table>")


def swatch(rgb: Sequence[float]) -> Markup:
    """Return a small square of a colour, linear sRGB in [0, 1] (what lies outside is cut off)."""
    from radiosity.light.colour import encode

    code = "".join(f"{round(255 * min(max(float(v), 0.0), 1.0)):02x}" for v in encode(rgb))
    return Markup(
        '<span class="swatch" style="display:inline-block;width:0.9em;height:0.9em;'
        f'border:1px solid #888;vertical-align:-0.1em;background:#{code}"></span>'
    )


def line(text: str) -> Markup:
    """Return a paragraph of text, "" of none."""
    return Markup(f"<p>{cell(text)}</p>" if text else "")


def in_notebook(title: str, *parts: str) -> str:
    """Return tables and lines under a title, as a notebook shows them."""
    body = "\n".join(cell(part) for part in parts if part)
    return f"<div><p><b>{cell(title)}</b></p>\n{body}</div>"
