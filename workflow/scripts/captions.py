"""Write down what each figure shows."""

from pathlib import Path

from vibrissa.files import write_atomically
from vibrissa.pipeline import jobs

with jobs.logged(snakemake.log[0]):
    captions = snakemake.params.captions.items()
    text = "\n\n".join(f"**{name}.** {caption}".strip() for name, caption in captions)
    with write_atomically(Path(snakemake.output[0])) as temporary:
        temporary.write_text(f"# Figures\n\n{text}\n", encoding="utf-8")
