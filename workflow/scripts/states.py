"""Solve the study's single states."""

from vibrissa import jobs, records, solve_state, tables

with jobs.logged(snakemake.log[0]):
    contact = snakemake.params.contact
    points = snakemake.params.states.items()
    states = {name: solve_state(**point, contact=contact) for name, point in points}
    tables.write(records.states_table(states), snakemake.output[0], snakemake.params.study_file)
