# What the computation says to the paper's statements, judged by the tables.


rule claims:
    input:
        stiction=f"{RESULTS}/tables/stiction.parquet",
        scans=f"{RESULTS}/tables/scans.parquet",
        states=f"{RESULTS}/tables/states.parquet",
        code=sources_file(
            "paper.claims",
            "paper.evidence",
            "paper.ledger",
            "tables.query",
            "files",
            "pipeline.jobs",
        ),
    output:
        table=f"{RESULTS}/tables/claims.parquet",
        text=f"{RESULTS}/claims.md",
    log:
        f"{RESULTS}/logs/claims.log",
    benchmark:
        f"{RESULTS}/benchmarks/claims.tsv"
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        study=STUDY.name,
        method=STUDY.method.value,
        names=dict(STUDY.claims or {}),
        study_file=study_file("claims"),
    message:
        "judging the paper's statements"
    script:
        "../scripts/claims.py"
