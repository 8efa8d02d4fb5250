"""What was measured: cut sizes, flows and dispersion of grains in gas, as in the laboratory.

Processor time: pipe two minutes, settings six; of the bed three minutes a run: bed three runs,
bed_velocities five, bed_settings seven; riser four minutes, riser_slower thirteen, riser_inputs 50,
riser_settings two; each of the others half a minute at most.
"""

from __future__ import annotations

from elutria_validation.chapters.measured_bed import bed, bed_velocities
from elutria_validation.chapters.measured_bed_settings import bed_settings
from elutria_validation.chapters.measured_cut import cut_in_air
from elutria_validation.chapters.measured_dispersion import dispersion
from elutria_validation.chapters.measured_pipe import pipe, settings
from elutria_validation.chapters.measured_riser import (
    riser,
    riser_inputs,
    riser_settings,
    riser_slower,
)
from elutria_validation.chapters.measured_seeds import seeds

NAME = "measured"
TITLE = "Against measurements"
HELP = "Against measurements: cut sizes in air, dispersion, a pipe, seeds, a bed, a riser."

SECTIONS = (cut_in_air, pipe, settings, dispersion, seeds, bed, bed_velocities, bed_settings,
            riser, riser_slower, riser_inputs, riser_settings)  # fmt: skip
