; macro_alarm 2
#3000=7 (TOOL WORN)
