"""The statements of the paper, each judged by the tables of a study that repeats the paper.

`statements.toml` has their texts. A statement is judged by one function with the decorator
`vibrissa.paper.ledger.judges`, in the module of its section.
"""

TITLE = "Towards the Development of Tactile Sensors for Surface Texture Detection"
CITATION = (
    "The paper with this title; its authors, journal, year and DOI are not in the copy from which "
    "this study was made. Look them up by the title."
)
