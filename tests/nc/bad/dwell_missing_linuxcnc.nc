; axis_without_motion 2 linuxcnc (X is a time for fanuc and haas only)
G4 X1
