# From the grid to stiction.parquet: curves are solved in blocks, grid points read off them.


rule curves:
    input:
        code=sources_file(
            f"sticking.solving.{STUDY.method}", "tables.records", "tables.store", "pipeline.jobs"
        ),
    output:
        f"{RESULTS}/blocks/{STUDY.blocks_name}/{{block}}.curves.parquet",
    log:
        f"{RESULTS}/logs/curves/{{block}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/curves/{{block}}.tsv"
    group:
        GROUP
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    resources:
        runtime=lambda wildcards, attempt: attempt * minutes_of_block(wildcards.block),
        mem_mb=lambda wildcards, attempt: attempt * megabytes_of_blocks([wildcards.block]),
    params:
        method=STUDY.method.value,
        contact=STUDY.contact.value,
        section=STUDY.section.value,
        curves=lambda wildcards: encode_box(BLOCKS[wildcards.block]),
    message:
        "solving the sticking curves of block {wildcards.block}"
    script:
        "../scripts/curves.py"


rule points:
    input:
        curves=rules.curves.output,
        neighbours=lambda wildcards: expand(
            rules.curves.output, block=neighbours_of_block(wildcards.block)
        ),
        code=sources_file(
            "tables.added", "tables.refining", "sticking.solving.collocation", "pipeline.jobs"
        ),
    output:
        f"{RESULTS}/blocks/{STUDY.blocks_name}/{{block}}.points.parquet",
    log:
        f"{RESULTS}/logs/points/{{block}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/points/{{block}}.tsv"
    group:
        GROUP
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    resources:
        runtime=lambda wildcards, attempt: attempt
        * costs.minutes(seconds_of_points(wildcards.block)),
        mem_mb=lambda wildcards, attempt: attempt
        * megabytes_of_blocks([wildcards.block, *neighbours_of_block(wildcards.block)]),
    params:
        study=STUDY.name,
        contact=STUDY.contact.value,
        section=STUDY.section.value,
        grids=lambda wildcards: {
            name: encode_grid(part) for name, part in GRIDS_OF(BLOCKS[wildcards.block]).items()
        },
        refining=lambda wildcards: refining_of_block(wildcards.block),
    message:
        "reading grid points off block {wildcards.block}"
    script:
        "../scripts/points.py"


rule stiction:
    input:
        points=expand(rules.points.output, block=POINT_BLOCKS),
        code=sources_file("tables.collect", "tables.completeness", "study.codec", "pipeline.jobs"),
    output:
        f"{RESULTS}/tables/stiction.parquet",
    log:
        f"{RESULTS}/logs/stiction.log",
    benchmark:
        f"{RESULTS}/benchmarks/stiction.tsv"
    localrule: True
    conda:
        "../envs/vibrissa.yaml"
    threads: COLLECTING_THREADS
    params:
        grids={name: encode_grid(grid) for name, grid in STUDY.point_grids.items()},
        refined=list(STUDY.refinements),
        refining={block: refining_of_block(block) for block in POINT_BLOCKS if STUDY.refinements},
        study_file=study_file("grids"),
    message:
        "collecting the table of grid points"
    script:
        "../scripts/stiction.py"
