# Shapes and clamp reactions step by step, and both contact models side by side:
# scans.parquet, states.parquet, comparisons.parquet.


rule scan:
    input:
        curves=lambda wildcards: expand(rules.curves.output, block=blocks_of_scan(wildcards.scan)),
        code=sources_file("sticking.cycles", "tables.records", "tables.store", "pipeline.jobs"),
    output:
        f"{RESULTS}/blocks/{STUDY.blocks_name}/{{scan}}.scan.parquet",
    log:
        f"{RESULTS}/logs/scan/{{scan}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/scan/{{scan}}.tsv"
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    resources:
        runtime=lambda wildcards, attempt: attempt
        * costs.minutes(
            costs.scan_seconds(
                STUDY.scan_grids[wildcards.scan], STUDY.scans[wildcards.scan].cycles
            )
        ),
        mem_mb=lambda wildcards, attempt: attempt
        * megabytes_of_blocks(blocks_of_scan(wildcards.scan)),
    params:
        study=STUDY.name,
        grid=lambda wildcards: encode_grid(STUDY.scan_grids[wildcards.scan]),
        cycles=lambda wildcards: STUDY.scans[wildcards.scan].cycles,
        contact=STUDY.contact.value,
        by_step=STUDY.method.by_step,
    message:
        "moving the clamp through scan {wildcards.scan}"
    script:
        "../scripts/scan.py"


rule scans:
    input:
        scans=expand(rules.scan.output, scan=STUDY.scans),
        code=sources_file("tables.collect", "pipeline.jobs"),
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
        study_file=study_file("scans"),
    message:
        "collecting the table of scans"
    script:
        "../scripts/scans.py"


rule states:
    input:
        code=sources_file("sticking.api", "tables.records", "tables.store", "pipeline.jobs"),
    output:
        f"{RESULTS}/tables/states.parquet",
    log:
        f"{RESULTS}/logs/states.log",
    benchmark:
        f"{RESULTS}/benchmarks/states.tsv"
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    resources:
        runtime=lambda wildcards, attempt: attempt * costs.minutes(costs.STATE * len(STUDY.states)),
    params:
        study=STUDY.name,
        states={
            name: {
                "theta": float(state.theta),
                "eta": float(state.eta),
                "x1": float(state.x1),
                "contact": (state.contact or STUDY.contact).value,
            }
            for name, state in STUDY.states.items()
        },
        study_file=study_file("states"),
    message:
        "solving single states"
    script:
        "../scripts/states.py"


rule comparisons:
    input:
        code=sources_file("sticking.comparison", "tables.records", "tables.store", "pipeline.jobs"),
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
        runtime=lambda wildcards, attempt: attempt
        * costs.minutes(
            sum(
                costs.comparison_seconds(comparison.axes["theta"], comparison.axes["eta"])
                for comparison in STUDY.comparisons.values()
            )
        ),
    params:
        study=STUDY.name,
        comparisons={
            name: {axis: encode_values(values) for axis, values in comparison.axes.items()}
            for name, comparison in STUDY.comparisons.items()
        },
        study_file=study_file("comparisons"),
    message:
        "solving points in both contact models"
    script:
        "../scripts/comparisons.py"
