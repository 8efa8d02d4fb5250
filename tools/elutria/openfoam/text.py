"""Values of an OpenFOAM dictionary found in its text, where foamlib does not read it: `#ifeq`,
`#eval` and the like stay as they are, and both branches of a condition are found."""

from __future__ import annotations

import re
from collections.abc import Sequence

_TOKEN = re.compile(
    r"""//[^\n]* | /\*.*?\*/ | \#\{.*?\#\} | "(?:\\.|[^"\\])*" | [{}();] | [^\s{}();"]+""",
    re.DOTALL | re.VERBOSE,
)
_COMMENT = re.compile(r'("(?:\\.|[^"\\\n])*")|//[^\n]*|/\*.*?\*/', re.DOTALL)
_LINE = re.compile(r"[^\n]*")


def without_comments(text: str) -> str:
    """`text` with a blank for each of its comments."""
    return _COMMENT.sub(lambda found: found[1] or " ", text)


def values_of(text: str, keys: Sequence[str]) -> list[tuple[int, int]]:
    """Start and end of each value that the entry `keys`, a name below the other, has in `text`.
    A directive at the start of an entry (`#include`, `#else`) ends with its line."""
    found: list[tuple[int, int]] = []
    within: list[str] = []
    words: list[tuple[int, int]] = []  # of the entry that has begun
    depth = at = 0  # depth: of brackets within the entry
    while token := _TOKEN.search(text, at):
        at, word = token.end(), token[0]
        if word.startswith(("//", "/*")):
            continue
        if not words and word.startswith("#"):
            at = max(at, _LINE.match(text, token.start()).end())  # type: ignore[union-attr]
        elif depth == 0 and word == "{" and len(words) == 1:
            within.append(text[slice(*words.pop())])
        elif depth == 0 and word == "}":
            within, words = within[:-1], []
        elif depth == 0 and word == ";":
            if len(words) > 1 and [*within, text[slice(*words[0])]] == list(keys):
                found.append((words[1][0], words[-1][1]))
            words = []
        else:
            depth += (word in "({") - (word in ")}") if len(word) == 1 else 0
            words.append(token.span())
    return found


def with_value(text: str, keys: Sequence[str], value: str) -> str:
    """`text` with `value` as each value that the entry has."""
    for start, end in reversed(values_of(text, keys)):
        text = text[:start] + value + text[end:]
    return text


def line_with(text: str, part: str) -> int:
    """Number of the first line of `text` that holds `part`, blanks and quotes aside; 0: none."""

    def bare(words: str) -> str:
        return re.sub(r'[\s"]', "", words)

    lines = enumerate(text.splitlines(), start=1)
    return next((number for number, line in lines if bare(part) in bare(line)), 0)
