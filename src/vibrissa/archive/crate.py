"""A study as one file for a repository of research data: results and code, as an RO-Crate.

In an unpacked archive, workflow/verify.py makes the results again.
"""

import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

import yaml
from rocrate.model import ContextEntity
from rocrate.rocrate import ROCrate

from vibrissa import __version__, provenance
from vibrissa.errors import VibrissaError
from vibrissa.files import write_atomically
from vibrissa.provenance import why_unknown
from vibrissa.tables import store

# Files and folders that run a study or explain it, relative to the project.
CODE = (
    *provenance.CODE,
    "config.yaml",
    "LICENSE",
    "CITATION.cff",
    "docs/model.md",
    "docs/sketch.svg",
    "docs/tables.md",
)
# Keys of CITATION.cff that describe the archive.
CITED = ("title", "abstract", "authors", "license")
_README = """# Study {study}

Results of the study `{study}` and the program that made them: vibrissa {version}, commit {commit}.

| | |
| --- | --- |
| `results/{study}/` | tables, figures, report |
| `config.yaml` | the study file |
| `docs/tables.md` | the meaning of each column of the tables |
| `docs/model.md` | the model |
| `locks/study.lock` | the versions of all packages |
| `ro-crate-metadata.json` | this description in machine-readable form (RO-Crate) |

To make the results again and compare the tables with these (make and Python 3.11 to 3.13):

    make verify
"""


class ArchiveError(VibrissaError):
    """A study that cannot be archived, or an archive that cannot be used."""


def need_committed(commit: str, tables: Iterable[Path]) -> None:
    """Refuse code whose commit is unknown or that was edited since, and tables of such code."""
    if commit == provenance.UNKNOWN:
        raise ArchiveError(
            f"the commit of the code is not known, so that it may be edited: {why_unknown()}"
        )
    made_by = {str(path): store.metadata(path)[store.COMMIT] for path in tables}
    for what, version in {"this archive": commit, **made_by}.items():
        if version == provenance.UNKNOWN:
            raise ArchiveError(
                f"{what} does not have the commit of its code, which was not known; delete the "
                "study's folder in results/, run the study again, and archive it then"
            )
        if version.endswith("-dirty"):
            raise ArchiveError(
                f"the code of {what} was edited since its commit ({version}); commit the changes, "
                "delete the study's folder in results/, run the study again, and archive it then"
            )


def write_archive(
    root: Path,
    results: Path,
    made: Iterable[str],
    study_file: Path,
    commit: str,
    output: Path,
    scripts: Iterable[str] = (),
) -> int:
    """Write the ZIP archive of a study atomically; return the number of its files.

    The study file is archived as ``config.yaml``, in place of the project's file of that name.

    Parameters
    ----------
    made : iterable of str
        Result files to archive, as in `vibrissa.study.model.Study.results`.
    scripts : iterable of str
        The user's files that draw figures, relative to the study file.

    Raises
    ------
    ArchiveError
        If `root` is not a clone of the project but, for example, an installed wheel.
    """
    if absent := [name for name in CODE if not (root / name).exists()]:
        raise ArchiveError(
            f"{root} has no {', '.join(absent)}: run the archive in a clone of the project"
        )
    sources = {name: root / name for name in CODE}
    sources |= {f"results/{results.name}/{name}": results / name for name in made}
    sources |= {name: study_file.parent / name for name in scripts} | {"config.yaml": study_file}
    with TemporaryDirectory() as name:
        folder = Path(name)
        for place, source in sources.items():
            _copy(source, folder / place)
        # `vibrissa.provenance` reads it where git is missing.
        (folder / f"src/vibrissa/{provenance.COMMIT_FILE}").write_text(f"{commit}\n", "utf-8")
        readme = _README.format(study=results.name, version=__version__, commit=commit)
        (folder / "README.md").write_text(readme, encoding="utf-8")
        with write_atomically(output) as temporary:
            _described(folder, results.name, commit).write_zip(temporary)
        return sum(path.is_file() for path in folder.rglob("*"))


def _copy(source: Path, place: Path) -> None:
    place.parent.mkdir(parents=True, exist_ok=True)
    if source.is_dir():
        shutil.copytree(source, place, ignore=shutil.ignore_patterns("__pycache__"))
    else:
        shutil.copy(source, place)


def _described(folder: Path, study: str, commit: str) -> ROCrate:
    """Describe the archive: what it is, who made it, its license, and its files."""
    try:
        cited = yaml.safe_load((folder / "CITATION.cff").read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise ArchiveError(f"CITATION.cff is not valid YAML: {error}") from None
    if missing := [key for key in CITED if not (isinstance(cited, dict) and cited.get(key))]:
        raise ArchiveError(f"CITATION.cff has no {', '.join(missing)}, which an archive needs")
    crate = ROCrate(folder, init=True, version="1.1")
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
    crate.add_workflow(folder / "Snakefile", "Snakefile", main=True, lang="snakemake")
    return crate


def _author(crate: ROCrate, cited: Mapping[str, str]) -> ContextEntity:
    """Describe an author of CITATION.cff: a person with a family name, or an organization."""
    name = " ".join(cited[key] for key in ("given-names", "family-names", "name") if key in cited)
    kind = "Person" if "family-names" in cited else "Organization"
    identifier = cited.get("orcid", f"#{name.replace(' ', '-')}")
    return crate.add(ContextEntity(crate, identifier, {"@type": kind, "name": name}))
