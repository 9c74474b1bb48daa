"""What a wheel gets beyond the Python files: its commit, and the workflow with the paper's study.

They lie in it as in a clone, below the package: `vibrissa.pipeline.places` finds them there.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ROOT = Path(__file__).parent
sys.path.insert(0, str(ROOT / "src"))

from vibrissa.provenance import COMMIT_FILE, commit  # noqa: E402  (found by the line above)


class Hook(BuildHookInterface[Any]):
    """Adds files to a wheel and, the commit alone, to a source distribution."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Name the files to be added; an editable installation has them in its clone."""
        if version == "editable":
            return
        self.folder = TemporaryDirectory()
        recorded = Path(self.folder.name, COMMIT_FILE)
        recorded.write_text(f"{commit()}\n", encoding="utf-8")
        added = build_data["force_include"]
        package = "src/vibrissa" if self.target_name == "sdist" else "vibrissa"
        # A wheel that is made of a source distribution takes the file from there.
        if not (ROOT / "src/vibrissa" / COMMIT_FILE).exists():
            added[str(recorded)] = f"{package}/{COMMIT_FILE}"
        if self.target_name == "wheel":
            for name in ("Snakefile", "config.yaml", "workflow"):
                added[str(ROOT / name)] = f"{package}/{name}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove what is now in the archive."""
        if version != "editable":
            self.folder.cleanup()
