"""Programs of OpenFOAM in folders whose names OpenFOAM does not take."""

from __future__ import annotations

import os
import re
import signal
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_REFUSED = re.compile(r"[\s\"']")
_LINK = re.compile(rf"{re.escape(tempfile.gettempdir())}/elutria-[^/\s]+/case\b")


@contextmanager
def started_in(folder: Path, command: list[str]) -> Iterator[list[str]]:
    """Yield `command` so that OpenFOAM, started with it in `folder`, takes the folder's name.

    OpenFOAM refuses white space and quotes in a path, and reads PWD whether it is right or not.
    Such a folder gets a link of a plain name for as long as the block lasts.
    """
    path = folder.resolve()
    if _REFUSED.search(str(path)):
        with tempfile.TemporaryDirectory(prefix="elutria-") as place:
            link = Path(place) / "case"
            link.symlink_to(path, target_is_directory=True)
            yield ["env", f"--chdir={link}", f"PWD={link}", *command]
    elif _REFUSED.search(os.environ.get("PWD", "")):
        yield ["env", f"PWD={path}", *command]
    else:
        yield command


def with_own_name(said: str, folder: Path) -> str:
    """A message of a program started so, with the folder's own name in place of the link's."""
    return _LINK.sub(lambda _: str(folder), said)


def killed(code: int) -> str:
    """What ended a program with this exit code, its own or mpirun's; empty unless by a signal."""
    number = -code if code < 0 else code - 128
    try:
        name = signal.Signals(number).name
    except ValueError:
        return ""
    why = ", as the system does where memory is short" if name == "SIGKILL" else ""
    return f"it was killed ({name}{why}); the same command goes on from the last time written"
