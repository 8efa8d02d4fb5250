"""What a page asks of the column: checked here, written where the solver looks between steps."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from math import isfinite
from pathlib import Path
from typing import Any

from elutria.files import writing_to
from elutria.viewing.frames import FOLDER

LIMITS = {"gas": (0.05, 20.0), "loading": (0.01, 20.0), "speed": (0.0, 100.0)}


@dataclass(frozen=True)
class Control:
    """`gas` and `loading` over the case's; `speed`: s of the run in a second, 0: no limit."""

    gas: float = 1.0
    loading: float = 1.0
    pause: bool = False
    speed: float = 1.0

    def changed(self, asked: Any) -> Control:
        """With what a page asks for, as far as it makes sense."""
        wanted = asdict(self)
        if isinstance(asked, dict):
            for name in {field.name for field in fields(self)} & set(asked):
                value = asked[name]
                if name == "pause":
                    wanted[name] = value is True
                elif isinstance(value, (int, float)) and isfinite(value):
                    low, high = LIMITS[name]
                    wanted[name] = min(max(float(value), low), high)
        return Control(**wanted)

    def write(self, run: Path) -> None:
        """For the solver: RUN/postProcessing/frames/control, whole or not at all. It need not be on
        the disk, which would keep pages waiting."""
        file = run / FOLDER / "control"
        temporary = file.with_name(".control.new")
        with writing_to(file.parent):
            file.parent.mkdir(parents=True, exist_ok=True)
            temporary.write_text(
                f"gas {self.gas:.6g};\nloading {self.loading:.6g};\n"
                f"pause {'yes' if self.pause else 'no'};\nspeed {self.speed:.6g};\n"
            )
            temporary.replace(file)
