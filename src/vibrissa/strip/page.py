"""The strip as a web page: the answer, doubts, the drawing, notes, a row for each period."""

from collections.abc import Iterator, Sequence
from html import escape

import numpy as np

from vibrissa import __version__
from vibrissa.provenance import commit
from vibrissa.quantities.units import Kind
from vibrissa.sensor import Grade, Identification
from vibrissa.strip.drawing import axis_of, svg

STYLE = """
:root { color-scheme: light; }
body { font: 15px/1.45 system-ui, sans-serif; color: #222; background: #fff; max-width: 60rem;
  margin: 1.5rem auto; padding: 0 1rem; }
header p { margin: 0; color: #555; overflow-wrap: anywhere; }
h1 { font-size: 2rem; margin: 0.2rem 0 0; }
h1 + p { margin: 0 0 0.6rem; }
ul { padding-left: 1.2rem; margin: 0.5rem 0; }
.wrong { color: #a3263f; font-weight: 600; }
.doubtful { color: #7a4a00; font-weight: 600; }
svg { display: block; width: 100%; height: auto; }
@media screen { svg { min-width: 36rem; } }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 13px; }
th, td { padding: 0.15rem 0.6rem; text-align: right; border-bottom: 1px solid #ddd; }
th { vertical-align: bottom; } td:last-child, th:last-child { text-align: left; }
summary { cursor: pointer; margin-top: 0.8rem; }
@page { margin: 14mm; }
@media print { body { margin: 0; max-width: none; font-size: 10pt; } details { display: none; }
  .scroll { overflow: visible; break-inside: avoid; } }
"""


def page(identification: Identification, source: str, notes: Sequence[str] = ()) -> str:
    """Return the strip of an identification as a web page without external references.

    Parameters
    ----------
    source : str
        Name of the recording.
    notes : sequence of str
        Lines to print below the drawing, after those of the summary.
    """
    summary = identification.summary()
    answer, *trust = summary.answer()
    head, comma, rest = answer.partition(", ")
    # The number stays in one piece.
    head = escape(head).replace("mu0 = ", "μ<sub>0</sub> = ").replace(" ± ", "&nbsp;±&nbsp;")
    untrusted = [(Grade.WRONG if summary.wrong else Grade.DOUBTFUL, line) for line in trust]
    doubts = [(line.partition(":")[0], line) for line in identification.periods.doubts]
    lines = [*summary.details(), *identification.periods.left_out, *notes]
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Friction: {escape(source)}</title>
<link rel="icon" href="data:,">
<style>{STYLE}</style>
</head>
<body>
<header>
<p>Friction of a surface: {escape(source)}</p>
</header>
<main>
<h1>{head}</h1>
<p>{escape(rest) if comma else ""}</p>
{_list(untrusted + doubts)}
<div class="scroll" tabindex="0" role="region" aria-label="Drawing">
<div role="img" aria-label="Loads and residuals over the position of the clamp; friction with its
95 % intervals along the surface. The table below has the numbers.">
{svg(identification)}
</div>
</div>
{_list([("", line) for line in lines])}
<details><summary>All periods</summary>
<div class="scroll" tabindex="0" role="region" aria-label="All periods">
{_table(identification)}
</div>
</details>
</main>
<footer><p>Vibrissa {__version__}, commit {escape(commit())}</p></footer>
</body>
</html>
"""


def _list(lines: Sequence[tuple[str, str]]) -> str:
    """List lines, each with a class that gives its colour."""
    if not lines:
        return ""
    each = "\n".join(f'<li class="{kind}">{escape(line.strip())}</li>' for kind, line in lines)
    return f"<ul>\n{each}\n</ul>"


def _table(identification: Identification) -> str:
    length = axis_of(identification, Kind.LENGTH, identification.recording.clamp)
    titles = [f"tip / {length.unit}", f"clamp / {length.unit}", "μ0", "95 % interval", "lines"]
    head = "".join(f'<th scope="col">{title}</th>' for title in (*titles, "status", "doubt"))
    rows = "\n".join(_rows(identification))
    return f"<table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody>\n</table>"


def _rows(identification: Identification) -> Iterator[str]:
    periods = identification.periods
    length = axis_of(identification, Kind.LENGTH, identification.recording.clamp)

    def spelled(value: float, digits: int) -> str:
        return f"{value:.{digits}f}" if np.isfinite(value) else "–"

    for i in range(len(periods)):
        low, high = periods.low[i], periods.high[i]
        cells = [
            spelled(periods.contact[i] * length.factor, 2),
            spelled(periods.footpoint[i] * length.factor, 2),
            spelled(periods.mu0[i], 4),
            f"{spelled(low, 4)} to {spelled(high, 4)}",
            f"{periods.first_line[i]}–{periods.last_line[i]}",
            str(periods.status[i]),
            escape(str(periods.doubt[i])),
        ]
        yield "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"
