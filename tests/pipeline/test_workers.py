"""Workers; tests/workflow runs jobs in them."""

import sys
from multiprocessing import get_context
from threading import Thread
from types import SimpleNamespace

import pytest

from vibrissa.pipeline import workers


def test_all_that_a_script_imports_is_found(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import json, a.b\nfrom c import d, e as f\n\nwith g:\n    import inside\nimport h as i\n"
    )
    assert list(workers.modules_of(script)) == ["json", "a.b", "c", "c.d", "c.e", "h"]


def test_the_scripts_of_the_workflow_are_found():
    found = {name for path in workers.SCRIPTS.glob("*.py") for name in workers.modules_of(path)}
    assert {"vibrissa.figures.draw", "vibrissa.tables.store", "vibrissa.sticking.cycles"} <= found


PLAIN = {"conda_env": None, "container_img": None, "env_modules": None, "shadow_dir": None}


@pytest.mark.parametrize(
    ("given", "alone"),
    [
        ({}, False),
        ({"threads": 2}, True),
        ({"conda_env": "env"}, True),
        ({"container_img": "image.sif"}, True),
        ({"env_modules": "python"}, True),
        ({"shadow_dir": "shadow"}, True),
    ],
)
def test_a_job_with_surroundings_of_its_own_gets_a_python_of_its_own(given, alone):
    script = SimpleNamespace(**PLAIN | {"threads": 1} | given)
    assert workers.needs_its_own(script) is alone


def test_the_status_of_each_process_is_its_own_where_several_threads_start_some():
    context, found = get_context("forkserver"), []

    def some(status):
        for _ in range(30):
            worker = context.Process(target=sys.exit, args=[status], daemon=True)
            workers.start(worker)
            found.append((status, workers.exit_status(worker)))

    threads = [Thread(target=some, args=[status]) for status in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4 * 30
    assert all(status == expected for expected, status in found)
