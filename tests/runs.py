"""Runs of the workflow as a person starts them, in folders of their own."""

import os
import re
import subprocess
import sys
from pathlib import Path

import loaded
from vibrissa.tables import schemas, store

ROOT = Path(__file__).parents[1]
TINY = """
study: tiny
chunk: {theta: 1}
grids:
  main: {theta: [1.5, 2], mu0: [0.3, 5], eta: [0.85], dx0: [5e-3]}
scans:
  runs: {theta: [2], mu0: [0.3], eta: [0.85], dx0: [0.005], cycles: 2}
states:
  inside: {theta: 1, eta: 0.55, x1: 0.15}
figures:
  taper: {kind: taper, grid: main}
  scan: {kind: scan, scan: runs, caption: Two cycles.}
  state: {kind: state, state: inside}
"""
STICTION = "results/tiny/tables/stiction.parquet"
TABLES = [f"tables/{name}.parquet" for name in ("stiction", "scans", "periods", "states")]
ARCHIVED = [*TABLES, "summary.txt", "report.html"]


class Folder:
    """A folder with a study file, and the program that runs it: the clone, or a copy of it."""

    def __init__(self, root, home=ROOT):
        self.root, self.home = root, home

    def write(self, name, text):
        (self.root / name).write_text(text)

    def edit(self, old, new, path="tiny.yaml"):
        text = (self.root / path).read_text()
        assert text.count(old) == 1
        self.write(path, text.replace(old, new))

    def call(self, *arguments, study="tiny.yaml"):
        """Exit status, and what stands on the screen."""
        command = [sys.executable, "-m", "vibrissa.pipeline", "--cores", "2", *arguments]
        result = subprocess.run(
            [*command, "--configfile", *study.split()],
            cwd=self.root,
            env=os.environ | {"PYTHONPATH": str(self.home / "src")},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        return result.returncode, result.stdout

    def run(self, *arguments, **options):
        status, screen = self.call(*arguments, **options)
        assert status == 0, screen
        return screen

    def dry_call(self, *arguments, study="tiny.yaml"):
        """Exit status of a dry run, and what stands on the screen."""
        told = self.root / "dry_run.txt"
        arguments = ["--cores", "2", *arguments, "--configfile", *study.split()]
        return loaded.dry_run(arguments, self.root, self.home, told), told.read_text()

    def dry_run(self, *arguments, **options):
        status, screen = self.dry_call(*arguments, **options)
        assert status == 0, screen
        return screen

    def jobs(self, *arguments, **options):
        """What a run would do: number of jobs by rule."""
        return self.jobs_on(self.dry_run(*arguments, **options))

    @staticmethod
    def jobs_on(screen):
        """Number of jobs by rule on the screen of a dry run."""
        found = {rule: int(n) for rule, n in re.findall(r"^(\w+) +(\d+)$", screen, re.M)}
        return {rule: n for rule, n in found.items() if rule not in ("all", "total")}

    def chunks(self):
        """Time of the last change of the file of each chunk, by its name."""
        found = self.root.glob("results/tiny/chunks/*/*.parquet")
        return {path.stem: path.stat().st_mtime_ns for path in found}

    def log(self, name):
        return (self.root / f"results/tiny/logs/{name}.log").read_text()

    def stiction(self):
        return store.read(self.root / STICTION, schemas.STICTION)
