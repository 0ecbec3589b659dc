"""Many scenes, and sweeps over their values: one process each, a manifest and a page of what came out."""
