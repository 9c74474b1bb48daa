"""The explorer: a web page that solves the rod at every move of its clamp.

The JavaScript modules in `solver` and `view` share no code with the solver in Python;
`python -m validation explorer-agreement` compares the two.
"""
