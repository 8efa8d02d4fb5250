"""A Slurm of this machine alone, of Debian's packages: munged, slurmctld, slurmd, on loopback."""

from __future__ import annotations

import getpass
import os
import secrets
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

PACKAGES = ("slurmctld", "slurmd", "slurm-client", "munge")
_PROGRAMS = ("slurmctld", "slurmd", "munged", "sbatch", "squeue")


def need() -> None:
    """Install Slurm where that is possible; the test is skipped where it is not."""
    pytest.importorskip("submitit", reason="no submitit: etc/setup/cluster installs it")
    command = ["apt-get", "-y", "--no-install-recommends", "install", *PACKAGES]
    if _missing() and os.getuid() == 0 and shutil.which("apt-get"):
        quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive", "RUNLEVEL": "1"}
        subprocess.run(command, env=quiet, capture_output=True, check=False)
    if missing := _missing():
        pytest.skip(f"no Slurm ({', '.join(missing)}): {' '.join(command)}")


def _missing() -> list[str]:
    places = os.environ["PATH"] + ":/usr/sbin:/sbin"
    return [program for program in _PROGRAMS if shutil.which(program, path=places) is None]


def free_port() -> int:
    """A port of loopback that nobody listens on."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port: int = one.getsockname()[1]
        return port


def _configuration(place: Path, cpus: int) -> str:
    host, user = socket.gethostname().partition(".")[0], getpass.getuser()
    return f"""
ClusterName=loopback
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={place}/munge.socket
CredType=cred/munge
StateSaveLocation={place}/state
SlurmdSpoolDir={place}/spool
SlurmctldPidFile={place}/slurmctld.pid
SlurmdPidFile={place}/slurmd.pid
SlurmctldLogFile={place}/slurmctld.log
SlurmdLogFile={place}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
KillWait=5
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


@contextmanager
def slurm(place: Path, cpus: int = 2) -> Iterator[Path]:
    """A running Slurm with one node; gives its configuration, for SLURM_CONF."""
    place.mkdir(mode=0o755)
    for name in ("state", "spool"):
        (place / name).mkdir(mode=0o755)
    (place / "key").write_bytes(secrets.token_bytes(1024))
    (place / "key").chmod(0o400)
    conf = place / "slurm.conf"
    conf.write_text(_configuration(place, cpus))
    places = {**os.environ, "SLURM_CONF": str(conf), "PATH": f"{os.environ['PATH']}:/usr/sbin"}
    own = {name: f"{place}/{name}" for name in ("munge.socket", "key", "munge.pid", "munge.log")}
    with ExitStack() as ends:
        for command in (
            ["munged", "--foreground", "--force", f"--socket={own['munge.socket']}",
             f"--key-file={own['key']}", f"--pid-file={own['munge.pid']}",
             f"--log-file={own['munge.log']}", f"--seed-file={place}/seed"],
            ["slurmctld", "-D", "-f", str(conf)],
            ["slurmd", "-D", "-f", str(conf)],
        ):  # fmt: skip
            log = ends.enter_context((place / f"{command[0]}.out").open("w"))
            process = subprocess.Popen(command, env=places, stdout=log, stderr=log)
            ends.callback(_end, process)
            time.sleep(0.5)
        _wait_for_node(places, place)
        yield conf


def _wait_for_node(places: dict[str, str], place: Path) -> None:
    end = time.monotonic() + 60
    said = ""
    while "idle" not in said:
        if time.monotonic() > end:
            raise RuntimeError(f"no Slurm: {said}; see {place}/slurmctld.log, slurmd.log")
        time.sleep(0.5)
        done = subprocess.run(
            ["sinfo", "-h", "-o", "%T"], env=places, capture_output=True, text=True, check=False
        )
        said = done.stdout + done.stderr


def _end(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(20)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
