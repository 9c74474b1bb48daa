"""Run the notebooks again and store their outputs: `python -m validation notebooks`."""

import os
import sys
import tempfile
from pathlib import Path

import nbformat
from jupyter_client.kernelspec import KernelSpecManager
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from traitlets import default

# Time limit of a cell (s).
PATIENCE = 300
# The kernel that the notebooks name: any Python with Vibrissa.
KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}


class ThisPython(AsyncKernelManager):
    """Kernels on this interpreter, not on one that is installed elsewhere."""

    @default("kernel_spec_manager")
    def _no_other(self) -> KernelSpecManager:
        return KernelSpecManager(kernel_dirs=[])


def rerun(path: Path) -> nbformat.NotebookNode:
    """Run a notebook in its folder, from its first cell to its last, in a fresh kernel.

    Parameters
    ----------
    path : Path

    Returns
    -------
    NotebookNode
        The notebook with its new outputs, without the time and the machine of the run.

    Raises
    ------
    nbclient.exceptions.CellExecutionError
        If a cell raises an exception.
    """
    notebook = nbformat.read(path, as_version=4)
    client = NotebookClient(
        notebook,
        kernel_manager_class=ThisPython,
        kernel_name=KERNEL["name"],
        # Without this option the kernel warns that others on this machine could listen in.
        extra_arguments=["--log-level=ERROR"],
        timeout=PATIENCE,
        resources={"metadata": {"path": str(path.parent)}},
        record_timing=False,
    )
    with tempfile.TemporaryDirectory() as settings:
        # Without the user's own settings and startup files of IPython.
        client.execute(env={**os.environ, "IPYTHONDIR": settings})
    notebook.metadata = nbformat.from_dict(
        {"language_info": {"name": "python"}, "kernelspec": KERNEL}
    )
    for cell in notebook.cells:
        cell.metadata = nbformat.NotebookNode()
    nbformat.validate(notebook)
    return notebook


def main() -> None:
    """Rerun the notebooks named on the command line, or all."""
    here = Path(__file__).parent
    for path in [Path(name) for name in sys.argv[1:]] or sorted(here.glob("*.ipynb")):
        nbformat.write(rerun(path), path)
        print(f"{path.name}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main()
