import importlib.util
import io
import os
import pty
import signal
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "workflow/run.py"
spec = importlib.util.spec_from_file_location("run", SCRIPT)
run = importlib.util.module_from_spec(spec)
spec.loader.exec_module(run)

# Stands in for Snakemake in the working directory, where `python -m snakemake` looks first.
FAKE = """
import sys
from pathlib import Path


def say(text):
    print(text, file=sys.stderr, flush=True)

"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config.yaml").write_text("study: here\n")
    return tmp_path


@pytest.fixture
def command(folder):
    def make(snakemake, *arguments):
        (folder / "snakemake.py").write_text(FAKE + snakemake)
        return [sys.executable, SCRIPT, *arguments]

    return make


@pytest.fixture
def wrapped(command):
    """Run the script around a stand-in for Snakemake with the given code."""

    def call(snakemake, *arguments):
        return subprocess.run(command(snakemake, *arguments), capture_output=True, text=True)

    return call


def last_lines(result, count=1):
    return result.stderr.rstrip().splitlines()[-count:]


def test_arguments_go_through_to_snakemake(wrapped):
    Path("my.yaml").write_text("study: mine\n")
    result = wrapped("print(*sys.argv[1:])", "--configfile", "my.yaml", "-n", "--cores", "3")
    assert result.stdout.split() == [
        *("--workflow-profile", "workflow/profiles/default"),
        *("--configfile", "my.yaml", "-n", "--cores", "3"),
    ]
    assert result.stderr.startswith("Study 'mine': snakemake --workflow-profile")


@pytest.mark.parametrize(
    "arguments",
    [
        ["--configfile", "my.yaml"],
        ["--configfile=my.yaml"],
        ["--configfiles", "my.yaml"],
        ["--configfile", "config.yaml", "my.yaml"],
    ],
)
def test_the_study_that_runs_is_announced(wrapped, arguments):
    Path("my.yaml").write_text("study: mine\n")
    assert wrapped("", *arguments).stderr.startswith("Study 'mine': snakemake")


def test_a_terminal_gets_progress_bars(command):
    main, other = pty.openpty()
    process = subprocess.run(
        command("print(*sys.argv[1:])"),
        stdout=subprocess.PIPE,
        stderr=other,
        env=os.environ | {"TERM": "xterm"},
        text=True,
    )
    os.close(other)
    os.close(main)
    assert process.stdout.split()[-2:] == ["--logger", "rich"]


@pytest.mark.parametrize("status", [1, 2])
def test_a_message_without_a_failed_job_is_shown_and_the_status_kept(wrapped, status):
    result = wrapped(f"say('some reason')\nsys.exit({status})")
    assert result.returncode == status
    assert last_lines(result) == ["some reason"]


def test_where_a_message_comes_from_in_the_code_is_not_shown(wrapped):
    result = wrapped(
        "say('some reason')\nsay('  File \"a.smk\", line 3, in <module>')\nsys.exit(1)"
    )
    assert last_lines(result) == ["some reason"]


def test_a_killed_snakemake_is_reported(wrapped):
    result = wrapped("import os\nos.kill(os.getpid(), 9)")
    assert result.returncode == 137
    assert last_lines(result) == [
        "Snakemake was ended by signal 9 (SIGKILL); the same command continues."
    ]
    assert "The last run was killed" in wrapped("").stderr


def test_an_interrupted_run_says_how_to_go_on(command):
    process = subprocess.Popen(
        command(
            "import time\nsay('1 of 2 steps (50%) done')\n"
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


def test_the_end_of_a_good_run_lists_the_figures(wrapped):
    figures = Path("results/here/figures")
    figures.mkdir(parents=True)
    for name in ("b.pdf", "a.svg", "a.pdf", "captions.md"):
        (figures / name).write_text(name)
    result = wrapped("say('Building DAG')")
    assert result.returncode == 0
    assert last_lines(result, 3) == [
        "Figures in results/here/figures:",
        "  results/here/figures/a .pdf .svg",
        "  results/here/figures/b .pdf",
    ]


def test_the_verdicts_on_the_papers_statements_are_the_last_line(wrapped):
    folder = Path("results/here")
    folder.mkdir(parents=True)
    (folder / "claims.md").write_text("# Title\n\n2 statements: 1 holds, 1 ambiguous. Units are\n")
    assert last_lines(wrapped("")) == [
        "2 statements: 1 holds, 1 ambiguous (results/here/claims.md)"
    ]


def test_where_the_report_is_is_the_last_line(wrapped):
    folder = Path("results/here")
    folder.mkdir(parents=True)
    (folder / "claims.md").write_text("# Title\n\n2 statements: 2 holds. Units are\n")
    (folder / "report.html").touch()
    assert last_lines(wrapped(""), 2) == [
        "2 statements: 2 holds (results/here/claims.md)",
        "All on one page: results/here/report.html",
    ]


def test_a_study_without_figures(wrapped):
    assert last_lines(wrapped("")) == ["No figures in results/here/figures."]


LOG = Path(".snakemake/log/2026-01-01.snakemake.log")


def write_log(text):
    return f"log = Path('{LOG}')\nlog.parent.mkdir(parents=True)\nlog.write_text({text!r})\n"


def test_nothing_to_do_is_said(wrapped):
    result = wrapped(write_log("Nothing to be done (all requested files are present).\n"))
    assert "Nothing to do: all results are up to date." in result.stderr


def job_error(rule, output, log):
    return (
        f"[Sat Nov 21 04:46:09 2026]\nError in rule {rule}:\n    message: doing it\n"
        f"    jobid: 4\n    output: {output}\n"
        f"    log: {log} (check log file(s) for error details)\n"
        "Removing output files\n"
    )


def test_a_failed_job_is_the_last_thing_on_the_screen(wrapped):
    Path("job.log").write_text("line\n" * 20 + "error: the reason\n\n")
    text = job_error("figure", "a.svg, a.pdf", "job.log")
    result = wrapped(write_log(text) + "say('Shutting down')\nsys.exit(1)")
    assert result.returncode == 1
    assert "Shutting down" not in result.stderr
    assert last_lines(result, 8) == [
        "FAILED: rule figure, making a.svg, a.pdf",
        *["    line"] * 5,
        "    error: the reason",
        "  log: job.log",
    ]


def test_only_three_failed_jobs_are_shown_in_full(wrapped):
    Path("job.log").write_text("error: the reason\n")
    text = "".join(job_error("curves", f"{i}.parquet", "job.log") for i in range(5))
    lines = wrapped(write_log(text) + "sys.exit(1)").stderr.splitlines()
    assert [line for line in lines if line.startswith("FAILED")] == [
        f"FAILED: rule curves, making {i}.parquet" for i in (3, 4, 0, 1, 2)
    ]
    assert lines.count("    error: the reason") == 3
    assert lines[-1] == "  log: job.log"


@pytest.mark.parametrize(
    ("more", "shown"),
    [
        ("", "(empty log)"),
        ("Command 'python x' died with <Signals.SIGKILL: 9>.\n", "died with <Signals.SIGKILL: 9>."),
        ("Command 'x' returned non-zero exit status 1.\n", "returned non-zero exit status 1."),
    ],
)
def test_a_job_that_wrote_nothing_to_its_log(folder, more, shown):
    Path("empty.log").touch()
    (text,) = run.failed_jobs(job_error("curves", "a.parquet", "empty.log") + more)
    title, reason, log = text.splitlines()
    assert title == "FAILED: rule curves, making a.parquet"
    assert shown in reason
    assert log == "  log: empty.log"


def test_a_job_that_succeeded_when_tried_again_did_not_fail(folder):
    text = job_error("curves", "a.parquet", "a.log") + job_error("curves", "a.parquet", "a.log")
    assert len(run.failed_jobs(text)) == 1
    assert len(run.failed_jobs(text + "Finished jobid: 44 (Rule: curves)\n")) == 1
    assert run.failed_jobs(text + "Finished jobid: 4 (Rule: curves)\n") == []


def test_what_slurm_says_is_shown_below_the_jobs_own_log(folder):
    Path("own.log").write_text("1.5 0.85 solved\n")
    Path("7.log").write_text("what Snakemake says\n")
    text = job_error("scan", "a.parquet", "own.log, 7.log").replace(
        "doing it", "SLURM-job '7' failed, SLURM status is: 'TIMEOUT'. Detailed reason unavailable"
    )
    (shown,) = run.failed_jobs(text)
    assert shown.splitlines() == [
        "FAILED: rule scan, making a.parquet",
        "    1.5 0.85 solved",
        "    SLURM status is: 'TIMEOUT'",
        "  log: own.log, 7.log",
    ]


GROUP_ERROR = """\
[Sat Nov 21 09:12:56 2026]
    message: Error in group block
    log: 7.log (check log file(s) for error details)
    jobs:
        rule curves:
            jobid: 2
            output: a.curves
            log: curves.log (check log file(s) for error details)
        rule points:
            jobid: 1
            output: a.points
            log: points.log (check log file(s) for error details)
    [Sat Nov 21 09:12:56 2026]
    Error in rule curves:
        message: None
        jobid: 2
        output: a.curves
