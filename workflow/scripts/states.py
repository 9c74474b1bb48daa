"""Solve the study's single states."""

from vibrissa import solve_state
from vibrissa.pipeline import jobs
from vibrissa.study.model import StateSection
from vibrissa.tables import records, store

with jobs.logged(snakemake.log[0]):
    states = {}
    for name, written in snakemake.params.states.items():
        state = StateSection.model_validate(written)
        contact = state.contact or snakemake.params.solver["contact"]
        states[name] = solve_state(state.theta, state.eta, state.x1, contact=contact)
    table = records.states_table(states, snakemake.params.study)
    store.write(table, snakemake.output[0], snakemake.params.study_part)
