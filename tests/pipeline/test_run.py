import errno
import os
import pty
import re
import signal
import subprocess
import sys
from multiprocessing import Pipe
from pathlib import Path

import pytest

from vibrissa.pipeline import ending, places, run
from vibrissa.pipeline.events import Failed, Finished, Job, Planned, Problem, Progress
from vibrissa.tables import schemas, store

# Stands in for Snakemake: it sends events, as the last argument says where.
STAND_IN = """
import errno, json, os, signal, sys, time
from pathlib import Path
from multiprocessing.connection import Connection
from vibrissa.pipeline.events import *
*ARGUMENTS, _, pipe = sys.argv[1:]
send = Connection(int(pipe), readable=False).send
"""
# One in each line: paths may have spaces.
SHOW = "print(*ARGUMENTS, sep='\\n')"
GRIDS = "grids: {g: {theta: [1], mu0: [0.3], eta: [0.85], dx0: [0.005]}}\n"
RUN = """
import os, sys
from vibrissa.pipeline import run
run.SNAKEMAKE = [sys.executable, os.path.abspath("stand_in.py")]
run.GRACE = {grace}
run.places.PAPER = "config.yaml"
sys.exit(run.main(sys.argv[1:]))
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config.yaml").write_text(f"study: here\n{GRIDS}")
    return tmp_path


@pytest.fixture
def command(folder):
    def make(snakemake, *arguments, grace=60):
        (folder / "stand_in.py").write_text(STAND_IN + snakemake)
        return [sys.executable, "-c", RUN.format(grace=grace), *arguments]

    return make


@pytest.fixture
def wrapped(command):
    """Run the study around a stand-in for Snakemake with the given code."""

    def call(snakemake, *arguments):
        return subprocess.run(command(snakemake, *arguments), capture_output=True, text=True)

    return call


def problem(message, **more):
    """Code that sends a problem and fails."""
    return f"send({Problem(message=message, **more)!r})\nsys.exit(1)"


def last_lines(result, count=1):
    return result.stderr.rstrip().splitlines()[-count:]


def test_arguments_go_through_to_snakemake(wrapped):
    Path("my.yaml").write_text(f"study: mine\n{GRIDS}")
    result = wrapped(SHOW, "--configfile", "my.yaml", "-n", "--cores", "3")
    assert result.stdout.splitlines() == [
        *("--configfile", "my.yaml"),
        *("--snakefile", str(places.SNAKEFILE)),
        *("--workflow-profile", str(places.PROFILES / "default")),
        *("-n", "--cores", "3"),
        *("--logger", "vibrissa"),
    ]
    assert result.stderr.startswith("Study 'mine': snakemake --configfile my.yaml")


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments",
    [
        ["--configfile", "my.yaml"],
        ["--configfile=my.yaml"],
        ["--configfiles", "my.yaml"],
    ],
)
def test_the_study_that_runs_is_announced(wrapped, arguments):
    Path("my.yaml").write_text(f"study: mine\n{GRIDS}")
    assert wrapped("", *arguments).stderr.startswith("Study 'mine': snakemake")


def test_a_terminal_gets_progress_bars(command):
    main, other = pty.openpty()
    process = subprocess.run(
        command("print(*ARGUMENTS)"),
        stdout=subprocess.PIPE,
        stderr=other,
        env=os.environ | {"TERM": "xterm"},
        text=True,
    )
    os.close(other)
    os.close(main)
    assert process.stdout.split()[-3:] == ["--logger", "vibrissa", "rich"]


@pytest.mark.slow
def test_a_problem_without_a_failed_job_is_shown(wrapped):
    result = wrapped(problem("some reason"))
    assert result.returncode == 1
    assert last_lines(result) == ["some reason"]


@pytest.mark.slow
@pytest.mark.parametrize("status", [1, 2])
def test_what_is_written_to_the_screen_stays_there_and_the_status_is_kept(wrapped, status):
    result = wrapped(f"print('usage', file=sys.stderr)\nsys.exit({status})")
    assert result.returncode == status
    assert last_lines(result) == ["usage"]


@pytest.mark.slow
def test_a_killed_snakemake_is_reported(wrapped):
    result = wrapped("os.kill(os.getpid(), 9)")
    assert result.returncode == 137
    assert last_lines(result) == [
        "Snakemake was ended by signal 9 (SIGKILL); the same command continues."
    ]
    assert "The last run was killed" in wrapped("").stderr


@pytest.mark.slow
def test_an_interrupted_run_says_how_to_go_on(command):
    process = subprocess.Popen(
        command(
            "send(Progress(done=1, total=2))\n"
            "try:\n    time.sleep(60)\nexcept KeyboardInterrupt:\n    sys.exit(1)"
        ),
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    with process:
        while "50%" not in process.stderr.readline():
            pass
        os.killpg(process.pid, signal.SIGINT)
        rest = process.stderr.read()
    assert process.returncode == 130
    assert rest.splitlines()[-1].startswith("Interrupted. Finished results are kept")


@pytest.mark.slow
def test_a_request_to_end_is_passed_on(command):
    process = subprocess.Popen(
        command(
            f"def end(*_): send({Problem(message='At least one job did not')!r}); sys.exit(3)\n"
            "signal.signal(signal.SIGTERM, end)\n"
            "send(Progress(done=1, total=2))\ntime.sleep(60)"
        ),
        stderr=subprocess.PIPE,
        text=True,
    )
    with process:
        while "50%" not in process.stderr.readline():
            pass
        process.terminate()
        said = process.stderr.read()
    assert process.returncode == 3
    # And not that at least one job did not complete successfully, as Snakemake has it.
    assert said.splitlines() == [
        "Ended as asked, by SIGTERM. Finished results are kept: the same command continues."
    ]


@pytest.fixture
def scancel(folder, monkeypatch):
    """Make SLURM's command from a line of shell."""

    def make(line):
        (folder / "scancel").write_text(f"#!/bin/sh\n{line}\n")
        (folder / "scancel").chmod(0o755)
        monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")

    return make


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_run_on_slurm_that_is_stopped_leaves_no_job_there(command, folder, scancel, number):
    scancel("echo $@ > cancelled")
    process = subprocess.Popen(
        command(
            "send(Queued(run='vibrissa_1', text='SLURM: 2 running'))\n"
            "try:\n    time.sleep(60)\nexcept KeyboardInterrupt:\n    sys.exit(1)"
        ),
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    with process:
        while "SLURM: 2 running" not in process.stderr.readline():
            pass
        if number == signal.SIGINT:
            os.killpg(process.pid, number)
        else:
            process.send_signal(number)
        process.stderr.read()
    assert process.returncode == 130
    assert (folder / "cancelled").read_text() == "--me --name=vibrissa_1\n"


@pytest.mark.slow
def test_a_snakemake_that_does_not_end_is_killed_and_leaves_no_lock(command, folder, scancel):
    scancel("echo 'no controller' >&2; exit 1")
    (folder / ".snakemake/locks").mkdir(parents=True)
    process = subprocess.Popen(
        command(
            "signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
            "send(Queued(run='vibrissa_1', text='SLURM: 2 running'))\ntime.sleep(60)",
            grace=0.2,
        ),
        stderr=subprocess.PIPE,
        text=True,
    )
    with process:
        while "SLURM: 2 running" not in process.stderr.readline():
            pass
        process.terminate()
        said = process.stderr.read()
    assert process.returncode == 130
    assert "Interrupted." in said
    assert "scancel --name=vibrissa_1 ends them. (no controller)" in said
    assert not (folder / ".snakemake/locks").exists()
    assert (folder / ".snakemake/run.lock").read_text() == ""


def test_our_own_error_is_shown_without_warnings_before_it(wrapped):
    warning = f"send({Problem(message='No account given')!r})\n"
    result = wrapped(warning + problem("SLURM does not take the jobs", ours=True))
    assert last_lines(result) == ["SLURM does not take the jobs"]
    assert "No account" not in result.stderr


@pytest.mark.slow
def test_the_end_of_a_good_run_lists_the_figures(wrapped):
    drawn = "figures: {a: {kind: friction, grid: g}, b: {kind: friction, grid: g}}\n"
    Path("config.yaml").write_text(f"study: here\n{GRIDS}{drawn}")
    figures = Path("results/here/figures")
    figures.mkdir(parents=True)
    for name in ("b.pdf", "a.svg", "a.pdf", "captions.md"):
        (figures / name).write_text(name)
    result = wrapped("send(Planned(jobs=2))")
    assert result.returncode == 0
    listed = [
        "Figures in results/here/figures:",
        "  results/here/figures/a .pdf .svg",
        "  results/here/figures/b .pdf",
    ]
    assert last_lines(result, 3) == listed
    # Of an earlier study file: neither listed nor lost.
    for name in ("c.pdf", "c.svg", "../claims.md", "note.txt"):
        (figures / name).write_text("# Title\n\n2 statements: 2 hold. Units are\n")
    *shown, others = last_lines(wrapped("send(Planned(jobs=0))"), 4)
    assert shown == listed
    assert others == (
        "Not of the study file as it is now, and in neither report nor archive: claims.md, "
        "figures/c.pdf, figures/c.svg ... (4 files in results/here; remove what you do not need)"
    )
    assert (figures / "c.pdf").is_file()


def judged():
    """Folder of a study that judges the paper's statements."""
    Path("config.yaml").write_text(places.PAPER.read_text().replace("study: paper", "study: here"))
    folder = Path("results/here")
    folder.mkdir(parents=True)
    return folder


@pytest.mark.slow
def test_the_verdicts_on_the_papers_statements_are_the_last_line(wrapped):
    folder = judged()
    (folder / "claims.md").write_text("# Title\n\n2 statements: 1 holds, 1 ambiguous. Units are\n")
    assert last_lines(wrapped("")) == [
        "2 statements: 1 holds, 1 ambiguous (results/here/claims.md)"
    ]


@pytest.mark.slow
def test_where_the_report_is_is_the_last_line(wrapped):
    folder = judged()
    (folder / "claims.md").write_text("# Title\n\n2 statements: 2 holds. Units are\n")
    (folder / "report.html").touch()
    assert last_lines(wrapped(""), 2) == [
        "2 statements: 2 holds (results/here/claims.md)",
        "All on one page: results/here/report.html",
    ]


@pytest.mark.slow
def test_what_refine_added_and_left_over_is_said(wrapped):
    table = Path("results/here/tables/stiction.parquet")
    table.parent.mkdir(parents=True)
    schema = schemas.STICTION.with_metadata(
        schemas.STICTION.metadata | {store.REFINED: b"refine added 7 points"}
    )
    store.write(schema.empty_table(), table, "study: here")
    assert last_lines(wrapped(""), 2)[0] == (
        "refine added 7 points (for each line: results/here/logs/points)"
    )
    # A dry run mends nothing.
    table.write_text("damaged")
    assert last_lines(wrapped("", "-n")) == ["No figures in results/here/figures."]


@pytest.mark.slow
def test_a_study_without_figures(wrapped):
    assert last_lines(wrapped("")) == ["No figures in results/here/figures."]


@pytest.mark.slow
def test_nothing_to_do_is_said(wrapped):
    assert "Nothing to do: all results are up to date." in wrapped("send(Planned(jobs=0))").stderr
    for more in ("send(Planned(jobs=0)); send(Planned(jobs=2))", ""):
        assert "Nothing to do" not in wrapped(more).stderr


def job(rule, output, log="job.log", number=4):
    return Job(number=number, rule=rule, output=output, log=[log] if log else [])


def failure(*events):
    """Code that sends events and fails."""
    return "".join(f"send({event!r})\n" for event in events) + "sys.exit(1)"


def test_a_failed_job_is_the_last_thing_on_the_screen(wrapped):
    code = "Path('job.log').write_text('line\\n' * 20 + 'error: the reason\\n\\n')\n"
    failed = Failed(jobs=[job("figure", ["a.svg", "a.pdf"])])
    result = wrapped(code + failure(failed, Problem(message="Shutting down")))
    assert result.returncode == 1
    assert "Shutting down" not in result.stderr
    assert last_lines(result, 8) == [
        "FAILED: rule figure, making a.svg, a.pdf",
        *["    line"] * 5,
        "    error: the reason",
        "  log: job.log",
    ]


@pytest.mark.slow
def test_only_three_failed_jobs_are_shown_in_full(wrapped):
    code = "Path('job.log').write_text('error: the reason\\n')\n"
    failed = [Failed(jobs=[job("curves", [f"{i}.parquet"], number=i)]) for i in range(5)]
    lines = wrapped(code + failure(*failed)).stderr.splitlines()
    assert [line for line in lines if line.startswith("FAILED")] == [
        f"FAILED: rule curves, making {i}.parquet" for i in (3, 4, 0, 1, 2)
    ]
    assert lines.count("    error: the reason") == 3
    assert lines[-1] == "  log: job.log"


def watched(*events):
    """What becomes of a run with some events."""
    receiver, sender = Pipe(duplex=False)
    for event in events:
        sender.send(event)
    sender.close()
    outcome = ending.Outcome()
    outcome.watch(receiver, progress=True)
    return outcome


def explanations(*events):
    outcome = watched(*events)
    return [ending.explain(failed).splitlines() for failed in outcome.failures]


@pytest.mark.parametrize(
    ("more", "shown"),
    [
        ({}, "(nothing in its log)"),
        ({"signal": signal.SIGKILL}, "(ended by SIGKILL)"),
        ({"reason": "SLURM status is: 'TIMEOUT'"}, "SLURM status is: 'TIMEOUT'"),
    ],
)
def test_a_job_that_wrote_nothing_to_its_log(folder, more, shown):
    Path("job.log").touch()
    (lines,) = explanations(Failed(jobs=[job("curves", ["a.parquet"])], **more))
    assert lines == [
        "FAILED: rule curves, making a.parquet",
        f"    {shown}",
        "  log: job.log",
    ]


def test_a_job_that_succeeded_when_tried_again_did_not_fail(folder):
    failed = Failed(jobs=[job("curves", ["a.parquet"])])
    assert watched(failed, failed).failures == [failed]
    assert watched(failed, failed, Finished(number=44)).failures == [failed]
    assert watched(failed, failed, Finished(number=4)).failures == []


def test_what_a_cluster_says_is_shown_below_the_jobs_own_log(folder):
    Path("own.log").write_text("1.5 0.85 solved\n")
    Path("7.log").write_text("what Snakemake says\n")
    one = Job(number=4, rule="scan", output=["a.parquet"], log=["own.log", "7.log"])
    assert explanations(Failed(jobs=[one], reason="SLURM status is: 'TIMEOUT'")) == [
        [
            "FAILED: rule scan, making a.parquet",
            "    1.5 0.85 solved",
            "    SLURM status is: 'TIMEOUT'",
            "  log: own.log, 7.log",
        ]
    ]


GROUP = [
    job("curves", ["a.curves"], "curves.log", number=2),
    job("points", ["a.points"], "points.log", number=1),
]


def test_of_several_rules_in_a_cluster_job_the_one_that_failed_is_shown(folder):
    Path("curves.log").write_text("1.5 0.85 solved\n")
    Path("points.log").write_text("error: the reason\n")
    Path("points.failure.json").touch()
    Path("7.log").write_text("what Snakemake says\n")
    failed = Failed(jobs=GROUP, logs=["7.log"])
    assert explanations(failed, failed) == [
        [
            "FAILED: rule points, making a.points",
            "    error: the reason",
            "  log: points.log, 7.log",
        ]
    ]
    assert explanations(failed, Finished(number=2)) == []


def test_a_cluster_job_that_was_killed_says_what_the_scheduler_wrote(folder):
    Path("curves.log").touch()
    Path("curves.failure.json").touch()
    Path("7.log").write_text("*** JOB 7 CANCELLED DUE TO TIME LIMIT ***\n")
    assert explanations(Failed(jobs=GROUP, logs=["7.log"])) == [
        [
            "FAILED: rule curves, making a.curves",
            "    *** JOB 7 CANCELLED DUE TO TIME LIMIT ***",
            "  log: curves.log, 7.log",
        ]
    ]


def test_of_a_cluster_job_that_never_began_all_rules_are_named(folder):
    Path("curves.log").write_text("1.5 0.85 solved\n")
    Path("7.log").write_text("*** JOB 7 CANCELLED ***\n")
    assert explanations(Failed(jobs=GROUP, logs=["7.log"])) == [
        [
            "FAILED: rule curves, points, making a.curves, a.points",
            "    *** JOB 7 CANCELLED ***",
            "  log: 7.log, curves.log, points.log",
        ]
    ]


@pytest.mark.slow
def test_the_log_of_an_earlier_run_is_not_shown(wrapped):
    Path("job.log").write_text("error: long ago\n")
    os.utime("job.log", (0, 0))
    result = wrapped(failure(Failed(jobs=[job("figure", ["a.svg"])])))
    assert last_lines(result, 3) == [
        "FAILED: rule figure, making a.svg",
        "    (nothing in its log)",
        "  log: job.log",
    ]


def test_a_rule_without_log_and_output(folder):
    assert explanations(Failed(jobs=[job("all", [], "")])) == [
        [
            "FAILED: rule all, making (no output)",
            "    (nothing in its log)",
            "  log: (the rule has no log file)",
        ]
    ]


@pytest.mark.slow
def test_a_damaged_table_is_removed_and_what_failed_is_run_again(wrapped):
    tables = Path("results/here/tables")
    tables.mkdir(parents=True)
    Path("elsewhere.parquet").touch()
    code = f"""
print(*ARGUMENTS)
if "--forcerun" not in ARGUMENTS:
    Path("results/here/tables/a.parquet").touch()
    for name in ("results/here/tables/a", "elsewhere"):
        record = json.dumps(dict(damaged=f"{{name}}.parquet", errno=None))
        Path(Path(name).name).with_suffix(".failure.json").write_text(record)
    send({Failed(jobs=[job("curves", ["a", "b"], "a.log")])!r})
    send({Failed(jobs=[job("scan", ["c"], "elsewhere.log", number=5)])!r})
    sys.exit(1)
"""
    result = wrapped(code)
    assert result.returncode == 0, result.stderr
    first, again = result.stdout.splitlines()
    assert "--forcerun a b c --logger" in again and "--forcerun" not in first
    assert "tables/a.parquet is damaged" in result.stderr
    assert not (tables / "a.parquet").exists()
    assert Path("elsewhere.parquet").exists()


@pytest.mark.slow
def test_a_run_that_is_asked_to_end_is_not_begun_again(wrapped):
    Path("results/here/tables").mkdir(parents=True)
    code = f"""
signal.signal(signal.SIGTERM, signal.SIG_IGN)
os.kill(os.getppid(), signal.SIGTERM)
print("once")
Path("results/here/tables/a.parquet").touch()
record = json.dumps(dict(damaged="results/here/tables/a.parquet", errno=None))
Path("a.failure.json").write_text(record)
send({Failed(jobs=[job("curves", ["a", "b"], "a.log")])!r})
sys.exit(1)
"""
    result = wrapped(code)
    assert (result.returncode, result.stdout) == (1, "once\n")
    assert "FAILED: rule curves" in result.stderr


@pytest.mark.slow
@pytest.mark.parametrize("number", ["errno.ENOSPC", "errno.EDQUOT"])
def test_a_full_disk_is_told_by_the_number_of_its_error(wrapped, number):
    code = f"send(Problem(message='Traceback', errno={number}))\nsys.exit(1)"
    (line,) = last_lines(wrapped(code))
    assert line == (
        "The disk of results/here (or your share of it) is full; make space and run the same "
        "command again."
    )
    assert "Traceback" not in wrapped(code).stderr


def test_beside_a_full_disk_other_problems_are_shown(folder, capsys):
    full, other = Problem(message="Traceback", errno=errno.ENOSPC), Problem(message="no such rule")
    ending.report_failure(ending.Outcome(problems=[full, other], status=1), Path("results/here"))
    said = "The disk of results/here (or your share of it) is full; make space and run the same"
    assert capsys.readouterr().err == f"no such rule\n{said} command again.\n"


def test_of_a_log_the_last_lines_are_shown(tmp_path):
    empty, log = tmp_path / "empty.log", tmp_path / "job.log"
    empty.write_text(" \n")
    log.write_text("".join(f"line {n}\n\n" for n in range(9)))
    os.utime(log, (100.0, 100.0))
    logs = [str(tmp_path / "none.log"), str(empty), str(log)]
    assert ending.last_lines(logs, 100.0) == [f"line {n}" for n in range(3, 9)]
    assert ending.last_lines(logs, 100.5) == []


def test_progress_is_shown_every_few_percent_and_at_the_end(capsys):
    watched(*(Progress(done=i, total=250) for i in range(1, 251)))
    shown = capsys.readouterr().err.splitlines()
    assert [re.search(r"\((\d+)%\)", line)[1] for line in shown] == [
        f"{5 * n}" for n in range(1, 21)
    ]
    assert shown[-1] == "250 of 250 steps (100%) done"
    # However little is left.
    watched(Progress(done=98, total=100), Progress(done=100, total=100))
    assert capsys.readouterr().err.splitlines()[-1] == "100 of 100 steps (100%) done"


@pytest.mark.parametrize(
    ("status", "said"),
    [(1, ""), (-1, "ended by signal 1 (SIGHUP);"), (-9, "ended by signal 9 (SIGKILL);")],
)
def test_a_signal_that_ended_snakemake_is_named(status, said, folder, capsys):
    ending.report_failure(ending.Outcome(status=status), Path("results/here"))
    told = f"Snakemake was {said} the same command continues.\n" if said else ""
    assert capsys.readouterr().err == told


def test_a_snakemake_that_is_killed_may_leave_half_an_event(capsys):
    receiver, sender = Pipe(duplex=False)
    sender.send(Planned(jobs=2))
    os.write(sender.fileno(), bytes(2))
    sender.close()
    outcome = ending.Outcome()
    outcome.watch(receiver, progress=True)
    assert outcome.planned == 2


def test_two_runs_at_the_same_time_are_refused(folder):
    Path(".snakemake/locks").mkdir(parents=True)
    with run.acquire_lock(), pytest.raises(SystemExit, match=r"Another run .* is active"):
        run.acquire_lock()
    assert Path(".snakemake/locks").exists()


def test_the_lock_of_a_killed_run_is_removed(folder, capsys):
    Path(".snakemake/locks").mkdir(parents=True)
    run.acquire_lock().close()
    assert Path(".snakemake/locks").exists()
    run.acquire_lock().close()
    assert not Path(".snakemake/locks").exists()
    assert "The last run was killed" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("snakemake", ["", "sys.exit(1)"])
def test_a_run_that_came_to_its_end_leaves_no_lock(wrapped, snakemake):
    wrapped(snakemake)
    assert "was killed" not in wrapped(snakemake).stderr


@pytest.mark.slow
@pytest.mark.parametrize("study", ["..", "/", "a/b", "", "a b", "7.5"])
def test_only_the_folder_of_a_study_is_mended(wrapped, folder, study):
    """A mistaken name must not have anything removed elsewhere."""
    name = folder if study == "/" else study
    (folder / "results/a/b").mkdir(parents=True)
    Path("config.yaml").write_text(f"study: '{name}'\n{GRIDS}")
    home = Path("results", str(name))
    for path in (home / "figures", home / "tables"):
        path.mkdir(parents=True, exist_ok=True)
        (path / "mine.svg").touch()
        (path / ".mine-1.tmp.svg").touch()
        (path / "mine.parquet").touch()
    before = sorted(folder.rglob("*mine*"))
    result = wrapped(problem("refused"))
    assert sorted(folder.rglob("*mine*")) == before
    assert "damaged" not in result.stderr


def test_a_damaged_file_that_cannot_be_removed_is_named(folder, monkeypatch, capsys):
    def refuse(path):
        raise OSError(30, "Read-only file system")

    Path("a.parquet").touch()
    monkeypatch.setattr(Path, "unlink", refuse)
    assert not run.remove_damaged([Path("a.parquet")], set())
    assert capsys.readouterr().err == (
        "a.parquet is damaged, and cannot be removed (Read-only file system).\n"
    )


@pytest.mark.slow
@pytest.mark.parametrize("argument", ["-n", "--dry-run"])
def test_a_dry_run_removes_nothing(wrapped, argument):
    path = Path("results/here/figures/a.svg")
    path.parent.mkdir(parents=True)
    path.touch()
    wrapped("", argument)
    assert path.exists()
    assert "results/here/figures/a.svg is damaged" in wrapped("").stderr
    assert not path.exists()


@pytest.mark.slow
def test_a_lock_that_is_not_this_commands_is_explained(wrapped):
    result = wrapped(problem("Error: Directory cannot be locked.", locked=True))
    assert "rm -r .snakemake/locks" in last_lines(result)[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("workflow/profiles/mine", "workflow/profiles/mine"),
        ("workflow/profiles/slurm", str(places.PROFILES / "slurm")),
        ("slurm", str(places.PROFILES / "slurm")),
        ("none", "none"),
    ],
)
def test_a_profile_is_found_by_its_path_or_name(wrapped, name, path):
    Path("workflow/profiles/mine").mkdir(parents=True)
    arguments = wrapped(SHOW, "--workflow-profile", name).stdout.splitlines()
    assert arguments[2:4] == ["--workflow-profile", path]


