"""Run the study: python workflow/run.py [--configfile FILE] [any other Snakemake arguments].

`vibrissa.pipeline.run` says what it does beyond `snakemake`.
"""

import signal
import sys


def stop(number: int, _: object) -> None:
    """End while the program loads, before anything is begun."""
    print(f"Stopped by {signal.Signals(number).name}. Finished results are kept.", file=sys.stderr)
    sys.exit(128 + number)


for number in (signal.SIGINT, signal.SIGTERM):
    signal.signal(number, stop)

try:
    from vibrissa.pipeline.run import main
except ImportError as error:  # it says what to install
    sys.exit(str(error))

sys.exit(main(sys.argv[1:]))
