"""Programs of OpenFOAM in folders whose names OpenFOAM does not take."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_REFUSED = re.compile(r"[\s\"']")


@contextmanager
def started_in(folder: Path, command: list[str]) -> Iterator[list[str]]:
    """Yield `command` so that OpenFOAM, started with it in `folder`, takes the folder's name.

    OpenFOAM refuses white space and quotes in a path, and asks PWD where it is. Such a folder gets
    a link of a plain name for as long as the block lasts; any other leaves `command` as it is.
    """
    path = folder.resolve()
    if not _REFUSED.search(str(path)):
        yield command
        return
    with tempfile.TemporaryDirectory(prefix="elutria-") as place:
        link = Path(place) / "case"
        link.symlink_to(path, target_is_directory=True)
        yield ["env", f"--chdir={link}", f"PWD={link}", *command]
