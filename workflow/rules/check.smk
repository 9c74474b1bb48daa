# `snakemake check`: what moved against the reference tables of tests/regression/<study>/.


rule check:
    input:
        stiction=f"{RESULTS}/tables/stiction.parquet",
        scans=f"{RESULTS}/tables/scans.parquet" if STUDY.scans else [],
        states=f"{RESULTS}/tables/states.parquet" if STUDY.states else [],
    log:
        f"{RESULTS}/logs/check.log",
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        python=sys.executable,
        program=places.CHECK,
        reference=places.reference_tables(STUDY.name),
        results=lambda wildcards, input: Path(input.stiction).parents[1],
    message:
        "comparing the tables with {params.reference}"
    shell:
        "{params.python} {params.program:q} --results {params.results:q}"
        " --reference {params.reference:q} 2>&1 | tee {log:q}"
