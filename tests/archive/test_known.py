"""A small archive as a whole: each entity of its metadata, its page and its checksums."""

import hashlib
import json
import zipfile

import pytest
from rocrate.rocrate import ROCrate

from known import Known
from vibrissa import __version__
from vibrissa.archive.crate import CODE, archived_files, write_archive

KNOWN = Known(__file__)
ALONE = """
  - family-names: Haar
    given-names: Vera
    orcid: https://orcid.org/0000-0000-0000-0001
    affiliation: Whisker Laboratory
"""
TOGETHER = f"""{ALONE}
  - name: Vibrissa developers
    website: https://example.org/vibrissa
  - family-names: Bart
"""
CITATION = """
title: "Vibrissa: a study"
abstract: |
  What it is.
license: MIT
authors:"""
MADE = ("tables/stiction.parquet", "figures/b.svg", "figures/a.png", "claims.md")


def project(root, authors):
    """A project of which each file holds its own name, and results of a study in it."""
    for name in CODE:
        path = root / name
        if path.suffix or name in ("LICENSE", "Makefile", "Snakefile"):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(name)
        else:
            (path / "__pycache__").mkdir(parents=True)
            for one in ("a.py", "commit.txt", "__pycache__/a.pyc"):
                (path / one).write_text(f"{name}/{one}")
    (root / "CITATION.cff").write_text(CITATION + authors)
    results = root / "results/own"
    for name in (*MADE, "figures/old.svg"):
        (results / name).parent.mkdir(parents=True, exist_ok=True)
        (results / name).write_text(name)
    (root / "own.yaml").write_text("study: own\n")
    return results


@pytest.mark.parametrize("study_file", ["own.yaml", "config.yaml"])
@pytest.mark.parametrize("authors", [ALONE, TOGETHER], ids=["one author", "three authors"])
def test_an_archive_says_all_of_itself(tmp_path, study_file, authors):
    root, output = tmp_path / "project", tmp_path / "own.zip"
    results = project(root, authors)
    write_archive(root, results, MADE, root / study_file, "0123abcd", output)
    with zipfile.ZipFile(output) as file:
        texts = {name: file.read(name) for name in sorted(file.namelist())}
    graph = json.loads(texts.pop("ro-crate-metadata.json"))["@graph"]
    sums = dict(line.split("  ")[::-1] for line in texts["checksums.sha256"].decode().splitlines())
    assert sums == {
        name: hashlib.sha256(text).hexdigest()
        for name, text in texts.items()
        if name != "checksums.sha256"
    }
    known = {one["@id"]: one for one in graph}
    made = known["./"].pop("datePublished")
    assert known["#run"].pop("endTime") == made
    readme = texts["README.md"].decode().replace(__version__, "1.2.3")
    known["./"]["description"] = known["./"]["description"].replace(__version__, "1.2.3")
    for name, text in texts.items():
        if name != "Snakefile":
            size = known[name].pop("contentSize")
            assert size == str(len(text))
    name = f"{study_file}, {authors.count('- ')} authors"
    KNOWN.check(name, {"readme": readme.splitlines(), "names": list(texts), "graph": known})
    assert ROCrate(output).get("#run")["object"].id.endswith(study_file)


def test_the_files_of_an_archive_come_in_one_order(tmp_path):
    results = project(tmp_path, ALONE)
    found = archived_files(tmp_path, results, MADE, tmp_path / "own.yaml")
    names = list(found)
    assert names[-5:] == [
        "studies/own.yaml",
        "results/own/claims.md",
        "results/own/figures/a.png",
        "results/own/figures/b.svg",
        "results/own/tables/stiction.parquet",
    ]
    assert all(path.is_file() for path in found.values())
    assert not [name for name in names if "commit.txt" in name or "pycache" in name]
