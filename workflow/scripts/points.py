"""Read the grid points of one block off its sticking curves."""

from vibrissa import grid, jobs, records, tables
from vibrissa.stiction import read_curve

with jobs.logged(snakemake.log[0]):
    grids = {name: grid.from_spelled(axes) for name, axes in snakemake.params.readings.items()}
    curves = records.curves_from_table(tables.read(snakemake.input.curves[0], tables.CURVES))
    parts = []
    for key, curve in curves.items():
        points = grid.points_of_curve(key, grids)
        if points:
            stiction = read_curve(curve, [p.mu0 for p in points], [p.dx0 for p in points])
            parts.append(records.stiction_table(points, curve, stiction))
    tables.write(tables.joined(parts, tables.STICTION), snakemake.output[0])
