"""What OpenFOAM wrote and reads: dictionaries, meshes, and its programs' ways with paths."""