def test_a_missing_profile_is_named(wrapped):
    result = wrapped("print('started')", "--workflow-profile", "slrum")
    assert result.returncode == 1 and not result.stdout
    assert result.stderr == ("No such profile: slrum; there are: cluster-generic, default, slurm\n")


def test_a_folder_that_is_named_may_be_there(folder):
    Path("there").mkdir()
    known, arguments = run.parsed(["--configfile", "my.yaml", "-d", "there", "all"])
    assert Path.cwd() == folder / "there" and known.configfile == [str(folder / "my.yaml")]
    assert arguments[:2] == ["--configfile", str(folder / "my.yaml")] and arguments[-1] == "all"


@pytest.mark.slow
def test_the_study_runs_in_the_folder_that_is_named(wrapped, folder):
    Path("my.yaml").write_text(f"study: mine\n{GRIDS}")
    code = f"{SHOW}; Path('here').touch()"
    result = wrapped(code, "--configfile", "my.yaml", "-d", "a/b", "all")
    assert result.returncode == 0, result.stderr
    assert (folder / "a/b/here").exists()
    assert result.stdout.splitlines()[:2] == ["--configfile", str(folder / "my.yaml")]
    assert "-d" not in result.stdout.split()


@pytest.mark.parametrize("arguments", [["--configfile", "no.yaml"], ["--configfile=no.yaml"]])
def test_a_missing_study_file_is_named(wrapped, arguments):
    result = wrapped("print('started')", *arguments)
    assert (result.returncode, result.stderr) == (1, "No such study file: no.yaml\n")


