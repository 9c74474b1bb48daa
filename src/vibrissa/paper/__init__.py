"""The statements of the paper, each judged by the tables of its study.

`statements.toml` has their texts. A statement is judged by one function with the decorator
`vibrissa.paper.ledger.judges`, in the module of its section, which takes the evidence and returns a
verdict with the computed quantities.
"""
