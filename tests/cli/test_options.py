"""The options of the commands, as their signatures have them: what is taken, and what if not."""

import inspect
from functools import partial
from importlib import import_module
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from known import Known
from vibrissa.cli.app import COMMANDS, app, module_of
from vibrissa.cli.import_ import _columns
from vibrissa.cli.options import check_not_read
from vibrissa.cli.requirements import takes_requirements
from vibrissa.cli.whisker import Tolerances, read_pairs, say_exact, takes_whisker
from vibrissa.design import Requirements
from vibrissa.errors import ArgumentError
from vibrissa.sensor import Whisker
from vibrissa.sensor.series import STANDARD

KNOWN = Known(__file__)


def described(option):
    """What a user may leave out, what is taken then, and the least number that is allowed."""
    (asked,) = option.annotation.__metadata__
    needed = option.default is inspect.Parameter.empty
    shown = asked.show_default if isinstance(asked.show_default, str) else option.default
    words = ["needed"] if needed else [f"default {getattr(shown, 'value', shown)}"]
    return words if asked.min is None else [*words, f"from {asked.min}"]


@pytest.mark.parametrize("name", COMMANDS)
def test_each_option_has_its_default(name):
    module = module_of(name)
    command = getattr(import_module(module), module.rpartition(".")[2])
    options = inspect.signature(command).parameters
    KNOWN.check(name, {name: described(option) for name, option in options.items()})


def test_the_version_is_told_whatever_else_is_asked():
    shown = CliRunner().invoke(app, ["--version", "--help"])
    assert shown.exit_code == 0 and shown.output.startswith("vibrissa ")


@pytest.fixture
def asked():
    """What commands were given that take a whisker, or do without one."""
    given = {}

    def needs(whisker: Whisker, noise: str | None = None, material: str | None = None, n: int = 1):
        given["needs"] = (whisker, noise, material, n)

    def may_do_without(
        whisker: Whisker | None = None, tolerances: Tolerances = None, noise: str | None = None
    ):
        given["may do without"] = (whisker, tolerances, noise)

    def called(command, **options):
        run = takes_whisker(command)
        every = inspect.signature(run).parameters
        # Options can be given in any order, and Typer gives all of them.
        assert {one.kind for one in every.values()} == {inspect.Parameter.KEYWORD_ONLY}
        assert run.__annotations__ == {name: one.annotation for name, one in every.items()}
        assert "whisker" not in every and "reading" not in every
        run(**{name: None for name in every} | options)
        return given.pop(command.__name__.replace("_", " "))

    return SimpleNamespace(needs=partial(called, needs), without=partial(called, may_do_without))


def test_a_command_has_its_whisker_of_the_options_and_the_rod_file(asked, tmp_path):
    rod = tmp_path / "rod.toml"
    rod.write_text('theta = "2 ± 0.02"\neta = 0.85\nnoise = "1, 2, 3"\nmaterial = "music-wire"\n')
    whisker, *others = asked.needs(theta="2 ± 0.1", eta="0.85", material="steel", n=3)
    assert (whisker.theta, whisker.eta, list(whisker.tolerances)) == (2.0, 0.85, ["theta"])
    assert others == [None, "steel", 3]
    whisker, *others = asked.needs(rod=rod, eta="0.8", n=3)
    assert (whisker.theta, whisker.eta) == (2.0, 0.8)
    assert others == ["1, 2, 3", "music-wire", 3]
    whisker, tolerances, noise = asked.without(rod=rod, noise="3, 2, 1", tolerances=["exact"])
    assert (whisker.theta, whisker.eta, noise) == (2.0, 0.85, "3, 2, 1")
    assert list(whisker.tolerances) == ["theta"] and tolerances == ["exact"]
    whisker, *_ = asked.without(rod=rod, tolerances=["exact", " eta = 0.01"])
    assert sorted(whisker.tolerances) == ["eta", "theta"]


