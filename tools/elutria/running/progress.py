"""How far work is: bars on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from types import TracebackType

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    TaskID,
    TaskProgressColumn,
    TextColumn,
    TimeElapsedColumn,
)


class ProgressDisplay:
    """Several tasks, each from 0 to 1. Use as a context manager; safe to call from threads."""

    def __init__(self, console: Console, every: float = 5.0):
        self.console = console
        self.every = every
        self.bars: Progress | None = None
        if console.is_terminal:
            self.bars = Progress(
                TextColumn("{task.description}"),
                BarColumn(bar_width=30),
                TaskProgressColumn(),
                TimeElapsedColumn(),
                TextColumn("{task.fields[note]}", style="dim"),
                console=console,
            )
        self._tasks: dict[str, TaskID] = {}
        self._last: dict[str, float] = {}

    def __enter__(self) -> ProgressDisplay:
        if self.bars:
            self.bars.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self.bars:
            self.bars.stop()

    def update(self, name: str, share: float, note: str = "") -> None:
        """`name` is done to `share` (0..1)."""
        if self.bars:
            if name not in self._tasks:
                self._tasks[name] = self.bars.add_task(name, total=1.0, note=note)
            self.bars.update(self._tasks[name], completed=share, note=note)
        elif time.monotonic() - self._last.get(name, -1e9) >= self.every:
            self._last[name] = time.monotonic()
            self.say(f"{name}: {100 * share:.0f} % {note}".rstrip())

    def say(self, line: str) -> None:
        """One line above the bars, or on the output."""
        (self.bars.console if self.bars else self.console).print(
            line, highlight=False, markup=False, soft_wrap=True
        )

    def close(self, name: str) -> None:
        """`name` needs no bar any more."""
        if self.bars and name in self._tasks:
            self.bars.remove_task(self._tasks.pop(name))
