"""The statements of the paper, each judged by the tables of its study.

A statement is one function with the decorator `vibrissa.paper.ledger.claim`, in the module of its
section. It takes the evidence; where it calls a solver or takes a number from elsewhere, a keyword
puts another in its place. The verdict follows from the computed quantities.
"""
