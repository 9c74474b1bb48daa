"""Solve the study's single states."""

from vibrissa import solve_state
from vibrissa.computing.states import states_table
from vibrissa.pipeline import jobs
from vibrissa.tables import store

with jobs.logged(snakemake.log[0]):
    states = {name: solve_state(**state) for name, state in snakemake.params.states.items()}
    table = states_table(states, snakemake.params.study, snakemake.params.frequencies)
    store.write(table, snakemake.output[0], snakemake.params.study_part)
