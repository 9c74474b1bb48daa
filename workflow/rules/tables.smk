# From the study file to the tables: those of grids and scans by chunks, the others by one job each.


rule chunk:
    input:
        force_outdated("chunks/{chunk}.parquet"),
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
        chunk=lambda wildcards: STUDY.chunks[wildcards.chunk].params,
        solver=STUDY.solver_settings,
        # Stored in the file: rule `stiction` refuses a chunk of another study file.
        study_part=lambda wildcards: STUDY.chunk_part(wildcards.chunk),
        code=SOLVING_CODE,
    message:
        "solving {wildcards.chunk}"
    script:
        "../scripts/chunk.py"


rule stiction:
    input:
        force_outdated("tables/stiction.parquet"),
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
        table="stiction",
        chunk_parts=list(map(STUDY.chunk_part, STUDY.chunks)),
        study_part=STUDY.study_part("stiction"),
        code=SOLVING_CODE,
    message:
        "joining the chunks into one table"
    script:
        "../scripts/joined.py"


rule scan_chunk:
    input:
        force_outdated(
            "scan_chunks/scans/{scan_chunk}.parquet", "scan_chunks/periods/{scan_chunk}.parquet"
        ),
    output:
        steps=f"{RESULTS}/scan_chunks/scans/{{scan_chunk}}.parquet",
        periods=f"{RESULTS}/scan_chunks/periods/{{scan_chunk}}.parquet",
    log:
        f"{RESULTS}/logs/scan_chunks/{{scan_chunk}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/scan_chunks/{{scan_chunk}}.tsv"
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    resources:
        runtime=lambda wildcards, attempt: attempt
        * STUDY.scan_chunks[wildcards.scan_chunk].minutes(),
    params:
        study=STUDY.name,
        chunk=lambda wildcards: STUDY.scan_chunks[wildcards.scan_chunk].params,
        solver=STUDY.solver_settings,
        # Stored in the files: rules `scans` and `periods` refuse chunks of another study file.
        study_part=lambda wildcards: STUDY.scan_chunk_part(wildcards.scan_chunk),
        code=SCANNING_CODE,
    message:
        "moving the clamp through {wildcards.scan_chunk}"
    script:
        "../scripts/scan_chunk.py"


rule scans:
    input:
        force_outdated("tables/scans.parquet"),
        chunks=expand(rules.scan_chunk.output.steps, scan_chunk=STUDY.scan_chunks),
    output:
        f"{RESULTS}/tables/scans.parquet",
    log:
        f"{RESULTS}/logs/scans.log",
    benchmark:
        f"{RESULTS}/benchmarks/scans.tsv"
    localrule: True
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        table="scans",
        chunk_parts=list(map(STUDY.scan_chunk_part, STUDY.scan_chunks)),
        study_part=STUDY.study_part("scans"),
        code=SCANNING_CODE,
    message:
        "joining the steps of all scans into one table"
    script:
        "../scripts/joined.py"


rule periods:
    input:
        force_outdated("tables/periods.parquet"),
        chunks=expand(rules.scan_chunk.output.periods, scan_chunk=STUDY.scan_chunks),
    output:
        f"{RESULTS}/tables/periods.parquet",
    log:
        f"{RESULTS}/logs/periods.log",
    benchmark:
        f"{RESULTS}/benchmarks/periods.tsv"
    localrule: True
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        table="periods",
        chunk_parts=list(map(STUDY.scan_chunk_part, STUDY.scan_chunks)),
        study_part=STUDY.study_part("periods"),
        code=SCANNING_CODE,
    message:
        "joining the periods of all scans into one table"
    script:
        "../scripts/joined.py"


rule reading_chunk:
    input:
        force_outdated("reading_chunks/{reading_chunk}.parquet"),
    output:
        f"{RESULTS}/reading_chunks/{{reading_chunk}}.parquet",
    log:
        f"{RESULTS}/logs/reading_chunks/{{reading_chunk}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/reading_chunks/{{reading_chunk}}.tsv"
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    resources:
        runtime=lambda wildcards, attempt: attempt
        * STUDY.reading_chunks[wildcards.reading_chunk].minutes(),
    params:
        study=STUDY.name,
        chunk=lambda wildcards: STUDY.reading_chunks[wildcards.reading_chunk].params,
        solver=STUDY.reading_settings,
        # Stored in the file: rule `friction` refuses a chunk of another study file.
        study_part=lambda wildcards: STUDY.reading_chunk_part(wildcards.reading_chunk),
        code=READING_CODE,
    message:
        "reading friction in {wildcards.reading_chunk}"
    script:
        "../scripts/reading_chunk.py"


rule friction:
    input:
        force_outdated("tables/friction.parquet"),
        chunks=expand(rules.reading_chunk.output, reading_chunk=STUDY.reading_chunks),
    output:
        f"{RESULTS}/tables/friction.parquet",
    log:
        f"{RESULTS}/logs/friction.log",
    benchmark:
        f"{RESULTS}/benchmarks/friction.tsv"
    localrule: True
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        table="friction",
        chunk_parts=list(map(STUDY.reading_chunk_part, STUDY.reading_chunks)),
        study_part=STUDY.study_part("friction"),
        code=READING_CODE,
    message:
        "joining the readings of all recordings into one table"
    script:
        "../scripts/joined.py"


rule states:
    input:
        force_outdated("tables/states.parquet"),
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
        study_part=STUDY.study_part("states"),
        code=SOLVING_CODE,
    message:
        "solving single states"
    script:
        "../scripts/states.py"


rule comparisons:
    input:
        force_outdated("tables/comparisons.parquet"),
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
        study_part=STUDY.study_part("comparisons"),
        code=SOLVING_CODE,
    message:
        "solving points in both kinds of contact"
    script:
        "../scripts/comparisons.py"
