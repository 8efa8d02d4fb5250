"""What tests share: a stand-in solver, malformed inputs, meshes, sweeps."""
