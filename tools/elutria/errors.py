"""What can go wrong, as a user is told: one line, and an exit code that scripts can rely on."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class ElutriaError(Exception):
    """Something failed while it was being done (a solver, a full disk): exit code 1."""

    exit_code = 1


class InputError(ElutriaError):
    """What the user gave cannot be used: exit code 2, found before anything is run.

    The message names the file, the entry, the value and what is allowed.
    """

    exit_code = 2


def suggestion(word: str, allowed: Iterable[str]) -> str:
    """`, did you mean 'density'?` when `word` is close to an allowed word, else ``""``."""
    close = difflib.get_close_matches(word, list(allowed), n=1, cutoff=0.6)
    return f", did you mean '{close[0]}'?" if close else ""


def one_line(text: object, limit: int = 160) -> str:
    """`text` on one line, at most `limit` characters, control characters made visible."""
    joined = " ".join(str(text).split())
    shown = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in joined)
    return shown if len(shown) <= limit else shown[: limit - 3] + "..."
