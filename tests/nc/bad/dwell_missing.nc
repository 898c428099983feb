; dwell_missing 2
G4
