"""Solve the sticking curves of one block."""

import numpy as np

from vibrissa.outcomes import Contact, RodSection, Solver
from vibrissa.pipeline import jobs
from vibrissa.study.codec import decode_box, encode_key
from vibrissa.study.grid import keys_of
from vibrissa.tables import records, store
from vibrissa.tables.mounted import mounting_of

with jobs.logged(snakemake.log[0]):
    section = RodSection(snakemake.params.section)
    keys = list(keys_of(decode_box(snakemake.params.curves)))
    # NaN for the dx0 of a curve that serves all.
    theta, eta, dx0 = np.array([key[:3] for key in keys], dtype=float).T
    # A job depends on the solver that it uses alone.
    if Solver(snakemake.params.method) is Solver.COLLOCATION:
        from vibrissa.sticking.solving import collocation

        contact = Contact(snakemake.params.contact)
        mountings = [mounting_of(key.mounting) for key in keys]
        curves = collocation.solve_curves(theta, eta, contact, mountings, section)
    else:
        from vibrissa.sticking.solving import shooting

        rods = zip(theta, eta, dx0, strict=True)
        curves = [shooting.solve_curve(*rod, section=section) for rod in rods]
    for key, curve in zip(keys, curves, strict=True):
        print(*encode_key(key), curve.status, f"residual {curve.residual:.1e}", curve.message)
    store.write(records.curves_table(keys, curves), snakemake.output[0])
