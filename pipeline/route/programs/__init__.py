"""The mixed-integer programs: over the core, and the paper's over all regions, in full and compact."""
