"""Bundling of JavaScript modules into one script without imports, to embed in a page."""

import re
from collections import Counter
from graphlib import TopologicalSorter
from pathlib import Path

FOLDER = Path(__file__).parent
_IMPORT = re.compile(r'^import \{[^}]*\} from "(.*?)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=(?:async )?(?:const|let|class|function)\b)", re.MULTILINE)
_COMMENT = re.compile(r"^ */\*\*(?s:.*?)\*/\n|/\*\*.*?\*/ |^ *//.*\n", re.MULTILINE)
_NAME = re.compile(r"^(?:async )?(?:const|let|class|function\*?) (\w+)", re.MULTILINE)


def bundle(*entries: str) -> str:
    """Join JavaScript modules, and all modules that they import, into one script.

    The script has no import, no export and no comment.

    Raises
    ------
    ValueError
        If two modules define the same name.
    """
    imports: dict[Path, list[Path]] = {}
    waiting = [FOLDER / entry for entry in entries]
    while waiting:
        path = waiting.pop()
        text = path.read_text(encoding="utf-8")
        imports[path] = [(path.parent / name).resolve() for name in _IMPORT.findall(text)]
        waiting += [other for other in imports[path] if other not in imports]
    script = "\n".join(_body(path) for path in TopologicalSorter(imports).static_order())
    twice = [name for name, count in Counter(_NAME.findall(script)).items() if count > 1]
    if twice:
        raise ValueError(f"more than one module has the names {', '.join(twice)}")
    return script


def _body(path: Path) -> str:
    text = _COMMENT.sub("", path.read_text(encoding="utf-8"))
    return _EXPORT.sub("", _IMPORT.sub("", text)).strip() + "\n"
