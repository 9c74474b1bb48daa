"""Records in validation/records: the results of long checks, each written by its check."""

from pathlib import Path

from vibrissa.files import write_atomically

FOLDER = Path(__file__).parent / "records"


def write_record(name: str, about: str, found: str, command: str | None = None) -> None:
    """Write a record in Markdown.

    Parameters
    ----------
    name : str
        Name of the check, and of the file.
    about : str
        Docstring of the check's module; its first line becomes the title.
    found : str
        Results.
    command : str, optional
        Name of the check with its options; default: `name`.
    """
    title, _, rest = about.strip().partition("\n")
    parts = (
        f"# {title.rstrip('.')}",
        rest,
        f"Written by `python -m validation {command or name}`.",
        found,
    )
    path = FOLDER / f"{name}.md"
    with write_atomically(path) as temporary:
        text = "\n\n".join(part.strip() for part in parts if part.strip())
        temporary.write_text(f"{text}\n", encoding="utf-8")
    print(f"{path} is written")
