"""The deb-src entries that are derived from a machine's own apt configuration."""

from __future__ import annotations

import hashlib
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
CODENAME = re.search(r"^VERSION_CODENAME=(\w+)", Path("/etc/os-release").read_text(), re.M)
SUITE = CODENAME[1] if CODENAME else "bookworm"

STANZAS = f"""\
# the archive's mirror
Types: deb deb-src
URIs: http://mirror.example/debian
Suites: {SUITE} {SUITE}-updates
Components: main contrib
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg

Types: deb
# a comment inside
URIs: http://mirror.example/safe
Suites: {SUITE}-security
Components: main
Architectures: amd64
Signed-By:
 -----BEGIN PGP PUBLIC KEY BLOCK-----
 .
 abcdef
 -----END PGP PUBLIC KEY BLOCK-----

Types: deb
URIs: http://other.example/off
Suites: {SUITE}
Components: main
Enabled: no

Types: deb
URIs: http://other.example/containers
Suites: {SUITE}
Components: stable

Types: deb
URIs: http://other.example/programs
Suites: nodistro
Components: main
"""

LINES = f"""\
# deb http://other.example/comment {SUITE} main
deb http://mirror.example/debian {SUITE} main contrib # trailing words
deb [arch=amd64 signed-by=/etc/keys/a.gpg] http://mirror.example/safe {SUITE}-security main
deb-src http://mirror.example/debian {SUITE} main
deb [trusted=yes] http://other.example/database {SUITE}-pgdg main
deb http://other.example/flat ./
"""


@pytest.fixture
def apt_folder(tmp_path: Path) -> Path:
    (tmp_path / "sources.list.d").mkdir()
    return tmp_path


def derived(apt_folder: Path) -> str:
    script = 'source "$1/etc/setup/sources"; sourceEntries "$2" main'
    run = subprocess.run(
        ["bash", "-euc", script, "bash", str(ROOT), str(apt_folder)],
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stderr == ""
    return run.stdout


def archives(entries: str) -> list[tuple[str, str]]:
    """Address and suites of each entry."""
    fields = re.findall(r"^URIs: (\S+)\nSuites: (.+)$", entries, re.M)
    return sorted(fields)


EXPECTED = [
    ("http://mirror.example/debian", f"{SUITE} {SUITE}-updates"),
    ("http://mirror.example/safe", f"{SUITE}-security"),
]


def test_stanzas_of_debian_become_source_entries(apt_folder: Path) -> None:
    (apt_folder / "sources.list.d/debian.sources").write_text(STANZAS)
    entries = derived(apt_folder)
    assert archives(entries) == EXPECTED
    assert re.findall(r"^Types: (.*)", entries, re.M) == ["deb-src", "deb-src"]
    assert "Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg\n" in entries
    assert "Signed-By:\n -----BEGIN PGP PUBLIC KEY BLOCK-----\n .\n abcdef\n" in entries
    assert "Architectures" not in entries


def test_one_line_entries_of_debian_become_source_entries(apt_folder: Path) -> None:
    (apt_folder / "sources.list").write_text(LINES)
    entries = derived(apt_folder)
    assert archives(entries) == [("http://mirror.example/debian", SUITE), EXPECTED[1]]
    assert "Components: main contrib\n" in entries
    assert "signed-by: /etc/keys/a.gpg\n" in entries


def test_a_machine_without_sources_gives_none(apt_folder: Path) -> None:
    assert derived(apt_folder) == ""


@pytest.mark.skipif(shutil.which("apt-get") is None, reason="no apt on this machine")
def test_apt_understands_what_is_derived(apt_folder: Path) -> None:
    (apt_folder / "sources.list").write_text(LINES)
    (apt_folder / "sources.list.d/debian.sources").write_text(
        STANZAS.replace("example/", "example/second-")
    )
    (apt_folder / "derived.sources").write_text(derived(apt_folder))
    (apt_folder / "none").mkdir()
    own = {
        "Dir::Etc::sourcelist": apt_folder / "derived.sources",
        "Dir::Etc::sourceparts": apt_folder / "none",
        "Dir::State::lists": apt_folder / "none",
    }
    run = subprocess.run(
        ["apt-get", "update", "--print-uris", *(f"-o{name}={path}" for name, path in own.items())],
        capture_output=True,
        text=True,
        check=True,
    )
    asked = {
        address.rsplit("/dists/")[0] for address in re.findall(r"^'([^']+)'", run.stdout, re.M)
    }
    assert run.stderr == ""
    assert asked == {
        "http://mirror.example/debian",
        "http://mirror.example/safe",
        "http://mirror.example/second-debian",
        "http://mirror.example/second-safe",
    }


@pytest.mark.skipif(shutil.which("apt-get") is None, reason="no apt on this machine")
@pytest.mark.parametrize(("changed", "got"), [(False, True), (True, False)])
def test_a_tarball_is_fetched_without_its_dsc(tmp_path: Path, changed: bool, got: bool) -> None:
    """From an archive on disk; a tarball other than the index says is refused."""
    archive = tmp_path / "archive"
    archive.mkdir()
    tarball = b"the source"
    sums = {"part_1.orig.tar.xz": hashlib.sha256(tarball).hexdigest(), "part_1-2.dsc": "0" * 64}
    (archive / "part_1.orig.tar.xz").write_bytes(tarball[::-1] if changed else tarball)
    listed = "".join(f"\n {digest} 10 {name}" for name, digest in sums.items())
    (archive / "Sources").write_text(
        f"Package: part\nBinary: part\nVersion: 1-2\nDirectory: .\nChecksums-Sha256:{listed}\n"
    )
    (tmp_path / "elutria.sources").write_text(
        f"Types: deb-src\nURIs: file:{archive}\nSuites: ./\nTrusted: yes\n"
    )
    script = 'source "$1/etc/setup/sources"; fetchSource "$2" part 1-2'
    run = subprocess.run(
        ["bash", "-c", script, "bash", str(ROOT), str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode == 0) == got, run.stdout + run.stderr
    assert (tmp_path / "source.tar").exists() == got
