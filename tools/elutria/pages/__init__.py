"""Results as one file to hand on: the report, and the atlas that answers between the runs."""
