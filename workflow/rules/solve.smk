# From the grid to stiction.parquet: curves are solved in blocks, grid points read off them.


rule curves:
    input:
        code=sources(STUDY.method, "records", "jobs"),
    output:
        f"{RESULTS}/blocks/{STUDY.solver}/{{block}}.curves.parquet",
    log:
        f"{RESULTS}/logs/curves/{{block}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/curves/{{block}}.tsv"
    threads: 1
    params:
        method=STUDY.method,
        contact=STUDY.contact,
        curves=lambda wildcards: [list(key) for key in BLOCKS[wildcards.block]],
    message:
        "solving the sticking curves of block {wildcards.block}"
    script:
        "../scripts/curves.py"


rule points:
    input:
        curves=rules.curves.output,
        code=sources("stiction", "records", "jobs"),
    output:
        f"{RESULTS}/blocks/{STUDY.solver}/{{block}}.points.parquet",
    log:
        f"{RESULTS}/logs/points/{{block}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/points/{{block}}.tsv"
    threads: 1
    params:
        readings=lambda wildcards: READINGS[wildcards.block],
    message:
        "reading grid points off block {wildcards.block}"
    script:
        "../scripts/points.py"


rule stiction:
    input:
        points=expand(rules.points.output, block=READINGS),
        code=sources("collecting", "jobs"),
    output:
        f"{RESULTS}/tables/stiction.parquet",
    log:
        f"{RESULTS}/logs/stiction.log",
    benchmark:
        f"{RESULTS}/benchmarks/stiction.tsv"
    localrule: True
    threads: 1
    params:
        grids={name: grid.spelled(axes) for name, axes in STUDY.grids.items()},
        study_file=study_file("grids"),
    message:
        "collecting the table of grid points"
    script:
        "../scripts/stiction.py"
