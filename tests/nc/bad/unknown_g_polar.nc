; unknown_g 2 linuxcnc
G16