def test_a_study_file_that_is_not_yaml_is_named(wrapped):
    Path("bad.yaml").write_text("study: [\n")
    result = wrapped("print('started')", "--configfile", "bad.yaml")
    assert result.returncode == 1
    assert result.stderr.startswith("bad.yaml:2: not valid YAML: ")
    assert "Traceback" not in result.stderr


def test_a_study_file_that_is_not_text_is_named(wrapped):
    Path("bad.yaml").write_bytes(b"study: \xff\xfe\n")
    result = wrapped("print('started')", "--configfile", "bad.yaml")
    assert result.returncode == 1
    assert "bad.yaml" in result.stderr
    assert "Traceback" not in result.stderr


def test_all_mistakes_of_a_study_file_are_told_before_the_run(wrapped):
    Path("bad.yaml").write_text("study: a b\ncontact: tip\n" + GRIDS)
    result = wrapped("print('started')", "--configfile", "bad.yaml")
    assert (result.returncode, result.stdout) == (1, "")
    first, second = result.stderr.splitlines()
    assert first.startswith("bad.yaml:1: study: 'a b' is not allowed")
    assert second.startswith("bad.yaml:2: contact: 'tip' is not allowed")


def test_two_study_files_are_refused(wrapped):
    Path("my.yaml").write_text(f"study: mine\n{GRIDS}")
    result = wrapped("print('started')", "--configfile", "config.yaml", "my.yaml")
    assert (result.returncode, result.stdout) == (1, "")
    assert result.stderr.startswith("2 study files are given (config.yaml, my.yaml); one is")


@pytest.mark.parametrize(
    ("change", "name"),
    [("study=other", "Study 'other'"), ("study=a b", "--config: study: 'a b'")],
)
def test_changes_of_the_command_line_are_checked_with_the_file(wrapped, change, name):
    assert wrapped("", "--config", change).stderr.startswith(name)
