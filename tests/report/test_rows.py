"""How much of long tables the page shows, and what it says of the rest."""

from decimal import Decimal

import pytest

from small_study import scans, states
from vibrissa.report import facts, proofs, tables
from vibrissa.report.motion import motion
from vibrissa.sticking.comparison import compare
from vibrissa.tables import schemas
from vibrissa.tables.proofs import Proof
from vibrissa.tables.records import comparison_table


def repeated(table, schema, key, names, **values):
    """A table of the same rows under other names."""
    rows = [row | {key: name} | values for name in names for row in table.to_pylist()]
    return table.from_pylist(rows, schema=schema)


def proof(state, quantity, midpoint):
    return Proof(
        table="states",
        row={"state": state},
        quantity=quantity,
        midpoint=Decimal(midpoint),
        radius=Decimal("1E-15"),
        on_path=True,
        note="",
    )


@pytest.mark.parametrize(("count", "rows"), [(40, 40), (41, 40)])
def test_of_a_long_table_the_first_rows_are_shown(count, rows):
    one, scan = states().slice(0, 1), scans().slice(0, 2)
    names = [f"{n:02}" for n in range(count)]
    found = {
        "states": repeated(one, schemas.STATES, "state", names),
        "scans": repeated(scan, schemas.SCANS, "scan", names),
    }
    (force,) = one.column("f").to_pylist()
    proved = proofs.Proved([proof(name, "f", force) for name in names])
    marked, digits, moved = tables.sections(found, proved)
    for section in (marked, digits, moved):
        assert section.columns[0].cells == names[:rows]
        said = f"Shown are the first {rows} of {count} rows."
        assert (said in section.note) is ("Shown" in section.note) is (rows < count)
    assert "proved = ✓" in marked.note
    assert f"force = {proofs.digits(proof('', 'f', force))}" in digits.note
    assert "cycles = 1, states = 2" in moved.note
    assert tables.sections({"states": found["states"].slice(0, 0)}) == []


def test_what_one_row_has_is_no_constant_and_nothing_is_not_told():
    one = states().slice(0, 1)
    (section,) = tables.sections({"states": one})
    assert (section.note, len(section.columns)) == ("", len(tables.STATES))
    exact = repeated(one, schemas.STATES, "state", ["a"], residual=1.2345e-13, f=1.23456789)
    (section,) = tables.sections({"states": exact})
    cells = {column.name: column.cells for column in section.columns}
    assert (cells["residual"], cells["force"]) == (["1.2·10⁻¹³"], ["1.2346"])
    twice = repeated(one, schemas.STATES, "state", ["a", "b"], residual=None, f=1 / 3)
    (section,) = tables.sections({"states": twice})
    assert [column.name for column in section.columns] == ["state"]
    assert "force = 0.33333" in section.note and "residual" not in section.note


@pytest.mark.parametrize(
    ("least", "greatest", "text"),
    [
        (2e-9, 1.0, "2·10⁻⁹ … 1"),
        (1e-9, 1.0, "0 … 1"),
        (-4.0, 4e-9, "−4 … 0"),
        (-1.23456, -1.0, "−1.235 … −1"),
    ],
)
def test_a_range_of_a_signal_leaves_rounding_out(least, greatest, text):
    rows = scans().slice(0, 2).to_pylist()
    rows[0]["reaction_fx"], rows[1]["reaction_fx"] = greatest, least
    (section,) = tables.sections({"scans": scans().from_pylist(rows, schema=schemas.SCANS)})
    (column,) = (one for one in section.columns if one.name == "Fx")
    assert column.cells == [text]


@pytest.mark.parametrize(
    ("statuses", "text"),
    [
        ({}, "0"),
        ({"failed": 1}, "1, failed"),
        ({"out_of_reach": 2}, "2, all out of reach"),
        ({"slip": 2, "lock": 1}, "3: 1 lock, 2 slip"),
    ],
)
def test_statuses_are_counted_in_words(statuses, text):
    assert tables.spell_counts(statuses) == text


@pytest.mark.parametrize(("count", "lines"), [(40, 40), (41, 41), (43, 41)])
def test_of_many_reasons_the_most_frequent_are_listed(count, lines):
    row = states().slice(0, 1).to_pylist()[0] | {"status": "failed"}
    # The last reason is that of two rows.
    rows = [row | {"message": f"no. {n}"} for n in [*range(count), count - 1]]
    told = facts.troubles({"states": states().from_pylist(rows, schema=schemas.STATES)})
    assert len(told) == lines and told[0] == f"states: 2 rows failed: no. {count - 1}"
    assert told[1] == "states: 1 row failed: no. 0"
    assert count == 40 or told[-1] == f"states: and {count - 40} more reasons; see its table"


def test_a_job_that_was_over_before_anybody_looked_has_no_memory():
    rows = facts.job_times({"a": ["s\tmax_rss\n1.5\tNA\n", "s\tmax_rss\nNA\tNA\n9\t9\n"]})
    of_a, of_all = rows.drop(columns="rule").to_dict("records")
    assert of_a == of_all == {"jobs": 2, "seconds": 1.5, "longest": 1.5, "memory": 0.0}


def test_a_proof_agrees_with_a_number_up_to_its_bound():
    for off, agrees in (("1E-8", True), ("-1E-8", True), ("1.1E-8", False), ("-1.1E-8", False)):
        proved = proofs.Proved([proof("a", "f", Decimal("0.5") + Decimal(off))])
        assert bool(proved.of("states", {"state": "a", "f": 0.5})) is agrees
    assert not proved.of("states", {"state": "a", "f": "word"})


def test_the_rod_of_a_page_moves_as_a_scan_a_point_or_a_figure_of_the_paper():
    assert motion({}).what == "a figure of the paper" and motion({}).presets
    found = motion({"scans": scans(), "stiction": states()})
    assert found.what == "a scan of the study"


def test_a_comparison_is_shown_at_the_ends_and_in_the_middle_of_its_axes():
    compared = compare([1, 2, 4, 6, 8], [0.2, 0.3], [0.85])
    table = comparison_table("models", compared, "a")
    (found,) = tables.sections({"comparisons": table})
    assert found.title == "Comparison models"
    rows = table.to_pandas()
    count = int(rows["penetrates"].sum())
    assert 0 < count < 10
    assert f"10 points; the rod would pass through the surface in {count} of them." in found.note
    cells = {column.name: column.cells for column in found.columns}
    assert cells["θ"] == ["1", "1", "4", "4", "8", "8"] and cells["μ0"] == ["0.2", "0.3"] * 3
    shown = rows[rows["theta"].isin([1.0, 4.0, 8.0])].sort_values(["theta", "mu0"])
    for name, column in (("onset, tip", "x0_slip_point"), ("μ_lock, line", "mu_lock_line")):
        assert cells[name] == [f"{value:.5g}" for value in shown[column]]
    assert cells["penetrates"] == ["yes" if one else "no" for one in shown["penetrates"]]


def test_scans_and_comparisons_stand_in_the_order_of_the_study():
    names = ["late", "early", "middle"]
    table = repeated(scans().slice(0, 2), schemas.SCANS, "scan", names)
    (section,) = tables.sections({"scans": table})
    assert section.columns[0].cells == names
    compared = comparison_table("one", compare([1, 2], [0.2], [0.85]), "a")
    table = repeated(compared, schemas.COMPARISONS, "comparison", names)
    shown = [section.title for section in tables.sections({"comparisons": table})]
    assert shown == [f"Comparison {name}" for name in names]
