# Figures, drawn from the tables alone.


rule figure:
    input:
        table=lambda wildcards: f"{RESULTS}/tables/{STUDY.figures[wildcards.figure].table}.parquet",
        code=sources_file("figures.draw", "tables.query", "pipeline.jobs"),
    output:
        report(
            f"{RESULTS}/figures/{{figure}}.svg",
            caption="../report/figure.rst",
            category="Figures",
            labels={"figure": "{figure}"},
        ),
        f"{RESULTS}/figures/{{figure}}.pdf",
        f"{RESULTS}/figures/{{figure}}.png",
    log:
        f"{RESULTS}/logs/figure/{{figure}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/figure/{{figure}}.tsv"
    localrule: True
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        kind=lambda wildcards: STUDY.figures[wildcards.figure].kind,
        table=lambda wildcards: STUDY.figures[wildcards.figure].table,
        selection=lambda wildcards: STUDY.figures[wildcards.figure].selection(),
        caption=lambda wildcards: STUDY.figures[wildcards.figure].caption,
    message:
        "drawing {wildcards.figure}"
    script:
        "../scripts/figure.py"


rule captions:
    input:
        code=sources_file("pipeline.jobs", "files"),
    output:
        f"{RESULTS}/figures/captions.md",
    log:
        f"{RESULTS}/logs/captions.log",
    benchmark:
        f"{RESULTS}/benchmarks/captions.tsv"
    localrule: True
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        captions={name: figure.caption for name, figure in STUDY.figures.items()},
    message:
        "writing the captions"
    script:
        "../scripts/captions.py"
