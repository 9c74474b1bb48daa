"""Solve the sticking curves of one block."""

from importlib import import_module

from vibrissa import jobs, records, tables

with jobs.logged(snakemake.log[0]):
    keys = [tuple(key) for key in snakemake.params.curves]
    solver = import_module(f"vibrissa.{snakemake.params.method}")
    curves = solver.solve_keys(
        [[float(value) for value in key] for key in keys], snakemake.params.contact
    )
    for key, curve in zip(keys, curves, strict=True):
        print(*key, curve.status, f"residual {curve.residual:.1e}", curve.message)
    tables.write(records.curves_table(keys, curves), snakemake.output[0])
