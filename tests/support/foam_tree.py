"""Folders that look like an OpenFOAM whose environment is sourced."""

from __future__ import annotations

from pathlib import Path


def foam_tree(folder: Path, release: str = "2412", wmake: bool = True) -> Path:
    """What elutria looks at of a release of openfoam.com, in folder; release "": not theirs."""
    for part in ("etc", "src", *(["wmake"] if wmake else [])):
        (folder / part).mkdir(parents=True, exist_ok=True)
    (folder / "etc/bashrc").touch()
    if release:
        (folder / "META-INFO").mkdir()
        (folder / "META-INFO/api-info").write_text(f"api={release}\npatch=0\n")
    return folder
