# Figures, drawn from the tables alone.

FIGURE_TABLES = {
    "taper": "stiction",
    "friction": "stiction",
    "locking": "stiction",
    "regimes": "stiction",
    "law": "stiction",
    "scan": "scans",
    "period": "scans",
    "signals": "scans",
    "state": "states",
    "models": "comparisons",
}


rule figure:
    input:
        table=lambda wildcards: "{}/tables/{}.parquet".format(
            RESULTS, FIGURE_TABLES[STUDY.figures[wildcards.figure]["kind"]]
        ),
        code=sources("figures", "tables", "jobs"),
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
    threads: 1
    params:
        figure=lambda wildcards: STUDY.figures[wildcards.figure],
        table=lambda wildcards: FIGURE_TABLES[STUDY.figures[wildcards.figure]["kind"]],
    message:
        "drawing {wildcards.figure}"
    script:
        "../scripts/figure.py"


rule captions:
    input:
        code=sources("jobs", "files"),
    output:
        f"{RESULTS}/figures/captions.md",
    log:
        f"{RESULTS}/logs/captions.log",
    benchmark:
        f"{RESULTS}/benchmarks/captions.tsv"
    localrule: True
    threads: 1
    params:
        captions={name: figure.get("caption", "") for name, figure in STUDY.figures.items()},
    message:
        "writing the captions"
    script:
        "../scripts/captions.py"
