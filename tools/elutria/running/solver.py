"""The solver as a program that PyFoam runs and watches, line by line."""

from __future__ import annotations

import contextlib
import re
import shutil
import signal
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from math import nan
from pathlib import Path
from typing import Any

from PyFoam.Execution.BasicRunner import BasicRunner

from elutria.files import writing_to
from elutria.openfoam.started import killed, started_in

_STEP = re.compile(r"elutria: time (\S+) fed (\d+)((?: \S+ \d+)*) inside (\d+) lost (\d+)")


@dataclass(frozen=True)
class Step:
    """What the solver says after a time step: parcels; `left` by product, in the feed's order.
    `ends_in_s` is how long the run still takes, nan where that is not known."""

    time: float
    fed: int
    left: dict[str, int]
    inside: int
    lost: int
    ends_in_s: float = nan


@dataclass(frozen=True)
class Outcome:
    """How a solver ended: `complete` when it said so itself; `reason` when it said why not."""

    complete: bool
    reason: str
    exit_code: int
    interrupted: bool


class _Process:
    """The program that PyFoam's runner watches, started from a list instead of through a shell.

    The runner asks for these names; it reads line by line until there is no more.
    """

    keyboardInterupted = False

    def __init__(self, arguments: list[str]):
        self.arguments = arguments
        self.returncode = 127  # not found, until it is started
        self._process: subprocess.Popen[str] | None = None
        self._line = ""
        self._more = False

    def start(self) -> None:
        with contextlib.suppress(OSError):
            self._process = subprocess.Popen(
                self.arguments,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="replace",
            )
            self._more = True

    def check(self) -> bool:
        return self._more

    def read(self) -> None:
        output = self._process.stdout if self._process else None
        line = output.readline() if output else ""
        self._more = bool(line)
        self._line = line.rstrip()

    def getLine(self) -> str:
        return self._line

    def interrupt(self, pass_int: bool = False) -> None:
        if self._process:
            self._process.send_signal(signal.SIGKILL if pass_int else signal.SIGINT)

    def wait(self) -> None:
        if self._process:
            self.returncode = self._process.wait()

    def _unknown(self) -> float:
        return nan

    cpuTime = cpuUserTime = cpuSystemTime = wallTime = usedMemory = _unknown


class _Runner(BasicRunner):  # type: ignore[misc]
    """Follows the lines that elutriaFoam begins with `elutria:`."""

    def __init__(self, arguments: list[str], log: str, on_step: Callable[[Step], None]):
        super().__init__(argv=arguments, silent=True, server=False, writeState=False)
        self.logFile = log
        self.run = _Process(arguments)
        self.on_step = on_step
        self.failed = ""
        self.finished = False

    def lineHandle(self, line: str) -> None:
        match = _STEP.match(line)
        if match:
            words = match[3].split()
            left = {name: int(text) for name, text in zip(words[::2], words[1::2], strict=True)}
            self.on_step(Step(float(match[1]), int(match[2]), left, int(match[4]), int(match[5])))
        elif line.startswith("elutria: failed:"):
            self.failed = line.removeprefix("elutria: failed:").strip()
        elif line.startswith("elutria: finished"):
            self.finished = True


def follow(folder: Path, command: list[str], log: str, on_step: Callable[[Step], None]) -> Outcome:
    """Run `command` in `folder`, its lines in `log` there, and wait for its end.

    The program ends when this process does. Raises InputError or ElutriaError when `folder` cannot
    be written any more.
    """
    if shutil.which("setpriv"):
        command = ["setpriv", "--pdeathsig", "KILL", *command]
    with (
        contextlib.chdir(folder),
        writing_to(folder),
        started_in(Path.cwd(), command) as placed,
    ):
        runner = _Runner(placed, log, on_step)
        try:
            result: dict[str, Any] = runner.start()
        except BaseException:  # our own trouble, such as a full disk: the solver must not go on
            runner.run.interrupt(pass_int=True)
            raise
        finally:
            runner.run.wait()
    code = runner.run.returncode
    return Outcome(
        complete=runner.finished and not runner.failed and bool(runner.runOK()) and code == 0,
        reason=runner.failed or killed(code),
        exit_code=code,
        interrupted=bool(result.get("interrupted")),
    )
