"""A study as one file for a repository of research data: results and code, as an RO-Crate.

The archive is itself a copy of the project, as far as it runs the study. So it can be unpacked
anywhere and make its results again; see `vibrissa.archive.reproduction`.
"""

import hashlib
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

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
STUDY_FOLDER = "studies"
RUN = "#run"
PROCESS_RUN = "https://w3id.org/ro/wfrun/process/0.5"
BIOSCHEMAS = "https://bioschemas.org/profiles/ComputationalWorkflow/1.0-RELEASE"
_FORMATS = {
    ".txt": "text/plain",
    ".parquet": "application/vnd.apache.parquet",
    ".yaml": "application/yaml",
    ".py": "text/x-python",
    ".md": "text/markdown",
    ".csv": "text/csv",
    ".html": "text/html",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".pdf": "application/pdf",
}
_README = """# Study {study}

Results of the study `{study}` and the program that made them: vibrissa {version}, commit {commit}.

| | |
| --- | --- |
| `{results}/` | tables, figures, report |
| `{study_file}` | the study file |
| `docs/tables.md` | what each column of the tables is |
| `docs/model.md` | the model |
| `requirements.lock` | the versions of all packages |
| `{checksums}` | SHA-256 of each file: `sha256sum --check {checksums}` |
| `ro-crate-metadata.json` | this description for machines (RO-Crate) |

To make the results again and compare them with these, bit for bit (make and Python 3.11 to 3.13):

    make verify
"""


class ArchiveError(VibrissaError):
    """A study that cannot be archived, or an archive that cannot be used."""


def archived_files(
    root: Path, results: Path, made: Iterable[str], study_file: Path
) -> dict[str, Path]:
    """List what an archive holds.

    Parameters
    ----------
    root : Path
        The project.
    results : Path
        ``results/<study>``.
    made : iterable of str
        What the study makes there; anything else in the folder is left out.
    study_file : Path

    Returns
    -------
    dict of Path
        Sources by their place in the archive.

    Raises
    ------
    ArchiveError
        If a part of the project is not there, as where it was installed from a wheel.
    """
    if absent := [name for name in CODE if not (root / name).exists()]:
        raise ArchiveError(
            f"{root} has no {', '.join(absent)}; make archive needs a clone of the project"
        )
    files: dict[str, Path] = {}
    for name in CODE:
        path = root / name
        found = sorted(path.rglob("*")) if path.is_dir() else [path]
        files |= {one.relative_to(root).as_posix(): one for one in found if _is_source(one)}
    if study_file.resolve() != (root / "config.yaml").resolve():
        files[f"{STUDY_FOLDER}/{study_file.name}"] = study_file
    return files | {f"results/{results.name}/{name}": results / name for name in sorted(made)}


def _is_source(path: Path) -> bool:
    return path.is_file() and "__pycache__" not in path.parts and path.name != COMMIT_FILE


