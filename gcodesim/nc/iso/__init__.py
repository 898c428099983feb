"""ISO programs as Fanuc, Haas and LinuxCNC read them: characters to what the control is told."""
