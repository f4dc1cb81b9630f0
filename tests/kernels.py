"""A kernel for the notebooks of tests, of which nothing is left."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from jupyter_client.manager import KernelManager, start_new_kernel
from nbformat import NotebookNode

from pgm_book.make.notebooks import KERNEL, client


@contextmanager
def started(folder: Path) -> Iterator[KernelManager]:
    """Start a kernel in a folder, and end it."""
    manager, first = start_new_kernel(kernel_name=KERNEL["name"], cwd=str(folder))
    first.stop_channels()
    try:
        yield manager
    finally:
        manager.shutdown_kernel(now=True)


def run(notebook: NotebookNode, folder: Path, kernel: KernelManager) -> None:
    """Run a notebook in a folder, in a kernel that goes on."""
    one = client(notebook, folder, kernel)
    try:
        one.execute()
    finally:
        one.kc.stop_channels()
