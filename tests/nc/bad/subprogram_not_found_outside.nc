; subprogram_not_found 2 linuxcnc
o<../../etc/passwd> call