def checksum(path: Path) -> str:
    """Compute the SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_archive(
    root: Path,
    results: Path,
    made: Iterable[str],
    study_file: Path,
    commit: str,
    output: Path,
) -> Mapping[str, Path]:
    """Write the archive of a study, whole or not at all.

    Parameters
    ----------
    root : Path
        The project.
    results : Path
        ``results/<study>``, with the results that the code and the study file of today make.
    made : iterable of str
        Their names, as `vibrissa.study.model.Study.results`.
    study_file : Path
    commit : str
        Commit of the code.
    output : Path
        ZIP file.

    Returns
    -------
    mapping of Path
        The files in it, by their place there.

    Raises
    ------
    ArchiveError
        If the code was edited since its commit, so that the commit does not name it.
    """
    if commit.endswith("-dirty"):
        raise ArchiveError(
            f"the code was edited since commit {commit.removesuffix('-dirty')}; commit the "
            "changes, run the study again, and archive it then"
        )
    files = archived_files(root, results, made, study_file)
    study = next((f for f in files if f.startswith(f"{STUDY_FOLDER}/")), "config.yaml")
    with TemporaryDirectory() as folder:
        made = {
            # Found by `vibrissa.provenance` where there is no git.
            f"src/vibrissa/{COMMIT_FILE}": f"{commit}\n",
            "README.md": _README.format(
                study=results.name,
                version=__version__,
                commit=commit,
                results=f"results/{results.name}",
                study_file=study,
                checksums=CHECKSUMS,
            ),
        }
        files |= {name: _written(Path(folder), name, text) for name, text in made.items()}
        sums = "".join(f"{checksum(path)}  {name}\n" for name, path in sorted(files.items()))
        files[CHECKSUMS] = _written(Path(folder), CHECKSUMS, sums)
        crate = _crate(root, results.name, commit)
        _add_run(crate, files, results.name, study, commit)
        with write_atomically(output) as temporary:
            crate.write_zip(temporary)
    return files


def _written(folder: Path, name: str, text: str) -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def _crate(root: Path, study: str, commit: str) -> ROCrate:
    """Say what the archive is, who made it, and under which license."""
    cited = yaml.safe_load((root / "CITATION.cff").read_text(encoding="utf-8"))
    crate = ROCrate(version="1.1")
    crate.name = f"Study {study}: {cited['title']}"
    crate.description = (
        f"Tables, figures and report of the study {study}, with the study file and the program "
        f"that made them (vibrissa {__version__}, commit {commit}). {cited['abstract'].strip()}"
    )
    crate.datePublished = datetime.now(UTC).replace(microsecond=0).isoformat()
    crate.root_dataset["version"] = commit
    crate.keywords = "tactile sensor, vibrissa, elastic rod, Coulomb friction, parameter study"
    authors = [_author(crate, number, one) for number, one in enumerate(cited["authors"], 1)]
    crate.root_dataset["author"] = authors if len(authors) > 1 else authors[0]
    crate.license = crate.add(
        ContextEntity(
            crate,
            f"https://spdx.org/licenses/{cited['license']}",
            {"@type": "CreativeWork", "name": cited["license"], "description": "the file LICENSE"},
        )
    )
    return crate


def _add_run(
    crate: ROCrate, files: Mapping[str, Path], study: str, study_file: str, commit: str
) -> None:
    """Add the files, and how the results were made."""
    workflow = crate.add_workflow(
        files["Snakefile"],
        "Snakefile",
        main=True,
        lang="snakemake",
        properties={
            "name": "Parameter study of a tapered rod",
            "version": commit,
            "encodingFormat": _FORMATS[".txt"],
        },
    )
    workflow["conformsTo"] = crate.add(_profile(crate, BIOSCHEMAS, "ComputationalWorkflow"))
    crate.root_dataset["conformsTo"] = crate.add(_profile(crate, PROCESS_RUN, "Process Run Crate"))
    entities = {
        name: crate.add_file(path, name, properties=_properties(name, path))
        for name, path in files.items()
        if name != "Snakefile"
    }
    entities["README.md"]["about"] = crate.root_dataset
    made = [one for name, one in entities.items() if name.startswith("results/")]
    properties = {
        "name": f"Run of the study {study}",
        "description": "Snakemake made the results of the study file",
        "endTime": crate.root_dataset["datePublished"],
    }
    action = crate.add_action(
        workflow, RUN, object=entities[study_file], result=made, properties=properties
    )
    authors = crate.root_dataset["author"]
    action["agent"] = authors[0] if isinstance(authors, list) else authors
    crate.root_dataset["mentions"] = action


def _profile(crate: ROCrate, identifier: str, name: str) -> ContextEntity:
    return ContextEntity(crate, identifier, {"@type": "CreativeWork", "name": name})


def _properties(name: str, path: Path) -> dict[str, Any]:
    return {
        "name": name,
        "contentSize": str(path.stat().st_size),
        "encodingFormat": _FORMATS.get(path.suffix, _FORMATS[".txt"]),
    }


def _author(crate: ROCrate, number: int, cited: Mapping[str, str]) -> ContextEntity:
    """Describe an author of CITATION.cff: a person with a family name, or an organization."""
    person = "family-names" in cited
    names = [cited.get("given-names"), cited.get("family-names")] if person else [cited["name"]]
    properties = {
        "@type": "Person" if person else "Organization",
        "name": " ".join(name for name in names if name),
    }
    if "affiliation" in cited:
        properties["affiliation"] = cited["affiliation"]
    identifier = cited.get("orcid") or cited.get("website") or f"#author-{number}"
    return crate.add(ContextEntity(crate, identifier, properties))