def test_theta_and_eta_may_be_left_out_where_no_whisker_is_needed(asked):
    for one in ({}, {"theta": "2"}, {"eta": "0.85"}):
        assert asked.without(**one, noise="1", tolerances=["eta=1"]) == (None, ["eta=1"], "1")
        with pytest.raises(ArgumentError, match="is not given: neither as an option nor in"):
            asked.needs(**one)
    assert asked.without(theta="2", eta="0.85")[0].eta == 0.85


def test_a_command_that_uses_no_tolerance_names_those_that_are_given(capsys):
    exact = Whisker.read(2, 0.85)
    say_exact(exact, "scan")
    assert capsys.readouterr() == ("", "")
    say_exact(Whisker.read("2 ± 0.02", "0.85 ± 0.1"), "scan")
    said = "scan takes all as exact: no tolerance is used (theta, eta)\n"
    assert capsys.readouterr() == ("", said)


def test_sizes_of_tolerances_are_read_in_pairs():
    given = ["eta = 0.2 mm", "theta=exact", "clamp_angle=a=b"]
    assert read_pairs(given) == {"eta": "0.2 mm", "theta": "exact", "clamp_angle": "a=b"}
    assert read_pairs(()) == {}
    for text in ("eta", "eta=", "= 1", "="):
        with pytest.raises(ArgumentError, match=f"given as name=size, got '{text}'"):
            read_pairs(["theta=1", text])
    with pytest.raises(ArgumentError, match="the tolerance of eta is given twice"):
        read_pairs(["theta=1", "eta=1", " eta =2"])


def test_a_column_is_told_once():
    assert _columns(["a=x", " b = y"]) == {"a": "x", "b": " y"}
    with pytest.raises(ArgumentError, match="the column b is given twice"):
        _columns(["a=x", "b=y", " b = z"])


def test_files_that_are_read_are_not_overwritten(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    here = tmp_path / "a.csv"
    check_not_read(None, here)
    check_not_read(here, None, "b.csv")
    check_not_read(STANDARD, STANDARD)
    for read in (here, "a.csv", "../" + tmp_path.name + "/a.csv"):
        with pytest.raises(ArgumentError, match="is a file that is read: write another one"):
            check_not_read(here, "b.csv", read)


def test_requirements_are_read_of_the_options_and_the_rod_file(tmp_path):
    rod = tmp_path / "rod.toml"
    rod.write_text('material = "music-wire"\nlength = "90 mm"\n[tolerances]\neta = "0.1 mm"\n')
    given = []

    def found(requirements: Requirements, more: int = 1):
        given[:] = [requirements, more]

    run = takes_requirements(found)
    every = inspect.signature(run).parameters
    assert {one.kind for one in every.values()} == {inspect.Parameter.KEYWORD_ONLY}
    assert run.__annotations__ == {name: one.annotation for name, one in every.items()}
    default = {name: one.default for name, one in every.items()}
    needed = {"step": "50 um", "mu0": "0.2 to 0.3", "noise": "1 mN, 2 mN, 3 uN*m"}
    run(**default | needed | {"rod": rod, "range_": "1 N, 2 N, 3 N*m", "more": 7})
    requirements, more = given
    assert (requirements.length, requirements.range, more) == ((0.09,), (1.0, 2.0, 3.0), 7)
    assert requirements.assume and list(requirements.tolerances) == ["eta"]
    run(**default | needed | {"rod": rod, "tolerances": ["exact", "theta=0.1"]})
    requirements, more = given
    assert not requirements.assume and list(requirements.tolerances) == ["eta", "theta"]
    assert more == 1
    bare = {"step": "1 mm", "mu0": "0.3", "noise": "1 N, 2 N, 3 N*m", "material": "music-wire"}
    run(**default | bare | {"tolerances": ["theta=0.1"]})
    assert given[0].assume and list(given[0].tolerances) == ["theta"]
    with pytest.raises(ArgumentError, match="the tolerance of theta is given twice"):
        run(**default | bare | {"tolerances": ["theta=0.1", "theta=1 %"]})
