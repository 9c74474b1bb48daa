# Everything on one web page that needs nothing else: results/<study>/report.html.


rule report:
    input:
        stiction=f"{RESULTS}/tables/stiction.parquet",
        scans=f"{RESULTS}/tables/scans.parquet" if STUDY.scans else [],
        states=f"{RESULTS}/tables/states.parquet" if STUDY.states else [],
        comparisons=f"{RESULTS}/tables/comparisons.parquet" if STUDY.comparisons else [],
        claims=f"{RESULTS}/tables/claims.parquet" if STUDY.claims else [],
        svg=expand(f"{RESULTS}/figures/{{figure}}.svg", figure=STUDY.figures),
        png=expand(f"{RESULTS}/figures/{{figure}}.png", figure=STUDY.figures),
        proofs=places.proofs(STUDY.name),
        code=sources_file("report.page", "tables.query", "files", "pipeline.jobs"),
    output:
        f"{RESULTS}/report.html",
    log:
        f"{RESULTS}/logs/report.log",
    benchmark:
        f"{RESULTS}/benchmarks/report.tsv"
    localrule: True
    conda:
        "../envs/vibrissa.yaml"
    threads: 1
    params:
        study=STUDY.name,
        captions={name: figure.caption for name, figure in STUDY.figures.items()},
        study_files=study_texts(),
        # Of the jobs that make the study as it is now; an earlier grid leaves others. The plain
        # texts that `expand` makes of them can be handed to a job.
        benchmarks={
            "curves": expand(rules.curves.benchmark, block=BLOCKS),
            "points": expand(rules.points.benchmark, block=POINT_BLOCKS),
            "stiction": expand(rules.stiction.benchmark),
            "scan": expand(rules.scan.benchmark, scan=STUDY.scans),
            "scans": expand(rules.scans.benchmark) if STUDY.scans else [],
            "states": expand(rules.states.benchmark) if STUDY.states else [],
            "comparisons": expand(rules.comparisons.benchmark) if STUDY.comparisons else [],
            "claims": expand(rules.claims.benchmark) if STUDY.claims else [],
            "figure": expand(rules.figure.benchmark, figure=STUDY.figures),
        },
    message:
        "putting everything on one page"
    script:
        "../scripts/report.py"
