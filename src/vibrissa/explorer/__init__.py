"""The model in a browser: a page that solves the rod anew at every move of its clamp.

The solver in `solver` and the page's program in `view` are JavaScript modules, checked by
TypeScript's compiler. They share no code with the solver in Python;
`python -m validation explorer-agreement` compares the two.
"""
