# From the study file to the tables: stiction.parquet by chunks, the others by one job each.


rule chunk:
    input:
        again("chunks/{chunk}.parquet"),
    output:
        f"{RESULTS}/chunks/{{chunk}}.parquet",
    log:
        f"{RESULTS}/logs/chunks/{{chunk}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/chunks/{{chunk}}.tsv"
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    resources:
        runtime=lambda wildcards, attempt: attempt
        * STUDY.chunks[wildcards.chunk].minutes(STUDY.method.by_step),
    params:
        study=STUDY.name,
        grid=lambda wildcards: STUDY.chunks[wildcards.chunk].grid,
        axes=lambda wildcards: STUDY.chunks[wildcards.chunk].axes,
        solver=STUDY.solved,
        # Stored in the file: rule `stiction` refuses a chunk of another study file.
        study_part=lambda wildcards: STUDY.chunk_part(wildcards.chunk),
        code=SOLVING_CODE,
    message:
        "solving {wildcards.chunk}"
    script:
        "../scripts/chunk.py"


rule stiction:
    input:
        again("tables/stiction.parquet"),
        chunks=expand(rules.chunk.output, chunk=STUDY.chunks),
    output:
        f"{RESULTS}/tables/stiction.parquet",
    log:
        f"{RESULTS}/logs/stiction.log",
    benchmark:
        f"{RESULTS}/benchmarks/stiction.tsv"
    localrule: True
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        chunk_parts=list(map(STUDY.chunk_part, STUDY.chunks)),
        study_part=STUDY.part("stiction"),
        code=SOLVING_CODE,
    message:
        "joining the chunks into one table"
    script:
        "../scripts/stiction.py"


rule scans:
    input:
        again("tables/scans.parquet"),
    output:
        f"{RESULTS}/tables/scans.parquet",
    log:
        f"{RESULTS}/logs/scans.log",
    benchmark:
        f"{RESULTS}/benchmarks/scans.tsv"
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    resources:
        runtime=lambda wildcards, attempt: attempt * 60,
    params:
        study=STUDY.name,
        scans={name: (scan.axes, scan.cycles) for name, scan in STUDY.scans.items()},
        solver=STUDY.solver,
        frequencies=STUDY.frequencies,
        study_part=STUDY.part("scans"),
        code=SCANNING_CODE,
    message:
        "moving the clamp through the scans"
    script:
        "../scripts/scans.py"


rule states:
    input:
        again("tables/states.parquet"),
    output:
        f"{RESULTS}/tables/states.parquet",
    log:
        f"{RESULTS}/logs/states.log",
    benchmark:
        f"{RESULTS}/benchmarks/states.tsv"
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        study=STUDY.name,
        states={name: state.params(STUDY.contact) for name, state in STUDY.states.items()},
        frequencies=STUDY.frequencies,
        study_part=STUDY.part("states"),
        code=SOLVING_CODE,
    message:
        "solving single states"
    script:
        "../scripts/states.py"


rule comparisons:
    input:
        again("tables/comparisons.parquet"),
    output:
        f"{RESULTS}/tables/comparisons.parquet",
    log:
        f"{RESULTS}/logs/comparisons.log",
    benchmark:
        f"{RESULTS}/benchmarks/comparisons.tsv"
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    resources:
        runtime=lambda wildcards, attempt: attempt * 60,
    params:
        study=STUDY.name,
        comparisons={name: one.axes for name, one in STUDY.comparisons.items()},
        study_part=STUDY.part("comparisons"),
        code=SOLVING_CODE,
    message:
        "solving points in both kinds of contact"
    script:
        "../scripts/comparisons.py"
