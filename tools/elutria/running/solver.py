"""The solver as a program that PyFoam runs and watches, line by line."""

from __future__ import annotations

import contextlib
import os
import re
import resource
import shutil
import signal
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PyFoam.Execution.BasicRunner import BasicRunner
from PyFoam.Execution.FoamThread import FoamThread

from elutria.files import writing_to
from elutria.openfoam.started import started_in

_STEP = re.compile(
    r"elutria: time (\S+) fed (\d+) fines (\d+) coarse (\d+) inside (\d+) lost (\d+)"
)


@dataclass(frozen=True)
class Step:
    """What the solver says after a time step."""

    time: float
    fed: int
    fines: int
    coarse: int
    inside: int
    lost: int


@dataclass(frozen=True)
class Outcome:
    """How a solver ended: `whole` when it said so itself; `reason` when it said why not."""

    whole: bool
    reason: str
    exit_code: int
    interrupted: bool


class _Program(FoamThread):  # type: ignore[misc]
    """PyFoam's thread, but the program gets its arguments as a list instead of through a shell."""

    def __init__(self, arguments: list[str], runner: BasicRunner):
        super().__init__(" ".join(arguments), runner)
        self.arguments = arguments

    def run(self) -> None:
        self.timeStart = time.time()
        self.resStart = resource.getrusage(self.who)
        try:
            process = subprocess.Popen(
                self.arguments,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
            )
        except OSError:
            self.returncode = 127
            return
        else:
            self.output = process.stdout
            self.threadPid = process.pid
            self.hasSomethingToSay = True
        finally:
            self.stateLock.release()  # held since PyFoam made this thread
        self.returncode = process.wait()
        self.threadPid = -1
        self.resEnd = resource.getrusage(self.who)
        self.timeEnd = time.time()


class _Runner(BasicRunner):  # type: ignore[misc]
    """Follows the lines that elutriaFoam begins with `elutria:`."""

    def __init__(self, arguments: list[str], log: str, on_step: Callable[[Step], None]):
        super().__init__(argv=arguments, silent=True, server=False, writeState=False)
        self.logFile = log
        self.run = _Program(arguments, self)
        self.on_step = on_step
        self.failed = ""
        self.finished = False

    def lineHandle(self, line: str) -> None:
        match = _STEP.match(line)
        if match:
            numbers = [int(text) for text in match.groups()[1:]]
            self.on_step(Step(float(match[1]), *numbers))
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
            if runner.run.threadPid > 0:
                os.kill(runner.run.threadPid, signal.SIGKILL)
            raise
        runner.run.join()
    code = int(runner.run.returncode)
    return Outcome(
        whole=runner.finished and not runner.failed and bool(runner.runOK()) and code == 0,
        reason=runner.failed,
        exit_code=code,
        interrupted=bool(result.get("interrupted")),
    )
