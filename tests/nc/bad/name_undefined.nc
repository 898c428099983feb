; name_undefined 2 linuxcnc
G0 X#<depth>
