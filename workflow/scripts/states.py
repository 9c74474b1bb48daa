"""Solve the study's single states."""

from vibrissa import jobs, records, solve_state, tables

with jobs.logged(snakemake.log[0]):
    states = {name: solve_state(**point) for name, point in snakemake.params.states.items()}
    tables.write(records.states_table(states), snakemake.output[0], snakemake.params.study_file)
