import fcntl
import os
import pickle
import shutil
import signal
import zipfile
from functools import lru_cache, partial
from hashlib import sha256
from pathlib import Path

import pyarrow as pa
import pytest
from hypothesis import settings

import made_tables
from runs import ARCHIVED, ROOT, TINY, Folder
from vibrissa import solve_state
from vibrissa.archive.crate import write_archive
from vibrissa.computing.states import states_table
from vibrissa.design import pairs
from vibrissa.sensor.identification import forward, mixing
from vibrissa.sticking import api, comparison
from vibrissa.sticking.solving import collocation, shooting
from vibrissa.study.reading import read_study

TESTS = Path(__file__).parent

# What a shell starts in the background ignores Ctrl-C, and so would the programs that tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# How wide and colourful a terminal is, and whether it is GitHub's, must not decide what is shown.
for name in ("COLUMNS", "LINES", "FORCE_COLOR", "NO_COLOR", "PY_COLORS", "GITHUB_ACTIONS"):
    os.environ.pop(name, None)

# A deadline would measure how busy the machine is. Each run draws other examples, so that few of
# them find as much in the long run; `--hypothesis-profile=many` draws more at once.
settings.register_profile("vibrissa", deadline=None, max_examples=30)
settings.register_profile("many", deadline=None, max_examples=300)
settings.load_profile("vibrissa")


def pytest_collection_modifyitems(items):
    for item in items:
        if "nightly" in item.path.relative_to(TESTS).parts:
            item.add_marker("nightly")
        if item.get_closest_marker("nightly"):
            item.add_marker("slow")  # so that `-m "not slow"` leaves it out, too
    items.sort(key=lambda item: item.get_closest_marker("slow") is not None)


@pytest.fixture(scope="session", autouse=True)
def _caches(tmp_path_factory):
    """What tests start keeps its caches here, also where the home folder cannot be written."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("caches")))
        yield


@pytest.fixture(scope="session")
def run_folder(tmp_path_factory):
    """Folder of this run of the tests, which all workers share."""
    folder = tmp_path_factory.getbasetemp()
    return folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder


@pytest.fixture(scope="session")
def kept(run_folder):
    """What was made for one test, and is read from a file by others, in all workers."""
    folder = run_folder / "kept"
    folder.mkdir(exist_ok=True)

    def kept(make, *arguments, **named):
        key = pickle.dumps((make.__module__, make.__qualname__, arguments, named))
        path = folder / sha256(key).hexdigest()
        if path.exists():
            return pickle.loads(path.read_bytes())
        made = make(*arguments, **named)
        part = folder / f"{path.name}.{os.getpid()}"
        part.write_bytes(pickle.dumps(made))
        part.rename(path)
        return made

    return kept


# The solvers, by the modules in which tests find them.
SOLVERS = {
    (collocation, "solve_curves"): collocation.solve_curves,
    (comparison, "solve_curves"): collocation.solve_curves,
    (pairs, "solve_curves"): collocation.solve_curves,
    (shooting, "solve_curve"): shooting.solve_curve,
}


@pytest.fixture(scope="session", autouse=True)
def _kept_curves(kept):
    """Curves that were solved for one test are not solved again."""
    with pytest.MonkeyPatch.context() as patch:
        for place, solver in SOLVERS.items():
            patch.setattr(*place, partial(kept, solver))
        yield


@pytest.fixture(autouse=True)
def _no_patched_curves(request):
    """A test that may patch the solver neither gets a curve of another one nor leaves its own."""
    if "monkeypatch" not in request.fixturenames:
        yield
        return
    with pytest.MonkeyPatch.context() as patch:
        for place, solver in SOLVERS.items():
            patch.setattr(*place, solver)
        patch.setattr(api, "_kept_curve", lru_cache(api._kept_curve.__wrapped__))
        responses = lru_cache(forward.kept_responses.__wrapped__)
        for module in (forward, mixing):
            patch.setattr(module, "kept_responses", responses)
        yield


@pytest.fixture(scope="session")
def paper():
    """The paper's study."""
    return read_study(ROOT / "config.yaml")


def tables_of(path):
    """Tables of the study in a file, by its code but without its workflow."""
    study = read_study(path)
    states = {
        name: solve_state(state.theta, state.eta, state.x1) for name, state in study.states.items()
    }
    grids = [made_tables.points(name, grid.axes) for name, grid in study.grids.items()]
    scans = [made_tables.scans(name, scan) for name, scan in study.scans.items()]
    return {
        "stiction": pa.concat_tables(grids),
        "scans": pa.concat_tables([one.steps for one in scans]),
        "periods": pa.concat_tables([one.periods for one in scans]),
        "states": states_table(states, study.name),
    }


@pytest.fixture(scope="session")
def study_tables(kept):
    """Tables of the paper's study."""
    return kept(tables_of, ROOT / "config.yaml")


@pytest.fixture(scope="session")
def finished(run_folder):
    """A folder in which the tiny study was run once for all; not to be changed."""
    with (run_folder / "finished.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (run_folder / "finished").exists():
            new = Folder(run_folder / "started")
            new.root.mkdir()
            new.write("tiny.yaml", TINY)
            new.write("screen.txt", new.run())
            new.root.rename(run_folder / "finished")
    return Folder(run_folder / "finished")


@pytest.fixture
def done(finished, tmp_path):
    """A copy of the finished study for a test that goes on from it."""
    shutil.copytree(finished.root, tmp_path / "done")
    return Folder(tmp_path / "done")


@pytest.fixture
def unpacked(finished, tmp_path):
    """The unpacked archive of the finished study."""
    results = finished.root / "results/tiny"
    output = tmp_path / "tiny.crate.zip"
    (finished.root / "helper.py").write_text("")  # in the place of a script that draws a figure
    write_archive(
        ROOT, results, ARCHIVED, finished.root / "tiny.yaml", "0" * 40, output, ["helper.py"]
    )
    zipfile.ZipFile(output).extractall(tmp_path / "unpacked")
    return tmp_path / "unpacked"


@pytest.fixture
def fresh(tmp_path):
    """A folder in which nothing was run yet."""
    (tmp_path / "fresh").mkdir()
    folder = Folder(tmp_path / "fresh")
    folder.write("tiny.yaml", TINY)
    return folder


def with_program(folder):
    """Give a folder a copy of the program, to be edited."""
    skip = shutil.ignore_patterns("__pycache__")
    for name in ("src", "workflow"):
        shutil.copytree(ROOT / name, folder.root / name, ignore=skip)
    for name in ("Snakefile", "config.yaml"):
        shutil.copy(ROOT / name, folder.root)
    folder.home = folder.root
    return folder


@pytest.fixture
def edited(done):
    """The finished study beside a copy of the program, to be edited."""
    return with_program(done)


@pytest.fixture
def copied(fresh):
    """A study that was not run, beside a copy of the program."""
    return with_program(fresh)
