"""One style for every picture: what journals ask of type, widths and files."""

import re

import matplotlib
import pandas as pd
import pytest
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from figure_rows import drawn
from vibrissa import provenance
from vibrissa.figures import style
from vibrissa.figures.series import Series

GOLDEN = {
    "pdf.fonttype": 42,
    "svg.fonttype": "path",
    "font.family": ["STIXGeneral", "DejaVu Serif"],
    "mathtext.fontset": "stix",
    "font.size": 8,
    "legend.fontsize": 7,
    "savefig.dpi": 300,
    "svg.hashsalt": "vibrissa",
}


def test_the_style_is_a_journals():
    with style.applied():
        assert {name: matplotlib.rcParams[name] for name in GOLDEN} == GOLDEN
    assert (style.COLUMN, style.PAGE) == (3.5, 7.2)


@pytest.mark.slow
def test_files_embed_truetype_whole_texts_and_the_same_table_gives_the_same_bytes(tmp_path):
    starts = {"pdf": b"%PDF-", "svg": b"<?xml", "png": b"\x89PNG\r\n\x1a\n"}
    contents = []
    for run in "ab":
        paths = [tmp_path / f"{run}.{ending}" for ending in starts]
        style.save(drawn("law", 2), paths, "Law", "mine")
        contents.append({path.suffix[1:]: path.read_bytes() for path in paths})
    first, second = contents
    assert first == second and len(list(tmp_path.iterdir())) == 6
    assert all(first[ending].startswith(start) for ending, start in starts.items())
    kinds = set(re.findall(rb"/Subtype /(Type3|Type0|CIDFontType2|TrueType|Type1)\b", first["pdf"]))
    assert kinds <= {b"Type0", b"CIDFontType2", b"TrueType"} and kinds
    for ending in starts:
        assert b"Law" in first[ending] and b"study mine" in first[ending]
        assert provenance.commit().encode() in first[ending]
    assert b"CreationDate" not in first["pdf"] and b"dc:date" not in first["svg"]
    # Outlines look the same where the typeface is missing.
    assert b"<text" not in first["svg"] and b"font-family" not in first["svg"]


@pytest.mark.slow
def test_a_figure_is_laid_out_once_for_all_formats(tmp_path, monkeypatch):
    """Else its PDF, whose type is measured in another way, would have other axes than its PNG."""
    figure, layouts, drawings = drawn("taper", 3), [], []
    execute, draw = ConstrainedLayoutEngine.execute, Figure.draw
    monkeypatch.setattr(
        ConstrainedLayoutEngine,
        "execute",
        lambda engine, page: layouts.append(page) or execute(engine, page),
    )
    monkeypatch.setattr(
        Figure, "draw", lambda page, renderer: drawings.append(page) or draw(page, renderer)
    )
    style.save(figure, [tmp_path / f"figure.{ending}" for ending in ("svg", "pdf", "png")])
    assert layouts == [figure] and len(drawings) == 3


@pytest.mark.parametrize(
    ("values", "bounds"),
    [([1.0, 2.0, 4.0], [1.0, 1.5, 3.0, 4.0]), ([2.0], [1.8, 2.2]), ([0.0], [-0.1, 0.1])],
)
def test_cells_of_a_map_end_with_the_grid(values, bounds):
    assert style.cells(values).tolist() == pytest.approx(bounds)


def test_series_are_told_apart_however_many_there_are():
    few, many = (
        Series(pd.DataFrame({"mu0": [*values]}), "mu0") for values in ([0.3, 0.1], range(20))
    )
    assert [few.color(0.1), few.color(0.3)] == list(style.COLORS[:2])
    assert (few.label(0.3), many.label(3)) == (r"$\mu_0 = 0.3$", None)
    lightness = [sum(int(many.color(i)[k : k + 2], 16) for k in (1, 3, 5)) for i in range(20)]
    assert len({many.color(i) for i in range(20)}) == 20 and lightness[0] < lightness[-1]
