"""Many programs on many machines: one warm process per core or GPU, or a Dask cluster."""
