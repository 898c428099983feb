"""Studies: what a check costs on this machine, stage by stage, beside the published figures."""
