"""From parcels that left to partition curves with intervals."""
