"""A study as one file for a repository of research data: results and code, as an RO-Crate.

The archive can be unpacked anywhere and make its results again: workflow/verify.py does it.
"""

import hashlib
import mimetypes
from collections.abc import Iterable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import unquote

import yaml
from rocrate.model import ContextEntity
from rocrate.rocrate import ROCrate

from vibrissa import __version__, provenance
from vibrissa.errors import VibrissaError
from vibrissa.files import write_atomically
from vibrissa.provenance import COMMIT_FILE

# What runs a study, and what explains it, relative to the project.
CODE = (
    *provenance.CODE,
    *("config.yaml", "LICENSE", "CITATION.cff"),
    *("docs/model.md", "docs/sketch.svg", "docs/tables.md"),
)
CHECKSUMS = "checksums.sha256"
RUN = "#run"
_README = """# Study {study}

Results of the study `{study}` and the program that made them: vibrissa {version}, commit {commit}.

| | |
| --- | --- |
| `results/{study}/` | tables, figures, report |
| `{study_file}` | the study file |
| `docs/tables.md` | what each column of the tables is |
| `docs/model.md` | the model |
| `locks/study.lock` | the versions of all packages |
| `{checksums}` | SHA-256 of each file: `sha256sum --check {checksums}` |
| `ro-crate-metadata.json` | this description for machines (RO-Crate) |

To make the results again and compare the tables with these (make and Python 3.11 to 3.13):

    make verify
"""


class ArchiveError(VibrissaError):
    """A study that cannot be archived, or an archive that cannot be used."""


def write_archive(
    root: Path,
    results: Path,
    made: Iterable[str],
    study_file: Path,
    commit: str,
    output: Path,
    scripts: Iterable[str] = (),
) -> Mapping[str, Path]:
    """Write the ZIP archive of a study atomically; return the source of each file by its place.

    Parameters
    ----------
    made : iterable of str
        Names of the results, as `vibrissa.study.model.Study.results`; anything else is left out.
    scripts : iterable of str
        The user's files that draw figures, relative to the study file.

    Raises
    ------
    ArchiveError
        If the code was edited since its commit, or if a part of the project is not there, as where
        it was installed from a wheel.
    """
    if commit.endswith("-dirty"):
        raise ArchiveError(
            f"the code was edited since commit {commit.removesuffix('-dirty')}; commit the "
            "changes, run the study again, and archive it then"
        )
    if absent := [name for name in CODE if not (root / name).exists()]:
        raise ArchiveError(
            f"{root} has no {', '.join(absent)}; make archive needs a clone of the project"
        )
    files = _code(root) | {f"results/{results.name}/{name}": results / name for name in made}
    study = "config.yaml"
    if study_file.resolve() != (root / study).resolve():
        study = f"studies/{study_file.name}"
        files[study] = study_file
    files |= {(Path(study).parent / one).as_posix(): study_file.parent / one for one in scripts}
    texts = {
        # Found by `vibrissa.provenance` where there is no git.
        f"src/vibrissa/{COMMIT_FILE}": f"{commit}\n",
        "README.md": _README.format(
            study=results.name,
            version=__version__,
            commit=commit,
            study_file=study,
            checksums=CHECKSUMS,
        ),
    }
    with TemporaryDirectory() as folder:
        files |= {name: _written(Path(folder, name), text) for name, text in texts.items()}
        sums = "".join(f"{checksum(path)}  {name}\n" for name, path in sorted(files.items()))
        files[CHECKSUMS] = _written(Path(folder, CHECKSUMS), sums)
        crate = _crate(root, results.name, commit, files, study)
        with write_atomically(output) as temporary:
            crate.write_zip(temporary)
    return files


def _code(root: Path) -> dict[str, Path]:
    """Files of the project that the archive holds, by their place there."""
    found = (
        one
        for name in CODE
        for one in (sorted((root / name).rglob("*")) if (root / name).is_dir() else [root / name])
    )
    return {
        one.relative_to(root).as_posix(): one
        for one in found
        if one.is_file() and "__pycache__" not in one.parts and one.name != COMMIT_FILE
    }


def _written(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def _crate(
    root: Path, study: str, commit: str, files: Mapping[str, Path], study_file: str
) -> ROCrate:
    """Describe the archive: what it is, who made it, its license, its files, and the run."""
    cited = yaml.safe_load((root / "CITATION.cff").read_text(encoding="utf-8"))
    crate = ROCrate(version="1.1")
    crate.name = f"Study {study}: {cited['title']}"
    crate.description = (
        f"Tables, figures and report of the study {study}, with the study file and the program "
        f"that made them (vibrissa {__version__}, commit {commit}). {cited['abstract'].strip()}"
    )
    crate.root_dataset["version"] = commit
    crate.root_dataset["author"] = [_author(crate, one) for one in cited["authors"]]
    license = f"https://spdx.org/licenses/{cited['license']}"
    crate.license = crate.add(
        ContextEntity(crate, license, {"@type": "CreativeWork", "name": cited["license"]})
    )
    workflow = crate.add_workflow(files["Snakefile"], "Snakefile", main=True, lang="snakemake")
    entities = {
        name: crate.add_file(path, name, properties=_properties(name, path))
        for name, path in files.items()
        if name != "Snakefile"
    }
    made = [one for name, one in entities.items() if name.startswith("results/")]
    properties = {"name": f"Run of the study {study}", "endTime": crate.datePublished.isoformat()}
    crate.root_dataset["mentions"] = crate.add_action(
        workflow, RUN, object=entities[study_file], result=made, properties=properties
    )
    return crate


def _properties(name: str, path: Path) -> dict[str, str]:
    kind = mimetypes.guess_type(name)[0] or "application/octet-stream"
    return {"name": name, "contentSize": str(path.stat().st_size), "encodingFormat": kind}


def _author(crate: ROCrate, cited: Mapping[str, str]) -> ContextEntity:
    """Describe an author of CITATION.cff: a person with a family name, or an organization."""
    person = "family-names" in cited
    names = [cited.get("given-names"), cited.get("family-names")] if person else [cited["name"]]
    name = " ".join(name for name in names if name)
    properties = {"@type": "Person" if person else "Organization", "name": name}
    identifier = cited.get("orcid") or cited.get("website") or f"#{name.replace(' ', '-')}"
    return crate.add(ContextEntity(crate, identifier, properties))


def checksum(path: Path) -> str:
    """Compute the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def checked_files(folder: Path) -> list[str]:
    """Return the names of the files of an unpacked archive.

    Raises
    ------
    ArchiveError
        If this is not one, or a file is gone or changed.
    """
    path = folder / CHECKSUMS
    if not path.is_file():
        raise ArchiveError(
            f"{folder} is not an unpacked archive: it has no {CHECKSUMS}; make archive makes one"
        )
    lines = [line.partition("  ") for line in path.read_text(encoding="utf-8").splitlines()]
    gone = [name for _, _, name in lines if not (folder / name).is_file()]
    changed = [n for total, _, n in lines if n not in gone and checksum(folder / n) != total]
    if gone or changed:
        faults = [f"{name} is missing" for name in gone] + [
            f"{name} has changed" for name in changed
        ]
        raise ArchiveError(f"the archive is damaged: {'; '.join(faults)}; unpack it again")
    return [name for _, _, name in lines]


def study_file_of(folder: Path) -> str:
    """Name of the study file of an unpacked archive."""
    return unquote(ROCrate(folder).get(RUN)["object"].id)
