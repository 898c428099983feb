; parameter_unknown 2 linuxcnc
G0 X#<_hal[plasmac.cut-feed-rate]>
M2