"""


def test_of_several_rules_in_a_cluster_job_the_one_that_failed_is_shown(folder):
    Path("curves.log").write_text("1.5 0.85 solved\n")
    Path("points.log").write_text("error: the reason\n")
    Path("7.log").write_text(2 * job_error("points", "a.points", "points.log"))
    assert [text.splitlines() for text in run.failed_jobs(2 * GROUP_ERROR)] == [
        ["FAILED: rule points, making a.points", "    error: the reason", "  log: points.log"]
    ]
    assert run.failed_jobs(GROUP_ERROR + "Finished jobid: 2 (Rule: curves)\n") == []


def test_a_cluster_job_that_was_killed_says_what_the_scheduler_wrote(folder):
    Path("7.log").write_text("*** JOB 7 CANCELLED DUE TO TIME LIMIT ***\n")
    (text,) = run.failed_jobs(GROUP_ERROR)
    title, reason, log = text.splitlines()
    assert title == "FAILED: group block, making a.curves, a.points"
    assert reason == "    *** JOB 7 CANCELLED DUE TO TIME LIMIT ***"
    assert log == "  log: 7.log, curves.log, points.log"


def test_without_the_schedulers_log_the_last_rule_that_said_something_is_shown(folder):
    text = GROUP_ERROR.replace("    log: 7.log (check log file(s) for error details)\n", "", 1)
    Path("curves.log").write_text("1.5 0.85 solved\n")
    Path("points.log").write_text("error: the reason\n")
    (shown,) = run.failed_jobs(text)
    assert shown.splitlines()[1:] == ["    error: the reason", "  log: points.log, curves.log"]


def test_a_rule_without_log_and_output(folder):
    (text,) = run.failed_jobs("Error in rule all:\n    jobid: 0\nmore\n")
    assert text.splitlines()[0] == "FAILED: rule all, making (no output)"
    assert text.splitlines()[-1] == "  log: (the rule has no log file)"


def test_progress_is_shown_every_few_percent_and_at_the_end(capsys):
    lines = [f"{i} of 250 steps ({i / 2.5:.1f}%) done\n" for i in range(1, 251)]
    other = run.print_progress(io.StringIO("".join(["first\n", *lines, "last\n"])))
    shown = capsys.readouterr().err.splitlines()
    assert other == ["first", "last"]
    assert 15 <= len(shown) <= 21
    assert shown[-1] == lines[-1].rstrip()


def test_only_the_last_other_lines_are_kept(capsys):
    other = run.print_progress(io.StringIO("".join(f"{i}\n" for i in range(100))))
    assert other == [str(i) for i in range(70, 100)]
    assert capsys.readouterr().err == ""


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


@pytest.mark.parametrize("snakemake", ["", "sys.exit(1)"])
def test_a_run_that_came_to_its_end_leaves_no_lock(wrapped, snakemake):
    wrapped(snakemake)
    assert "was killed" not in wrapped(snakemake).stderr


@pytest.mark.parametrize("study", ["..", "/", "a/b", "", "a b", "7.5"])
def test_only_the_folder_of_a_study_is_mended(wrapped, folder, study):
    """A mistaken name must not have anything removed elsewhere."""
    name = folder if study == "/" else study
    (folder / "results/a/b").mkdir(parents=True)
    Path("config.yaml").write_text(f"study: '{name}'\n")
    home = Path("results", str(name))
    for path in (home / "figures", home / "tables"):
        path.mkdir(parents=True, exist_ok=True)
        (path / "mine.svg").touch()
        (path / ".mine-1.tmp.svg").touch()
        (path / "mine.parquet").touch()
    before = sorted(folder.rglob("*mine*"))
    result = wrapped("say('refused')\nsys.exit(1)")
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


@pytest.mark.parametrize("argument", ["-n", "--dry-run"])
def test_a_dry_run_removes_nothing(wrapped, argument):
    path = Path("results/here/figures/a.svg")
    path.parent.mkdir(parents=True)
    path.touch()
    wrapped("", argument)
    assert path.exists()
    assert "results/here/figures/a.svg is damaged" in wrapped("").stderr
    assert not path.exists()


def test_a_lock_that_is_not_this_commands_is_explained(wrapped):
    result = wrapped("say('LockException:\\nError: Directory cannot be locked.')\nsys.exit(1)")
    assert "rm -r .snakemake/locks" in last_lines(result)[0]


def test_another_profile_takes_the_place_of_the_default_one(wrapped):
    Path("workflow/profiles/cluster").mkdir(parents=True)
    result = wrapped("print(*sys.argv[1:])", "--workflow-profile", "workflow/profiles/cluster")
    assert result.stdout.split() == ["--workflow-profile", "workflow/profiles/cluster"]


def test_a_missing_profile_is_named(wrapped):
    for name in ("default", "slurm"):
        Path("workflow/profiles", name).mkdir(parents=True)
    result = wrapped("say('started')", "--workflow-profile", "slurm")
    assert result.returncode == 1
    assert result.stderr == (
        "No such profile: slurm; there are: workflow/profiles/default, workflow/profiles/slurm\n"
    )


@pytest.mark.parametrize("arguments", [["--configfile", "no.yaml"], ["--configfile=no.yaml"]])
def test_a_missing_study_file_is_named(wrapped, arguments):
    result = wrapped("say('started')", *arguments)
    assert (result.returncode, result.stderr) == (1, "No such study file: no.yaml\n")


def test_a_study_file_that_is_not_yaml_is_named(wrapped):
    Path("bad.yaml").write_text("study: [\n")
    result = wrapped("say('started')", "--configfile", "bad.yaml")
    assert result.returncode == 1
    assert result.stderr.startswith("bad.yaml is not valid YAML: ")
    assert "Traceback" not in result.stderr


def test_a_study_file_that_is_not_text_is_named(wrapped):
    Path("bad.yaml").write_bytes(b"study: \xff\xfe\n")
    result = wrapped("say('started')", "--configfile", "bad.yaml")
    assert result.returncode == 1
    assert "bad.yaml" in result.stderr
    assert "Traceback" not in result.stderr
